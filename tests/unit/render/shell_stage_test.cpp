// SPDX-License-Identifier: Apache-2.0
// A shell's preparation redoes only the stages whose input changed, shares what is equal, and keeps a deforming body's
// sample where it is.
#include "stfLib/base/random.h"
#include "stfLib/render/renderer.h"
#include "stfLib/render/shell_builder.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/volume/volume_io.h"
#include "tests/unit/support/files.h"
#include "tests/unit/synthesis/synthesis_fixture.h"

#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr double kLength = 30; // mm, of a bar along x

/// The bar with its x axis bent to an arc of that many radians.
Vec3f bendBar(const Vec3f& p, double angle) {
    if (angle == 0) {
        return p;
    }
    const double radius = kLength / angle, a = double(p.x) / radius, r = radius - double(p.z);
    return {float(r * std::sin(a)), p.y, float(radius - r * std::cos(a))};
}

class ShellStages : public testing::Test {
protected:
    ShellStages() : builder_(countingTables(), {}, sink()) {
        BaseVolume v = waves(24, 0.5);
        v.voxelMm.z = 0.4;
        binding_.baseVolume = folder_.file("waves.vdb");
        writeBaseVolume(v, binding_.baseVolume);
        mesh_ = bar();
        settings_.quality = 0.2f; // reached at once
    }

    /// A subdivided bar, 30 x 7 x 7 mm.
    static ControlMesh bar() {
        ControlMesh mesh = cube(ControlMesh::Scheme::CatmullClark);
        mesh.faceVertexCounts.clear();
        mesh.faceVertexIndices.clear();
        mesh.points.clear();
        const int n = 8;
        for (int i = 0; i <= n; ++i) {
            for (int k = 0; k < 4; ++k) {
                const float y = k == 0 || k == 3 ? -3.5f : 3.5f, z = k < 2 ? -3.5f : 3.5f;
                mesh.points.push_back({float(kLength * i / n), y, z});
            }
        }
        for (int i = 0; i < n; ++i) {
            for (int k = 0; k < 4; ++k) {
                const int a = 4 * i + k, b = 4 * i + (k + 1) % 4;
                addFace(mesh, {a, a + 4, b + 4, b});
            }
        }
        addFace(mesh, {0, 1, 2, 3});
        addFace(mesh, {4 * n + 3, 4 * n + 2, 4 * n + 1, 4 * n});
        // Outward, whichever way the above turns.
        const Vec3f p0 = mesh.points[0], e1 = mesh.points[4] - p0, e2 = mesh.points[1] - p0;
        mesh.leftHanded = dot(cross(e1, e2), Vec3f(0, 0, -1)) < 0;
        return mesh;
    }
    ControlMesh bent(double angle, bool rest) const {
        ControlMesh m = mesh_;
        m.rest = rest ? m.points : std::vector<Vec3f>();
        for (Vec3f& p : m.points) {
            p = bendBar(p, angle);
        }
        return m;
    }

    TableProvider countingTables() {
        return [this](const std::shared_ptr<const BaseVolume>& volume, TransportOptions options, Progress& progress,
                      const MessageSink& messages) {
            ++tables_;
            options.polars = 2;
            options.maxPhotons = 400;
            return std::make_shared<const StfTable>(precompute(*volume, options, progress, messages));
        };
    }
    MessageSink sink() {
        return [this](Severity, const std::string& text) { messages_.push_back(text); };
    }
    std::shared_ptr<ShellObject> build(ControlMesh mesh, const std::string& id = "/bar") {
        sanitize(mesh);
        plan_.clear();
        auto shell = builder_.build(id, mesh, 0, binding_, 0.001, settings_, progress_, stats_, plan_);
        if (id == "/bar") {
            held_ = shell;
            builder_.dropUnused();
        }
        return shell;
    }
    PlanEntry entry(const std::string& stage) const {
        for (const PlanEntry& e : plan_) {
            if (e.stage == stage) {
                return e;
            }
        }
        return {};
    }
    void expectCounts(int tables, int refinements, int syntheses, int grids) const {
        EXPECT_EQ(tables_, tables) << "tables";
        EXPECT_EQ(stats_.refinements, refinements) << "refinements";
        EXPECT_EQ(stats_.syntheses, syntheses) << "syntheses";
        EXPECT_EQ(stats_.grids, grids) << "grids";
    }

    const TemporaryFolder folder_;
    StfBinding binding_;
    ControlMesh mesh_;
    RenderSettings settings_;
    RenderStats stats_;
    Progress progress_;
    std::vector<PlanEntry> plan_;
    std::vector<std::string> messages_;
    int tables_ = 0;
    ShellBuilder builder_;
    std::shared_ptr<ShellObject> held_;
};

