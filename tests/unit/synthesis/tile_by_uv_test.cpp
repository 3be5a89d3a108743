// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/exemplar_map.h"
#include "tests/unit/surface/test_meshes.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

RefinedSurface refined(ControlMesh mesh) {
    sanitize(mesh);
    return refine(mesh, {}, {});
}

double wrapped(double d, double tile) {
    return std::abs(d - tile * std::round(d / tile));
}

} // namespace

TEST(TileByUv, APlaneIsTiledExactly) {
    // 3 x 2 units, uv 0..1 in both: without correction the tile would be stretched by 1.5.
    const RefinedSurface s = refined(rectangle(3, 2, 6, 5));
    const double unitsPerMm = 0.1;
    const ExemplarMap map = tileByUv(s, {4, 7}, unitsPerMm, {});
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c) {
            const std::size_t i = 3 * t + std::size_t(c);
            const Vec3f p = s.points[std::size_t(s.triangles[t][c])];
            EXPECT_LT(wrapped(double(map.cornerCoords[i].x) - double(p.x) / unitsPerMm, 4), 1e-4);
            EXPECT_LT(wrapped(double(map.cornerCoords[i].y) - double(p.y) / unitsPerMm, 7), 1e-4);
            EXPECT_LT(length(map.gradientX[i] - Vec3f(10, 0, 0)), 1e-4f);
            EXPECT_LT(length(map.gradientY[i] - Vec3f(0, 10, 0)), 1e-4f);
        }
    }
    EXPECT_DOUBLE_EQ(map.tileMm.x, 4);
}

TEST(TileByUv, CoordinatesAreContinuousWithinTriangles) {
    ControlMesh mesh = rectangle(1, 1, 3, 3);
    for (Vec2f& uv : mesh.uvs) {
        uv = {uv.x + 1000, uv.y - 500}; // far from the origin
    }
    const RefinedSurface s = refined(mesh);
    const ExemplarMap map = tileByUv(s, {0.1, 0.1}, 1, {});
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        for (std::size_t c = 0; c < 3; ++c) {
            const Vec2f d = map.cornerCoords[3 * t + c] - map.cornerCoords[3 * t + (c + 1) % 3];
            EXPECT_LT(std::abs(d.x), 0.34f);
            EXPECT_LT(std::abs(map.cornerCoords[3 * t + c].x), 0.6f) << "whole tiles are taken off";
        }
    }
}

TEST(TileByUv, AClosedTurnTakesWholeTilesAndHasNoSeam) {
    for (bool welded : {true, false}) {
        ControlMesh mesh = cylinder(1, 2, 64, 8);
        if (!welded) {
            mesh.normals.clear();
            // The last column of quads gets points of its own.
            mesh = parametric(64, 8, false, false, [](double u, double v) {
                return Vec3d(std::cos(2 * pi * u), std::sin(2 * pi * u), 2 * v);
            });
        }
        const RefinedSurface s = refined(mesh);
        const double tile = 0.87;
        const ExemplarMap map = tileByUv(s, {tile, tile}, 1, {});
        // 2 pi / 0.87 = 7.22: seven tiles.
        double seam = 0;
        for (std::size_t t = 0; t < s.triangles.size(); ++t) {
            for (int c = 0; c < 3; ++c) {
                const std::size_t i = 3 * t + std::size_t(c);
                const Vec3f p = s.points[std::size_t(s.triangles[t][c])];
                const double u = std::atan2(double(p.y), double(p.x)) / (2 * pi);
                seam = std::max(seam, wrapped(double(map.cornerCoords[i].x) - 7 * tile * u, tile));
                EXPECT_LT(wrapped(double(map.cornerCoords[i].y) - double(p.z), tile), 1e-4) << "v does not close";
                EXPECT_NEAR(length(map.gradientX[i]), 7 * tile / (2 * pi), 5e-3);
            }
        }
        EXPECT_LT(seam, 1e-4);
        EXPECT_NE(map.description.find("7 tiles"), std::string::npos) << map.description;
    }
    // Never less than one.
    const ExemplarMap large = tileByUv(refined(cylinder(1, 2, 64, 8)), {100, 100}, 1, {});
    EXPECT_NE(large.description.find("1 tiles"), std::string::npos) << large.description;
}

