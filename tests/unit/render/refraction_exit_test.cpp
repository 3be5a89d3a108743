// SPDX-License-Identifier: Apache-2.0
// A clear shell on a box: a ray that enters through the top near an edge leaves through the side.
#include "stfLib/optics/fresnel.h"
#include "stfLib/render/renderer.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#include "tests/unit/support/files.h"

namespace stf::test {
namespace {

// Ten millimetres wide; the origin lies on its top, one from the edge at -y.
ControlMesh box() {
    ControlMesh m;
    m.scheme = ControlMesh::Scheme::None;
    m.points = {{-5, -1, -10}, {5, -1, -10}, {5, 9, -10}, {-5, 9, -10}, {-5, -1, 0}, {5, -1, 0}, {5, 9, 0}, {-5, 9, 0}};
    m.faceVertexCounts.assign(6, 4);
    m.faceVertexIndices = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};
    m.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int f = 0; f < 6; ++f) {
        m.uvIndices.insert(m.uvIndices.end(), {0, 1, 2, 3});
    }
    return m;
}

struct Seen {
    double color = 0, reflection = 0, alpha = 0;
};

// In a white dome, along rays at `cosine` to the top, towards the edge.
Seen look(double ior, double cosine) {
    const TemporaryFolder folder;
    SampleOptions o;
    o.size = {1, 1, 8};
    o.voxelMm = 0.5;
    o.extinction = Rgb(0.0f);
    BaseVolume v = makeSample("uniform", o);
    v.ior.assign(v.voxelCount(), float(ior));
    const std::string path = folder.file("clear.vdb");
    writeBaseVolume(v, path);

    Scene scene;
    scene.setMetersPerUnit(0.001);
    scene.setMesh("/box", box(), 0);
    StfBinding binding;
    binding.baseVolume = path;
    binding.quality = 0.1f;
    binding.coreModel = "none";
    scene.setStf("/box", binding);
    scene.setInstances("/box", {MeshInstance()});
    Light dome;
    dome.type = Light::Type::Dome;
    dome.emission = Rgb(1.0f);
    scene.setLight("/dome", dome);

    constexpr int kSize = 4;
    Renderer renderer;
    RenderSettings settings;
    settings.samples = 1024;
    renderer.setSettings(settings);
    const double s = std::sqrt(1 - cosine * cosine);
    const Matrix4 view{1, 0, 0, 0, 0, cosine, s, 0, 0, -s, cosine, 0, 0, 0, -100, 1};
    const Matrix4 projection{20, 0, 0, 0, 0, 20, 0, 0, 0, 0, -0.005, 0, 0, 0, -1, 1};
    renderer.setCamera(Camera(view, projection), kSize, kSize);
    Progress progress;
    renderer.prepare(scene, progress);
    renderer.restart();
    while (!renderer.converged()) {
        renderer.renderPass(progress);
    }
    Seen mean;
    const std::vector<float> color = renderer.film().read(Aov::Color),
                             reflection = renderer.film().read(Aov::StfReflection);
    for (std::size_t i = 0; i < kSize * kSize; ++i) {
        mean.color += double(color[4 * i]) / (kSize * kSize);
        mean.alpha += double(color[4 * i + 3]) / (kSize * kSize);
        mean.reflection += double(reflection[3 * i]) / (kSize * kSize);
    }
    return mean;
}

TEST(RefractionExit, BothFresnelFactorsAndNoIndexSquared) {
    const double ior = 1.2, cosine = 0.5;
    const auto in = fresnelSplit<double>(cosine, ior);
    const double inside = std::sqrt(1 - in.cosT * in.cosT); // to the normal of the side
    const auto out = fresnelSplit<double>(inside, 1 / ior);
    ASSERT_LT(out.reflectance, 0.5);
    const Seen seen = look(ior, cosine);
    EXPECT_NEAR(seen.reflection, in.reflectance, 0.003);
    // What is reflected at the side is not followed.
    EXPECT_NEAR(seen.color, in.reflectance + (1 - in.reflectance) * (1 - out.reflectance), 0.003);
    EXPECT_NEAR(seen.alpha, 1, 0.003);
}

// Glass shows no dome through a right angle: only what the top mirrors is left.
TEST(RefractionExit, TotalReflectionEndsThePath) {
    const Seen seen = look(1.5, 0.5);
    const double mirrored = fresnelSplit<double>(0.5, 1.5).reflectance;
    EXPECT_NEAR(seen.reflection, mirrored, 1e-5);
    EXPECT_NEAR(seen.color, mirrored, 1e-5);
}

TEST(RefractionExit, IndexOneIsInvisible) {
    const Seen seen = look(1, 0.5);
    EXPECT_NEAR(seen.color, 1, 1e-6);
    EXPECT_EQ(seen.reflection, 0);
}

} // namespace
} // namespace stf::test
