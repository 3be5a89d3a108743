// SPDX-License-Identifier: Apache-2.0
// What the plan leaves out is not missed: the image is that of a scene in which the stage runs and finds nothing, or
// next to nothing, to do. How much time that saves: bench/left_out.py.
#include "stfLib/render/renderer.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#include "tests/unit/support/files.h"
#include "tests/unit/support/square_mesh.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <map>

namespace stf::test {
namespace {

constexpr int kSize = 8;

// A shell on a square, seen from above under an oblique sun.
struct Arrangement {
    BaseVolume volume;
    ControlMesh mesh = squareMesh({0, 0, 0}, {8, 0, 0}, {0, 8, 0});
    StfBinding binding;
    RenderSettings settings;
    CameraOptics optics;
    std::function<void(Scene&)> more; // into the scene
};

using Change = std::function<void(Arrangement&)>;

struct Picture {
    std::vector<float> color;
    double mean = 0, error = 0; // of the green, and its standard error
    std::vector<PlanEntry> plan;

    bool runs(const std::string& object, const std::string& stage) const {
        for (const PlanEntry& e : plan) {
            if (e.object == object && e.stage == stage) {
                return e.runs;
            }
        }
        ADD_FAILURE() << "the plan has no line for " << stage << " of " << object;
        return false;
    }
};

class LeftOut : public ::testing::Test {
protected:
    LeftOut() {
        SampleOptions o;
        o.size = {4, 4, 8};
        o.voxelMm = 0.5;
        given_.volume = makeSample("uniform", o);
        given_.binding.quality = 0.05f;
        given_.binding.coreSigmaA = Rgb(0.02f);
        given_.binding.coreSigmaSPrime = Rgb(1.0f);
        given_.binding.coreModel = "dipole";
        given_.settings.samples = 64;
    }

    Picture picture(const Change& change = {}) {
        Arrangement s = given_;
        if (change) {
            change(s);
        }
        const std::string path = (folder_.path() / (s.volume.contentHash() + ".vdb")).string();
        writeBaseVolume(s.volume, path);
        s.binding.baseVolume = path;
        Scene scene;
        scene.setMetersPerUnit(0.001);
        scene.setMesh("/shell", s.mesh, 0);
        scene.setStf("/shell", s.binding);
        scene.setInstances("/shell", {MeshInstance()});
        Light sun;
        sun.emission = Rgb(3.0f);
        sun.lightToWorld.y = {0, 0.8, 0.6};
        sun.lightToWorld.z = {0, -0.6, 0.8};
        scene.setLight("/sun", sun);
        if (s.more) {
            s.more(scene);
        }
        Renderer renderer([this](const std::shared_ptr<const BaseVolume>& volume, const TransportOptions& options,
                                 Progress& progress, const MessageSink& sink) {
            std::shared_ptr<const StfTable>& table = tables_[volume->contentHash() + options.key()];
            table = table ? table : std::make_shared<const StfTable>(precompute(*volume, options, progress, sink));
            return table;
        });
        renderer.setSettings(s.settings);
        const Matrix4 view{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -50, 1};
        const Matrix4 projection{0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, -0.01, 0, 0, 0, -1, 1};
        renderer.setCamera(Camera(view, projection, s.optics), kSize, kSize);
        Progress progress;
        renderer.prepare(scene, progress);
        while (!renderer.converged()) {
            renderer.renderPass(progress);
        }
        Picture p;
        p.color = renderer.film().read(Aov::Color);
        p.plan = renderer.plan();
        double squares = 0;
        const double n = kSize * kSize;
        for (std::size_t i = 1; i < p.color.size(); i += 4) {
            p.mean += double(p.color[i]) / n;
            squares += double(p.color[i]) * double(p.color[i]) / n;
        }
        p.error = std::sqrt(std::max(0.0, squares - p.mean * p.mean) / (n - 1));
        EXPECT_GT(p.mean, 0.01);
        return p;
    }