TEST_F(ShellStages, EditsRedoWhatTheyTouch) {
    const auto first = build(mesh_);
    expectCounts(1, 1, 1, 1);
    EXPECT_TRUE(entry("synthesis").runs);
    EXPECT_TRUE(entry("shell").runs);

    build(mesh_);
    expectCounts(1, 1, 1, 1);
    EXPECT_FALSE(entry("synthesis").runs);
    EXPECT_NE(entry("synthesis").why.find("already in memory"), std::string::npos);
    EXPECT_NE(entry("shell").why.find("already in memory"), std::string::npos);
    EXPECT_EQ(held_->grid, first->grid);
    EXPECT_EQ(held_->rayMesh, first->rayMesh);

    binding_.quality = 0.3f;
    build(mesh_);
    expectCounts(2, 1, 1, 1);

    binding_.coreMaterial = "Ketchup";
    build(mesh_);
    ControlMesh painted = mesh_;
    painted.colors = {{1, 0, 0}};
    build(painted);
    expectCounts(2, 1, 1, 1);

    binding_.thickness = 0.8f; // two layers of three
    build(mesh_);
    expectCounts(3, 1, 1, 2);
    EXPECT_NEAR(held_->thicknessMm, 0.8f, 1e-5f);
    EXPECT_EQ(held_->map, first->map);

    binding_.seed = 1;
    build(mesh_);
    expectCounts(3, 1, 2, 3);
    EXPECT_NE(held_->map, first->map);

    ControlMesh oriented = mesh_;
    oriented.orientation.assign(mesh_.points.size(), Vec3f(1, 0, 0));
    build(oriented);
    expectCounts(3, 2, 3, 4);

    binding_.scale = 1.25f; // a coarser sampling, another shell
    build(oriented);
    EXPECT_EQ(stats_.syntheses, 4);
    EXPECT_EQ(stats_.grids, 5);
    EXPECT_EQ(tables_, 3) << "still two layers";
    EXPECT_TRUE(messages_.empty()) << messages_.front();
}

TEST_F(ShellStages, EqualMeshesShareOneShell) {
    const auto a = build(mesh_), b = build(mesh_, "/twin");
    expectCounts(1, 1, 1, 1);
    EXPECT_EQ(a->grid, b->grid);
    EXPECT_EQ(a->map, b->map);
    EXPECT_EQ(a->surface, b->surface);
    EXPECT_EQ(a->volume, b->volume);
    // The uv mapping of a thin shell refines by the thickness, and has no use for tangents.
    binding_.mapping = "uv";
    ControlMesh plate = rectangle(20, 10, 4, 2);
    plate.orientation.assign(plate.points.size(), Vec3f(1, 0, 0));
    build(plate);
    EXPECT_EQ(stats_.syntheses, 1);
    EXPECT_NE(entry("orientation").why.find("synthesis only"), std::string::npos);
    const auto grid = held_->grid;
    plate.orientation[0] = {0, 1, 0};
    build(plate);
    EXPECT_EQ(held_->grid, grid);
}

TEST_F(ShellStages, WhatNobodyUsesIsDropped) {
    std::weak_ptr<const ShellGrid> grid = build(mesh_)->grid;
    const std::weak_ptr<const ExemplarMap> map = held_->map;
    const std::weak_ptr<const StfTable> table = held_->table;
    binding_.seed = 3;
    build(mesh_);
    EXPECT_TRUE(grid.expired());
    EXPECT_TRUE(map.expired());
    EXPECT_FALSE(table.expired());
    grid = held_->grid;
    held_ = nullptr;
    builder_.dropUnused();
    EXPECT_TRUE(grid.expired());
    EXPECT_TRUE(table.expired());
}

TEST_F(ShellStages, PointsThatMoveWithoutARestPoseAreLaidOutAnew) {
    build(bent(0, false));
    EXPECT_TRUE(messages_.empty());
    build(bent(0.3, false));
    expectCounts(1, 2, 2, 2);
    ASSERT_EQ(messages_.size(), 1u);
    EXPECT_NE(messages_[0].find("/bar: its points moved"), std::string::npos);
    EXPECT_NE(messages_[0].find("primvars:stf:rest"), std::string::npos);
}

