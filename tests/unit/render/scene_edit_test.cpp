// SPDX-License-Identifier: Apache-2.0
// Edits redo only what they touch, and the image after an edit is that of a fresh renderer. Bad input is named, and the
// rest of the scene renders.
#include "stfLib/render/renderer.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr int kSize = 12;

class SceneEdits : public ::testing::Test {
protected:
    void SetUp() override {
        settings_.samples = 4;
        folder_ = std::filesystem::temp_directory_path() /
                  (std::string("stf_edit_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
        std::filesystem::create_directories(folder_);
        SampleOptions o;
        o.size = {1, 1, 4};
        o.voxelMm = 0.5;
        volume_ = (folder_ / "uniform.vdb").string();
        writeBaseVolume(makeSample("uniform", o), volume_);
        scene_.setMetersPerUnit(0.001);
        addQuad("/shell", -6);
        addQuad("/plain", 6);
        StfBinding binding;
        binding.baseVolume = volume_;
        binding.quality = 0.1f;
        scene_.setStf("/shell", binding);
        light_.emission = Rgb(3.14159265f);
        scene_.setLight("/light", light_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    // Ten by ten, its middle at x, normal +z.
    void addQuad(const std::string& id, float x) {
        ControlMesh m;
        m.scheme = ControlMesh::Scheme::None;
        m.points = {{x - 5, -5, 0}, {x + 5, -5, 0}, {x + 5, 5, 0}, {x - 5, 5, 0}};
        m.faceVertexCounts = {4};
        m.faceVertexIndices = {0, 1, 2, 3};
        m.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        m.uvIndices = {0, 1, 2, 3};
        m.colors = {{0.5f, 0.25f, 0.125f}};
        scene_.setMesh(id, m, 0);
        scene_.setInstances(id, {MeshInstance()});
    }

    TableProvider countingTables() {
        return [this](const std::shared_ptr<const BaseVolume>& volume, const TransportOptions& options,
                      Progress& progress, const MessageSink& messages) {
            ++tables_;
            auto table = std::make_shared<const StfTable>(precompute(*volume, options, progress, messages));
            made_.push_back(table);
            return table;
        };
    }

    std::vector<float> render(Renderer& renderer) {
        renderer.setMessages([this](Severity severity, const std::string& text) {
            messages_.push_back((severity == Severity::Error ? "error " : "") + text);
        });
        renderer.setSettings(settings_);
        const Matrix4 view{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -cameraAt_.x, -cameraAt_.y, -50 - cameraAt_.z, 1};
        const Matrix4 projection{0.08, 0, 0, 0, 0, 0.08, 0, 0, 0, 0, -0.01, 0, 0, 0, -1, 1};
        renderer.setCamera(Camera(view, projection), kSize, kSize);
        Progress progress;
        renderer.prepare(scene_, progress);
        renderer.restart();
        while (!renderer.converged()) {
            renderer.renderPass(progress);
        }
        return renderer.film().read(Aov::Color);
    }

    /// Takes the texture coordinates from the shell's mesh.
    void dropUvs() {
        ControlMesh m = *scene_.meshes().at("/shell").mesh;
        m.uvs.clear();
        m.uvIndices.clear();
        scene_.setMesh("/shell", m, 0);
    }
    static PlanEntry synthesis(const Renderer& renderer) {
        for (const PlanEntry& e : renderer.plan()) {
            if (e.stage == "synthesis") {
                return e;
            }
        }
        return {};
    }

    static Rgb pixel(const std::vector<float>& image, int x, int y) {
        const std::size_t i = std::size_t(y * kSize + x) * 4;
        return {image[i], image[i + 1], image[i + 2]};
    }
    Rgb plainPixel(const std::vector<float>& image) { return pixel(image, 9, 6); }
    Rgb shellPixel(const std::vector<float>& image) { return pixel(image, 3, 6); }

    void expectPlainRendered(const std::vector<float>& image) {
        EXPECT_NEAR(plainPixel(image).x, 0.5f, 1e-4f); // irradiance pi on Lambert: the colour itself
        EXPECT_NEAR(plainPixel(image).z, 0.125f, 1e-4f);
    }
    bool said(const std::string& a, const std::string& b) const {
        for (const std::string& m : messages_) {
            if (m.rfind("error ", 0) == 0 && m.find(a) != std::string::npos && m.find(b) != std::string::npos) {
                return true;
            }
        }
        return false;
    }

    std::filesystem::path folder_;
    std::string volume_;
    Scene scene_;
    Light light_;
    Vec3d cameraAt_{0, 0, 0}; ///< looks from 50 above this
    int tables_ = 0;
    std::vector<std::weak_ptr<const StfTable>> made_;
    RenderSettings settings_;
    std::vector<std::string> messages_;
};

// Errors of tables are told apart from those of pixels by tables of other seeds.
TEST_F(SceneEdits, AnotherTableSeedGivesAnotherTableAndTheSameSeedTheSameImage) {
    settings_.quality = 0.3f;
    StfBinding binding = *scene_.meshes().at("/shell").stf;
    binding.quality = 0; // as the renderer's settings say
    scene_.setStf("/shell", binding);
    Renderer renderer(countingTables());
    const std::vector<float> first = render(renderer);
    settings_.tableSeed = 1;
    const std::vector<float> other = render(renderer);
    EXPECT_EQ(tables_, 2);
    EXPECT_EQ(plainPixel(other), plainPixel(first)) << "the samples of the image are the same";
    EXPECT_NE(shellPixel(other), shellPixel(first));
    EXPECT_NEAR(shellPixel(other).y, shellPixel(first).y, 3 * 0.3f * shellPixel(first).y);
    settings_.tableSeed = 0;
    EXPECT_EQ(render(renderer), first);
    Renderer fresh(countingTables());
    settings_.tableSeed = 1;
    EXPECT_EQ(render(fresh), other);
}

TEST_F(SceneEdits, LightEditKeepsTablesAndEqualsFreshRenderer) {
    Renderer renderer(countingTables());
    const std::vector<float> before = render(renderer);
    expectPlainRendered(before);
    light_.emission = Rgb(6.28318531f);
    scene_.setLight("/light", light_);
    const std::vector<float> after = render(renderer);
    EXPECT_EQ(tables_, 1);
    EXPECT_NEAR(shellPixel(after).y, 2 * shellPixel(before).y, 1e-4f * shellPixel(after).y);
    Renderer fresh;
    EXPECT_EQ(after, render(fresh));
    EXPECT_TRUE(messages_.empty()) << messages_.front();
}

TEST_F(SceneEdits, TransformVisibilityAndRemovalEqualFreshRenderer) {
    Renderer renderer(countingTables());
    render(renderer);
    MeshInstance moved;
    moved.objectToWorld.translation = {1, 0.5, -2};
    scene_.setInstances("/shell", {moved});
    Renderer freshA;
    EXPECT_EQ(render(renderer), render(freshA));
    scene_.setVisible("/shell", false);
    const std::vector<float> hidden = render(renderer);
    EXPECT_EQ(shellPixel(hidden), Rgb(0.0f));
    expectPlainRendered(hidden);
    scene_.setVisible("/shell", true);
    Renderer freshB;
    EXPECT_EQ(render(renderer), render(freshB));
    scene_.removeMesh("/shell");
    EXPECT_EQ(render(renderer), hidden);
    EXPECT_LE(tables_, 2);
}

// A named core is the same as its coefficients; a name that is not in the table is told once, with near ones.
TEST_F(SceneEdits, CoreMaterialByName) {
    const auto with = [&](auto change) {
        StfBinding binding;
        binding.baseVolume = volume_;
        binding.quality = 0.1f;
        change(binding);
        scene_.setStf("/shell", binding);
    };
    Renderer renderer(countingTables());
    const std::vector<float> ofVolume = render(renderer);
    with([](StfBinding& b) { b.coreMaterial = "ketchup"; });
    const std::vector<float> named = render(renderer);
    EXPECT_NE(named, ofVolume);
    EXPECT_EQ(tables_, 1) << "the shell's tables do not depend on the core";
    with([](StfBinding& b) {
        b.coreSigmaA = Rgb(0.061f, 0.97f, 1.45f);
        b.coreSigmaSPrime = Rgb(0.18f, 0.07f, 0.03f);
    });
    const std::vector<float> given = render(renderer);
    for (std::size_t i = 0; i < named.size(); ++i) {
        EXPECT_NEAR(named[i], given[i], 1e-5f * std::abs(given[i]));
    }
    with([](StfBinding& b) {
        b.coreMaterial = "Ketchup";
        b.coreSigmaSPrime = Rgb(1.0f);
        b.coreSigmaA = Rgb(0.0f);
    });
    const std::vector<float> both = render(renderer);
    EXPECT_GT(shellPixel(both).y, shellPixel(named).y) << "coefficients win over the name";
    EXPECT_TRUE(messages_.empty());
    with([](StfBinding& b) { b.coreMaterial = "Ketschup"; });
    EXPECT_EQ(render(renderer), ofVolume);
    EXPECT_EQ(messages_.size(), 1u);
    EXPECT_TRUE(said("/shell: stf:coreMaterial", "Ketschup"));
    EXPECT_TRUE(said("did you mean", "Ketchup"));
}

// Tables depend on the quality, the core's samples on the seed: a setting that changes is an edit too.
TEST_F(SceneEdits, SettingsEqualFreshRenderer) {
    StfBinding binding;
    binding.baseVolume = volume_;
    scene_.setStf("/shell", binding);
    settings_.quality = 0.2f;
    Renderer renderer(countingTables());
    const std::vector<float> coarse = render(renderer);
    settings_.quality = 0.004f;
    const std::vector<float> fine = render(renderer);
    EXPECT_EQ(tables_, 2);
    EXPECT_NE(coarse, fine);
    settings_.transport = "classic";
    render(renderer);
    EXPECT_EQ(tables_, 3);
    settings_.seed = 5;
    const std::vector<float> seeded = render(renderer);
    EXPECT_EQ(tables_, 3);
    Renderer fresh;
    EXPECT_EQ(seeded, render(fresh));
    settings_.exact.voxels = true;
    const std::vector<float> halved = render(renderer);
    EXPECT_EQ(tables_, 4);
    Renderer finer;
    EXPECT_EQ(halved, render(finer));
    settings_.exact = {};
    EXPECT_EQ(seeded, render(renderer));
}

// A million units from the origin the image is that of the origin: what is single precision is relative to the scene.
TEST_F(SceneEdits, FarFromTheOrigin) {
    Renderer near;
    const std::vector<float> here = render(near);
    const Vec3d far{1e6, -2e6, 5e5};
    MeshInstance moved;
    moved.objectToWorld.translation = far;
    scene_.setInstances("/shell", {moved});
    scene_.setInstances("/plain", {moved});
    cameraAt_ = far;
    Renderer away;
    const std::vector<float> there = render(away);
    for (std::size_t i = 0; i < here.size(); ++i) {
        EXPECT_NEAR(here[i], there[i], 1e-4f) << i;
    }
}

// A binding wins over the setting; what is neither form is said once.
TEST_F(SceneEdits, FormOfTransport) {
    const auto how = [](const Renderer& renderer) {
        for (const PlanEntry& e : renderer.plan()) {
            if (e.object == "/shell" && e.stage == "transport") {
                return e.why;
            }
        }
        return std::string();
    };
    Renderer renderer(countingTables());
    render(renderer);
    EXPECT_EQ(how(renderer).rfind("dE1, ", 0), 0u) << how(renderer);
    settings_.transport = "classic";
    render(renderer);
    EXPECT_EQ(how(renderer).rfind("classic, ", 0), 0u) << how(renderer);
    EXPECT_TRUE(messages_.empty());

    StfBinding binding;
    binding.baseVolume = volume_;
    binding.quality = 0.1f;
    binding.transport = "diffusion";
    scene_.setStf("/shell", binding);
    render(renderer);
    EXPECT_EQ(how(renderer).rfind("dE1, ", 0), 0u) << how(renderer);
    ASSERT_EQ(messages_.size(), 1u);
    EXPECT_TRUE(said("/shell", "diffusion"));
    render(renderer);
    EXPECT_EQ(messages_.size(), 1u) << "once, not per frame";
}

// Tables are shared by meshes of one material, kept through edits of a mesh, and gone with the last of them.
TEST_F(SceneEdits, TablesLiveAsLongAsTheirShells) {
    Renderer renderer(countingTables());
    StfBinding binding = *scene_.meshes().at("/shell").stf;
    scene_.setStf("/plain", binding);
    render(renderer);
    ASSERT_EQ(made_.size(), 1u);
    addQuad("/shell", -5.5f);
    render(renderer);
    EXPECT_EQ(tables_, 1);
    scene_.removeMesh("/shell");
    render(renderer);
    EXPECT_FALSE(made_[0].expired());
    binding.quality = 0.2f;
    scene_.setStf("/plain", binding);
    render(renderer);
    EXPECT_EQ(tables_, 2);
    EXPECT_TRUE(made_[0].expired());
    scene_.setStf("/plain", std::nullopt);
    render(renderer);
    EXPECT_TRUE(made_[1].expired());
}

// Instances of a mesh, and meshes that are alike, hold one grid between them.
TEST_F(SceneEdits, InstancesAndTwinsShareOneShell) {
    Renderer renderer(countingTables());
    render(renderer);
    const std::size_t bytes = renderer.stats().shellBytes;
    EXPECT_GT(bytes, 0u);
    MeshInstance second;
    second.objectToWorld.translation = {0, 0, -3};
    second.instanceId = 1;
    scene_.setInstances("/shell", {MeshInstance(), second});
    ControlMesh twin = *scene_.meshes().at("/shell").mesh;
    twin.colors = {{0, 0, 1}};
    scene_.setMesh("/plain", twin, 0);
    scene_.setStf("/plain", scene_.meshes().at("/shell").stf);
    render(renderer);
    EXPECT_EQ(renderer.stats().grids, 1);
    EXPECT_EQ(renderer.stats().shellBytes, bytes);
    EXPECT_EQ(tables_, 1);
    light_.emission = Rgb(1.0f);
    scene_.setLight("/light", light_);
    cameraAt_.x = 1;
    render(renderer);
    EXPECT_EQ(renderer.stats().grids, 1);
    EXPECT_EQ(renderer.stats().refinements, 1);
}

// A part of a table that cannot be read is said with the prim, before the frame.
TEST_F(SceneEdits, DamagedTable) {
    Renderer renderer([](const std::shared_ptr<const BaseVolume>& volume, const TransportOptions& options,
                         Progress& progress, const MessageSink& messages) {
        StfTable t = precompute(*volume, options, progress, messages);
        t.multiple = Lazy<FactoredField>(std::function<FactoredField()>(
            []() -> FactoredField { throw Error("tables/multiple.vdb: the file ends too soon"); }));
        return std::make_shared<const StfTable>(std::move(t));
    });
    expectPlainRendered(render(renderer));
    EXPECT_TRUE(said("/shell", "the file ends too soon"));
}

TEST_F(SceneEdits, SettingAValueToItselfChangesNothing) {
    const std::uint64_t version = scene_.version();
    scene_.setLight("/light", light_);
    scene_.setInstances("/shell", {MeshInstance()});
    scene_.setVisible("/shell", true);
    scene_.setStf("/plain", std::nullopt);
    scene_.setMetersPerUnit(0.001);
    EXPECT_EQ(scene_.version(), version);
}

TEST_F(SceneEdits, CancelThenPrepareAgain) {
    Renderer renderer;
    Progress cancelled;
    cancelled.cancel();
    EXPECT_THROW(renderer.prepare(scene_, cancelled), Cancelled);
    expectPlainRendered(render(renderer));
}

TEST_F(SceneEdits, MissingVolume) {
    StfBinding binding;
    binding.authoredPath = "./nowhere.vdb";
    scene_.setStf("/shell", binding);
    Renderer renderer;
    const std::vector<float> image = render(renderer);
    expectPlainRendered(image);
    EXPECT_NEAR(shellPixel(image).x, 0.5f, 1e-4f) << "drawn with its displayColor";
    EXPECT_TRUE(said("/shell", "nowhere.vdb"));
    render(renderer);
    EXPECT_EQ(messages_.size(), 1u) << "once, not per frame";
}

TEST_F(SceneEdits, CorruptVolume) {
    const std::string path = (folder_ / "corrupt.vdb").string();
    std::ofstream(path) << "this is not a volume";
    StfBinding binding;
    binding.baseVolume = path;
    scene_.setStf("/shell", binding);
    Renderer renderer;
    expectPlainRendered(render(renderer));
    EXPECT_TRUE(said("/shell", "corrupt.vdb"));
}

TEST_F(SceneEdits, NegativeScaleAndMissingUv) {
    StfBinding binding;
    binding.baseVolume = volume_;
    binding.scale = -1;
    scene_.setStf("/shell", binding);
    Renderer renderer;
    expectPlainRendered(render(renderer));
    EXPECT_TRUE(said("/shell", "stf:scale"));

    binding.scale = 1;
    binding.mapping = "uv";
    scene_.setStf("/shell", binding);
    dropUvs();
    expectPlainRendered(render(renderer));
    EXPECT_TRUE(said("/shell", "texture coordinates"));
}

TEST_F(SceneEdits, WithoutUvASampleThatIsTheSameEverywhereNeedsNoSynthesis) {
    Renderer renderer;
    const Rgb tiled = shellPixel(render(renderer));
    dropUvs();
    const Rgb anywhere = shellPixel(render(renderer));
    EXPECT_NEAR(anywhere.y, tiled.y, 0.05f * tiled.y);
    EXPECT_FALSE(synthesis(renderer).runs);
    EXPECT_NE(synthesis(renderer).why.find("same everywhere"), std::string::npos);
    EXPECT_TRUE(messages_.empty()) << messages_.front();
}

TEST_F(SceneEdits, WithoutUvASampleIsSynthesized) {
    // Two columns of three are darker: by uv or by example, the mean over the quad is that of the sample.
    BaseVolume v = readBaseVolume(volume_);
    v.size = {24, 24, v.size.z};
    v.extinction.assign(v.voxelCount(), Rgb(2.0f));
    v.albedo.assign(v.voxelCount(), Rgb(0.95f));
    for (int z = 0; z < v.size.z; ++z) {
        for (int y = 0; y < 24; ++y) {
            for (int x = 0; x < 24; ++x) {
                v.albedo[v.index(x, y, z)] = Rgb(x % 3 ? 0.95f : 0.7f);
            }
        }
    }
    writeBaseVolume(v, volume_);
    StfBinding binding;
    binding.baseVolume = volume_;
    binding.quality = 0.2f;
    scene_.setStf("/shell", binding);
    const auto mean = [&](Renderer& r) {
        const std::vector<float> image = render(r);
        expectPlainRendered(image);
        float sum = 0;
        for (int y = 4; y < 8; ++y) {
            for (int x = 1; x < 5; ++x) {
                sum += pixel(image, x, y).y / 16;
            }
        }
        return sum;
    };
    settings_.samples = 32;
    Renderer renderer;
    const float tiled = mean(renderer);
    EXPECT_FALSE(synthesis(renderer).runs);
    dropUvs();
    const float grown = mean(renderer);
    EXPECT_TRUE(synthesis(renderer).runs);
    EXPECT_NE(synthesis(renderer).why.find("no texture coordinates"), std::string::npos);
    EXPECT_GT(tiled, 0.05f);
    EXPECT_NEAR(grown, tiled, 0.05f * tiled);
    EXPECT_TRUE(messages_.empty()) << messages_.front();
    Renderer fresh;
    EXPECT_EQ(render(renderer), render(fresh));
}

TEST_F(SceneEdits, BadMeshesAndTransforms) {
    ControlMesh m = *scene_.meshes().at("/shell").mesh;
    m.points[2].x = std::nanf("");
    scene_.setMesh("/shell", m, 0);
    Renderer renderer;
    expectPlainRendered(render(renderer));
    EXPECT_TRUE(said("/shell", "no usable face"));

    addQuad("/shell", -6);
    MeshInstance singular;
    singular.objectToWorld.y = {0, 0, 0};
    scene_.setInstances("/shell", {singular});
    expectPlainRendered(render(renderer));
    EXPECT_TRUE(said("/shell", "singular"));
}

} // namespace
} // namespace stf::test
