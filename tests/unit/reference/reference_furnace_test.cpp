// SPDX-License-Identifier: Apache-2.0
// White furnaces of closed objects: what scatters all light and lies in uniform light cannot be seen.
#include "stfLib/reference/reference_integrator.h"
#include "tests/unit/render/slab_fixture.h"

namespace stf::test {
namespace {

struct Furnace {
    bool relief = false;
    double ior = 1;
    bool core = true;
    double coreAbsorption = 0;
};

// A ball of about 4 mm radius (a subdivided cube) in a dome of radiance 1, straight from above.
std::vector<float> picture(const Furnace& f, const std::string& integrator, int samples, Aov aov = Aov::Color) {
    Slab sample;
    sample.relief = f.relief;
    sample.albedo = 1;
    sample.tau = 1;
    sample.ior = f.ior;
    sample.g = 0.3;
    Scene scene;
    scene.setMetersPerUnit(0.001);
    ControlMesh cube;
    for (int i = 0; i < 8; ++i) {
        cube.points.push_back({i & 1 ? 5.0f : -5.0f, i & 2 ? 5.0f : -5.0f, i & 4 ? 5.0f : -5.0f});
    }
    cube.faceVertexCounts = {4, 4, 4, 4, 4, 4};
    cube.faceVertexIndices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    scene.setMesh("/ball", cube, 2);
    StfBinding binding;
    binding.baseVolume = sample.volumePath();
    binding.coreModel = f.core ? "walk" : "none";
    binding.coreSigmaA = Rgb(float(f.coreAbsorption));
    binding.coreSigmaSPrime = Rgb(0.8f, 1.0f, 0.5f);
    scene.setStf("/ball", binding);
    scene.setInstances("/ball", {MeshInstance()});
    Light dome;
    dome.type = Light::Type::Dome;
    dome.emission = Rgb(1.0f);
    scene.setLight("/dome", dome);
    Renderer renderer({}, {}, &ReferenceIntegrator::maker);
    RenderSettings settings;
    settings.integrator = integrator;
    settings.samples = samples;
    renderer.setSettings(settings);
    Progress progress;
    renderer.prepare(scene, progress);
    const Matrix4 worldToView{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -100, 1};
    const Matrix4 projection{0.2, 0, 0, 0, 0, 0.2, 0, 0, 0, 0, -0.005, 0, 0, 0, -1, 1};
    renderer.setCamera(Camera(worldToView, projection), 12, 12);
    while (!renderer.converged()) {
        renderer.renderPass(progress);
    }
    return renderer.film().read(aov);
}

class ReferenceFurnace : public testing::TestWithParam<Furnace> {};

// Where the surface refracts no sample of the dome is taken: every path carries the sum of its channels to it, exactly.
// Elsewhere lights are asked for, and it is right on average.
TEST_P(ReferenceFurnace, IsInvisible) {
    const bool exact = GetParam().ior != 1;
    const std::vector<float> p = picture(GetParam(), "reference", exact ? 16 : 256);
    double sum = 0, squares = 0;
    const double n = double(p.size() / 4);
    for (std::size_t i = 0; i < p.size(); i += 4) {
        const double mean = double(p[i] + p[i + 1] + p[i + 2]) / 3;
        if (exact) {
            ASSERT_NEAR(mean, 1, 2e-5) << "pixel " << i / 4;
        }
        sum += mean / n;
        squares += mean * mean / n;
    }
    const double error = std::sqrt(std::max(0.0, squares - sum * sum) / (n - 1));
    EXPECT_LT(error, 0.01);
    EXPECT_NEAR(sum, 1, 4 * error + 2e-5);
}
INSTANTIATE_TEST_SUITE_P(Cases, ReferenceFurnace,
                         testing::Values(Furnace{false, 1}, Furnace{false, 1.5}, Furnace{true, 1}, Furnace{true, 1.4}));

} // namespace
} // namespace stf::test