    /// The means agree within four standard errors and `relative`; the noise is too small to hide more than 2 %.
    static void expectSame(const Picture& without, const Picture& with, double relative) {
        const double error = std::hypot(without.error, with.error);
        EXPECT_LT(error, 0.005 * without.mean);
        EXPECT_NEAR(without.mean, with.mean, 4 * error + relative * without.mean);
    }

    Arrangement given_;

private:
    TemporaryFolder folder_;
    std::map<std::string, std::shared_ptr<const StfTable>> tables_;
};

TEST_F(LeftOut, WalksWhereNothingScatters) {
    const auto glowing = [](float albedo) {
        return [albedo](Arrangement& s) {
            s.volume.albedo.assign(s.volume.voxelCount(), Rgb(albedo));
            s.volume.emission.assign(s.volume.voxelCount(), Rgb(1.0f));
            s.binding.coreModel = "none";
        };
    };
    const Picture without = picture(glowing(0)), with = picture(glowing(1e-3f));
    EXPECT_FALSE(without.runs("/shell", "transport"));
    EXPECT_TRUE(with.runs("/shell", "transport"));
    expectSame(without, with, 3e-3); // what a thousandth of the extinction scatters of emission and sun
}

TEST_F(LeftOut, CoreThatIsBlack) {
    const Picture without = picture([](Arrangement&s) { s.binding.coreModel = "none"; }),
                  with = picture([](Arrangement&s) {
                      s.binding.coreSigmaA = Rgb(10.0f);
                      s.binding.coreSigmaSPrime = Rgb(1e-3f);
                  });
    EXPECT_FALSE(without.runs("/shell", "core"));
    EXPECT_TRUE(with.runs("/shell", "core"));
    expectSame(without, with, 1e-3);
}

TEST_F(LeftOut, CoreBelowAShellThatIsOpaque) {
    // Of light that gets through twelve mean free paths the core sends back a little.
    const auto opaque = [](Arrangement& s) { s.volume.extinction.assign(s.volume.voxelCount(), Rgb(8.0f)); };
    const Picture without = picture([&](Arrangement&s) {
        opaque(s);
        s.binding.coreModel = "none";
    }),
                  with = picture(opaque);
    EXPECT_FALSE(without.runs("/shell", "core"));
    EXPECT_TRUE(with.runs("/shell", "core"));
    expectSame(without, with, 0.005);
}

TEST_F(LeftOut, FresnelOfIndexOne) {
    const auto index = [](float ior) {
        return [ior](Arrangement& s) { s.volume.ior.assign(s.volume.voxelCount(), ior); };
    };
    const Picture without = picture(index(1)), with = picture(index(1.0005f));
    EXPECT_FALSE(without.runs("/shell", "fresnel"));
    EXPECT_TRUE(with.runs("/shell", "fresnel"));
    // n^2, and the two tables' noise.
    expectSame(without, with, 0.02);
}

TEST_F(LeftOut, GridsThatHoldNothing) {
    const Picture without = picture();
    EXPECT_EQ(without.color,
              picture([](Arrangement& s) { s.volume.emission.assign(s.volume.voxelCount(), Rgb(0.0f)); }).color);
    EXPECT_EQ(without.color, picture([](Arrangement& s) { s.volume.ior.assign(s.volume.voxelCount(), 1.0f); }).color);
    EXPECT_EQ(without.color, picture([](Arrangement& s) { s.volume.g.assign(s.volume.voxelCount(), 0.0f); }).color);
}

TEST_F(LeftOut, LightsThatGiveNone) {
    const auto dark = [](bool visible, float emission) {
        return [=](Arrangement& s) {
            s.more = [=](Scene& scene) {
                for (int i = 0; i < 5; ++i) {
                    Light light;
                    light.type = i % 2 ? Light::Type::Sphere : Light::Type::Dome;
                    light.lightToWorld.translation = {double(i), 0, 20};
                    light.emission = Rgb(emission);
                    light.visible = visible;
                    scene.setLight("/dark" + std::to_string(i), light);
                }
            };
        };
    };
    const Picture without = picture();
    EXPECT_EQ(without.color, picture(dark(true, 0)).color);
    EXPECT_EQ(without.color, picture(dark(false, 1)).color);
    expectSame(without, picture(dark(true, 1e-5f)), 1e-4); // these are asked
}

TEST_F(LeftOut, BouncesWhereThereIsNoPlainSurface) {
    const auto blackBelow = [](Arrangement& s) {
        s.more = [](Scene& scene) {
            ControlMesh ground = squareMesh({0, 0, -20}, {100, 0, 0}, {0, 100, 0});
            ground.colors = {Rgb(0.0f)};
            scene.setMesh("/ground", ground, 0);
            scene.setInstances("/ground", {MeshInstance()});
        };
    };
    const Picture without = picture(), with = picture(blackBelow),
                  direct = picture([](Arrangement&s) { s.settings.maxDepth = 0; });
    EXPECT_FALSE(without.runs("scene", "bounces"));
    EXPECT_TRUE(with.runs("scene", "bounces"));
    EXPECT_FALSE(direct.runs("scene", "indirect"));
    expectSame(without, with, 0);
    expectSame(without, direct, 0);
}

TEST_F(LeftOut, LensOfAPinhole) {
    const auto lens = [](double radius, bool depthOfField) {
        return [=](Arrangement& s) {
            s.optics.lens = {radius, 50};
            s.settings.depthOfField = depthOfField;
        };
    };
    const Picture without = picture(), with = picture(lens(1e-6, true));
    EXPECT_FALSE(without.runs("scene", "lens"));
    EXPECT_TRUE(with.runs("scene", "lens"));
    EXPECT_EQ(without.color, picture(lens(2, false)).color);
    EXPECT_EQ(without.color, picture(lens(0, true)).color);
    expectSame(without, with, 0);
}

TEST_F(LeftOut, MotionOfWhatIsAtRest) {
    const auto moves = [](double by) {
        return [by](Arrangement& s) {
            s.optics.shutter.open = -0.25;
            s.optics.shutter.close = 0.25;
            s.more = [by](Scene& scene) {
                MeshInstance instance;
                for (const double time : {-0.5, 0.5}) {
                    Transform t;
                    t.translation = {by * time, 0, 0};
                    instance.motion.push_back({time, t});
                }
                scene.setInstances("/shell", {instance});
            };
        };
    };
    const Picture without = picture(), with = picture(moves(1e-6));
    EXPECT_FALSE(without.runs("scene", "motion"));
    EXPECT_TRUE(with.runs("scene", "motion"));
    EXPECT_EQ(without.color, picture(moves(0)).color);
    expectSame(without, with, 0);
}

TEST_F(LeftOut, SubdivisionOfSchemeNone) {
    // A bilinear square subdivided is the same square.
    const Picture without = picture(), with = picture([](Arrangement&s) {
                                           s.mesh.scheme = ControlMesh::Scheme::Bilinear;
                                           s.more = [mesh = s.mesh](Scene& scene) { scene.setMesh("/shell", mesh, 3); };
                                       });
    expectSame(without, with, 0);
}

TEST_F(LeftOut, PoseOfAMeshAtRest) {
    const Picture without = picture(), with = picture([](Arrangement&s) { s.mesh.rest = s.mesh.points; });
    EXPECT_FALSE(with.runs("/shell", "pose"));
    EXPECT_EQ(without.color, with.color);
}

TEST_F(LeftOut, SynthesisWhereTextureCoordinatesTile) {
    const Picture without = picture(), with = picture([](Arrangement&s) {
                                           s.mesh.uvs.clear();
                                           s.mesh.uvIndices.clear();
                                       });
    EXPECT_FALSE(without.runs("/shell", "synthesis"));
    expectSame(without, with, 1e-3); // a sample that is the same everywhere: nothing to synthesize either
}

} // namespace
} // namespace stf::test
