// SPDX-License-Identifier: Apache-2.0
// What is shown while an edit is worked on, and passes that begin with few pixels.
#include "stfLib/reference/reference_integrator.h"
#include "stfLib/render/renderer.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#include "tests/unit/support/files.h"
#include "tests/unit/support/square_mesh.h"

#include <cmath>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr int kSize = 16;

class Drafts : public ::testing::Test {
protected:
    Drafts() : renderer_(tables()) {
        settings_.samples = 4;
        SampleOptions o;
        o.size = {1, 1, 4};
        o.voxelMm = 0.5;
        writeBaseVolume(makeSample("uniform", o), folder_.file("uniform.vdb"));
        scene_.setMetersPerUnit(0.001);
        ControlMesh mesh = squareMesh({0, 0, 0}, {8, 0, 0}, {0, 8, 0});
        mesh.colors = {{0.5f, 0.25f, 0.125f}};
        scene_.setMesh("/shell", mesh, 0);
        scene_.setInstances("/shell", {MeshInstance()});
        binding_.baseVolume = folder_.file("uniform.vdb");
        binding_.quality = 0.1f;
        binding_.coreSigmaA = Rgb(0.01f);
        binding_.coreSigmaSPrime = Rgb(1.0f);
        binding_.coreModel = "dipole";
        scene_.setStf("/shell", binding_);
        setLight(3.14159265f);
        setUp(renderer_);
    }

    TableProvider tables() {
        return [this](const std::shared_ptr<const BaseVolume>& volume, const TransportOptions& options,
                      Progress& progress, const MessageSink& messages) {
            ++made_;
            return std::make_shared<const StfTable>(precompute(*volume, options, progress, messages));
        };
    }
    void setUp(Renderer& renderer) const {
        renderer.setSettings(settings_);
        const Matrix4 view{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -50, 1};
        const Matrix4 projection{0.2, 0, 0, 0, 0, 0.2, 0, 0, 0, 0, -0.01, 0, 0, 0, -1, 1};
        renderer.setCamera(Camera(view, projection), kSize, kSize);
    }
    void setLight(float emission) {
        Light light;
        light.emission = Rgb(emission);
        scene_.setLight("/light", light);
    }

    std::vector<float> picture(Renderer& renderer) {
        renderer.restart();
        while (!renderer.converged()) {
            renderer.renderPass(progress_);
        }
        return renderer.film().read(Aov::Color);
    }
    std::vector<float> whole(Renderer& renderer) {
        renderer.prepare(scene_, progress_);
        return picture(renderer);
    }
    std::vector<float> fresh() {
        Renderer other(tables());
        setUp(other);
        return whole(other);
    }
    static double green(const std::vector<float>& image) {
        double sum = 0;
        for (std::size_t i = 1; i < image.size(); i += 4) {
            sum += double(image[i]) / (kSize * kSize);
        }
        return sum;
    }

    TemporaryFolder folder_;
    Scene scene_;
    StfBinding binding_;
    RenderSettings settings_;
    Progress progress_;
    int made_ = 0;
    Renderer renderer_;
};

TEST_F(Drafts, ANewShellShowsAsItsDisplayColorAtOnce) {
    ASSERT_TRUE(renderer_.prepareDraft(scene_, progress_));
    const std::vector<float> draft = picture(renderer_);
    EXPECT_EQ(made_, 0);
    EXPECT_NEAR(draft[0], 0.5f, 1e-3f); // irradiance pi on Lambert: the colour itself
    EXPECT_NEAR(draft[2], 0.125f, 1e-3f);
    EXPECT_EQ(whole(renderer_), fresh());
}

TEST_F(Drafts, AnEditedLightShinesBeforeCoresAreSolved) {
    const std::vector<float> before = whole(renderer_);
    setLight(2 * 3.14159265f);
    ASSERT_TRUE(renderer_.prepareDraft(scene_, progress_));
    const double draft = green(picture(renderer_)), once = green(before);
    const std::vector<float> after = whole(renderer_);
    EXPECT_NEAR(green(after), 2 * once, 1e-3 * once);
    // The shell is lit by the new light, its core still shines by the old one.
    EXPECT_GT(draft, 1.2 * once);
    EXPECT_LT(draft, 1.98 * once);
    EXPECT_EQ(after, fresh());
    EXPECT_EQ(made_, 2); // one for each renderer
}

TEST_F(Drafts, LightStaysWhereSolvingItWasCancelled) {
    whole(renderer_);
    setLight(2 * 3.14159265f);
    ASSERT_TRUE(renderer_.prepareDraft(scene_, progress_));
    const std::vector<float> draft = picture(renderer_);
    Progress cancelled;
    cancelled.cancel();
    EXPECT_THROW(renderer_.prepare(scene_, cancelled), Cancelled);
    ASSERT_TRUE(renderer_.prepareDraft(scene_, progress_));
    EXPECT_EQ(picture(renderer_), draft);
    EXPECT_EQ(whole(renderer_), fresh());
}

TEST_F(Drafts, AnEditedShellStaysAsItWasUntilItIsThere) {
    const std::vector<float> before = whole(renderer_);
    binding_.coreSigmaA = Rgb(5.0f);
    scene_.setStf("/shell", binding_);
    ASSERT_TRUE(renderer_.prepareDraft(scene_, progress_));
    EXPECT_EQ(picture(renderer_), before);
    const std::vector<float> after = whole(renderer_);
    EXPECT_LT(green(after), 0.95 * green(before));
    EXPECT_EQ(after, fresh());
}

TEST_F(Drafts, AShellOfTheReferenceHasNoTablesToShow) {
    Renderer renderer(tables(), {}, &ReferenceIntegrator::maker);
    settings_.integrator = "reference";
    setUp(renderer);
    whole(renderer);
    settings_.integrator = "stf";
    setUp(renderer);
    ASSERT_TRUE(renderer.prepareDraft(scene_, progress_));
    EXPECT_NEAR(picture(renderer)[0], 0.5f, 1e-3f); // as its displayColor
    EXPECT_EQ(whole(renderer), fresh());
}

TEST_F(Drafts, ThereIsNoneWhereItWouldShowNothingElse) {
    whole(renderer_);
    EXPECT_FALSE(renderer_.prepareDraft(scene_, progress_)) << "nothing changed";
    scene_.setStf("/shell", std::nullopt);
    EXPECT_FALSE(renderer_.prepareDraft(scene_, progress_)) << "no shells";
}

TEST_F(Drafts, StridesMakeTheSamePassPixelByPixel) {
    const std::vector<float> expected = whole(renderer_);
    renderer_.restart();
    for (const int stride : {8, 4, 2}) {
        ASSERT_TRUE(renderer_.renderPass(progress_, stride));
        int sampled = 0;
        for (int y = 0; y < kSize; ++y) {
            for (int x = 0; x < kSize; ++x) {
                const bool wanted = x % stride == 0 && y % stride == 0;
                EXPECT_EQ(renderer_.film().sampleCount(x, y), wanted ? 1u : 0u) << stride << " " << x << " " << y;
                sampled += wanted;
            }
        }
        EXPECT_EQ(sampled, kSize * kSize / (stride * stride));
        EXPECT_EQ(renderer_.stats().samplesDone, 0);
    }
    while (!renderer_.converged()) {
        renderer_.renderPass(progress_);
    }
    EXPECT_EQ(renderer_.film().read(Aov::Color), expected);
}

} // namespace
} // namespace stf::test