// A bar that bends to a quarter of a circle over 24 frames: what its points show stays, and nothing is made anew.
TEST_F(ShellStages, ABendingBodyKeepsItsSample) {
    constexpr int frames = 24;
    std::vector<ShellLookup> first;
    std::vector<std::pair<std::size_t, Vec3f>> places; // triangle; barycentric and share of the depth
    double worst = 0, worstDepth = 0, moved = 0;
    for (int frame = 0; frame < frames; ++frame) {
        const auto shell = build(bent(1.5 * frame / (frames - 1), true));
        expectCounts(1, 1 + frame, 1, 1);
        EXPECT_EQ(stats_.poses, frame);
        const RefinedSurface& s = *shell->surface;
        if (places.empty()) {
            CounterRng rng(5, 6);
            for (int i = 0; i < 500; ++i) {
                const float b1 = rng.uniform(), b2 = rng.uniform() * (1 - b1);
                const std::size_t t = std::size_t(double(rng.uniform()) * double(s.triangles.size()));
                places.push_back({t, {b1, b2, 0.05f + 0.9f * rng.uniform()}});
            }
        }
        ShellProbe probe(*shell->grid, *shell->surface, shell->pose.get());
        for (std::size_t i = 0; i < places.size(); ++i) {
            const auto& [t, b] = places[i];
            const Vec3i& tri = s.triangles[t];
            Vec3d at;
            double depth = 0;
            for (int c = 0; c < 3; ++c) {
                const std::size_t v = std::size_t(tri[c]);
                const double w = c == 0 ? 1 - double(b.x) - double(b.y) : double(c == 1 ? b.x : b.y);
                at += (Vec3d(s.points[v]) * (1 - double(b.z)) + Vec3d(shell->boundary->inner[v]) * double(b.z)) * w;
                depth += w * double(b.z) * double(shell->boundary->thickness[v]);
            }
            ShellLookup l{};
            probe.enter(std::uint32_t(t));
            ASSERT_TRUE(probe.lookup(Vec3f(at), l)) << frame << " " << i;
            if (frame == 0) {
                first.push_back(l);
                continue;
            }
            // Where the shell is as thick as at rest; a bend may make it thinner, not deeper.
            if (std::abs(depth - double(first[i].depth)) < 0.02) {
                const auto jump = [](float d) { return double(d) - 12 * std::nearbyint(double(d) / 12); };
                worst = std::max({worst, std::abs(jump(l.exemplar.x - first[i].exemplar.x)),
                                  std::abs(jump(l.exemplar.y - first[i].exemplar.y))});
                worstDepth = std::max(worstDepth, double(std::abs(l.depth - first[i].depth)));
            }
            if (frame == frames - 1) {
                moved = std::max(moved, double(length(Vec3f(at) - Vec3f(kLength, 0, 0))));
            }
        }
        if (frame > 0) {
            EXPECT_TRUE(entry("pose").runs);
            EXPECT_FALSE(entry("synthesis").runs);
            EXPECT_FALSE(entry("shell").runs);
            EXPECT_NE(entry("shell").why.find("already in memory"), std::string::npos);
        }
    }
    RecordProperty("exemplar_mm", std::to_string(worst));
    RecordProperty("depth_mm", std::to_string(worstDepth));
    EXPECT_GT(moved, 15) << "the body did bend";
    EXPECT_LT(worst, 0.02) << "of a texel of 0.5 mm";
    EXPECT_LT(worstDepth, 0.03);
    EXPECT_TRUE(messages_.empty()) << messages_.front();
}

/// Renders one mesh under a light from above, seen by a camera that is moved with `placed`.
std::vector<float> render(const ControlMesh& mesh, const StfBinding& binding, const Transform& placed,
                          const TableProvider& tables) {
    Scene scene;
    scene.setMetersPerUnit(0.001);
    scene.setMesh("/bar", mesh, 0);
    scene.setStf("/bar", binding);
    MeshInstance instance;
    instance.objectToWorld = placed;
    scene.setInstances("/bar", {instance});
    Light light;
    light.emission = Rgb(3.0f);
    scene.setLight("/light", light);
    Renderer renderer(tables);
    RenderSettings settings;
    settings.samples = 16;
    settings.quality = 0.2f;
    renderer.setSettings(settings);
    const Matrix4 view{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -15, 0, -80, 1};
    const Matrix4 projection{0.06, 0, 0, 0, 0, 0.12, 0, 0, 0, 0, -0.01, 0, 0, 0, -1, 1};
    renderer.setCamera(Camera(view, projection), 96, 48);
    Progress progress;
    renderer.prepare(scene, progress);
    renderer.restart();
    while (!renderer.converged()) {
        renderer.renderPass(progress);
    }
    return renderer.film().read(Aov::Color);
}

double rms(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += double(a[i] - b[i]) * double(a[i] - b[i]);
    }
    return std::sqrt(sum / double(a.size()));
}

// A body that its pose turns by an angle looks as one that its transform turns.
TEST_F(ShellStages, ATurnedPoseLooksLikeATurnedBody) {
    const double a = 0.6;
    Transform turn;
    turn.y = {0, std::cos(a), std::sin(a)};
    turn.z = {0, -std::sin(a), std::cos(a)};
    ControlMesh posed = mesh_;
    posed.rest = posed.points;
    for (Vec3f& p : posed.points) {
        p = Vec3f(turn.point(Vec3d(p)));
    }
    const TableProvider tables = countingTables();
    const std::vector<float> byPose = render(posed, binding_, Transform(), tables);
    const std::vector<float> byTransform = render(mesh_, binding_, turn, tables);
    const std::vector<float> notTurned = render(mesh_, binding_, Transform(), tables);
    const double same = rms(byPose, byTransform), other = rms(notTurned, byTransform);
    RecordProperty("rms", std::to_string(same));
    EXPECT_GT(other, 0.03);
    EXPECT_LT(same, 0.1 * other);
}

} // namespace
} // namespace stf::test