TEST(TileByUv, GradientsAgreeWithDifferencesAlongEdges) {
    ControlMesh control = torus(3, 1, 96, 48);
    const RefinedSurface s = refined(control);
    const ExemplarMap map = tileByUv(s, {0.5, 0.5}, 1, {});
    double worst = 0;
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c) {
            const std::size_t i = 3 * t + std::size_t(c), k = 3 * t + std::size_t((c + 1) % 3);
            const Vec3f edge =
                s.points[std::size_t(s.triangles[t][(c + 1) % 3])] - s.points[std::size_t(s.triangles[t][c])];
            const Vec3f gradient = (map.gradientX[i] + map.gradientX[k]) * 0.5f;
            const double foreseen = double(dot(gradient, edge)),
                         found = double(map.cornerCoords[k].x - map.cornerCoords[i].x);
            worst = std::max(worst, std::abs(foreseen - found) / double(length(gradient) * length(edge)));
            const Vec3f n = s.normals[std::size_t(s.triangles[t][c])];
            EXPECT_LT(std::abs(dot(map.gradientX[i], n)), 1e-4f * length(map.gradientX[i]));
        }
    }
    EXPECT_LT(worst, 0.05); // one-sided at the seam, far better elsewhere
}

TEST(TileByUv, MirroredUvKeepTheirHandedness) {
    ControlMesh mesh = rectangle(1, 1, 4, 4);
    for (Vec2f& uv : mesh.uvs) {
        uv.x = -uv.x;
    }
    const RefinedSurface s = refined(mesh);
    const ExemplarMap map = tileByUv(s, {1, 1}, 1, {});
    EXPECT_LT(cross(map.gradientX[0], map.gradientY[0]).z, 0);
    EXPECT_NEAR(map.gradientX[0].x, -1, 1e-5);
}

TEST(TileByUv, GradientsDoNotCancelAtAMirrorLine) {
    ControlMesh mesh = rectangle(1, 1, 4, 4);
    for (Vec2f& uv : mesh.uvs) {
        uv.x = std::abs(uv.x - 0.5f); // shared uv vertices on the line
    }
    const ExemplarMap map = tileByUv(refined(mesh), {1, 1}, 1, {});
    for (const Vec3f& g : map.gradientX) {
        EXPECT_NEAR(length(g), 1, 1e-5);
    }
}

TEST(TileByUv, CollapsedUvGetSomeFrameAndAreReported) {
    ControlMesh mesh = rectangle(1, 1, 4, 4);
    for (std::size_t i = 0; i < 4; ++i) {
        mesh.uvIndices[i] = mesh.uvIndices[0];
    }
    Messages messages;
    const ExemplarMap map = tileByUv(refined(mesh), {1, 1}, 1, messages.sink());
    EXPECT_TRUE(messages.has("2 of 32 triangles have collapsed")) << messages.text;
    for (std::size_t i = 0; i < map.gradientX.size(); ++i) {
        EXPECT_TRUE(isFinite(map.gradientX[i]));
        EXPECT_GT(length(map.gradientX[i]), 0.1f);
        EXPECT_GT(length(map.gradientY[i]), 0.1f);
    }
}

TEST(TileByUv, SaysWhatIsMissing) {
    const auto expectError = [](const RefinedSurface& s, Vec2d tile, double units, const char* part) {
        try {
            tileByUv(s, tile, units, {});
            ADD_FAILURE() << part;
        } catch (const Error& e) {
            EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
        }
    };
    expectError(refined(sphere(2)), {1, 1}, 1, "no texture coordinates");
    expectError(refined(rectangle(1, 1, 2, 2)), {0, 1}, 1, "tile has no size");
    expectError(refined(rectangle(1, 1, 2, 2)), {1, 1}, std::nan(""), "scale");
    ControlMesh flat = rectangle(1, 1, 2, 2);
    for (Vec2f& uv : flat.uvs) {
        uv.y = 0;
    }
    expectError(refined(flat), {1, 1}, 1, "no area");
}
