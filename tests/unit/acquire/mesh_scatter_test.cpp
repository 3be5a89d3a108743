// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_scatter.h"

#include "tests/unit/acquire/meshes.h"

using namespace stf;
using namespace stf::test;

namespace {

const Vec3d kExtent(8, 6, 4);
const ScatteredBody kBall{{0.3, -0.2, 5}, 0.5, kPi / 6};

Vec3d middleOf(const Transform& t) {
    return t.point(kBall.middle);
}

TEST(MeshScatter, PlacesAndSizesAreUniform) {
    MeshScatter o;
    o.count = 20000;
    o.scale = {0.5, 1.5};
    const ScatterResult r = scatter(o, kBall, kExtent);
    ASSERT_EQ(r.copies.size(), 20000u);
    Vec3d sum;
    double sizes = 0, axis = 0;
    for (const Transform& t : r.copies) {
        const Vec3d m = middleOf(t);
        EXPECT_TRUE(m.x >= 0 && m.x <= 8 && m.y >= 0 && m.y <= 6 && m.z <= 0 && m.z >= -4);
        sum += m;
        const double size = std::cbrt(t.determinant());
        EXPECT_NEAR(length(t.z), size, 1e-9) << "a rotation and a scale";
        EXPECT_TRUE(size >= 0.5 - 1e-9 && size <= 1.5 + 1e-9);
        sizes += size;
        axis += t.z.z * t.z.z / (size * size);
    }
    // Four standard errors of a uniform number, (b - a) / sqrt(12 n).
    const double error = 4 / std::sqrt(12 * 20000.0);
    EXPECT_NEAR(sum.x / 20000, 4, 8 * error);
    EXPECT_NEAR(sum.y / 20000, 3, 6 * error);
    EXPECT_NEAR(sum.z / 20000, -2, 4 * error);
    EXPECT_NEAR(sizes / 20000, 1, error);
    EXPECT_NEAR(axis / 20000, 1.0 / 3, 4 * std::sqrt(4.0 / 45 / 20000)) << "directions are uniform on the sphere";
}

TEST(MeshScatter, ApartMeansApartAcrossTheSidesToo) {
    MeshScatter o;
    o.count = 150;
    o.scale = {0.5, 1.2};
    o.apart = true;
    o.gapMm = 0.05;
    const ScatterResult r = scatter(o, kBall, kExtent);
    EXPECT_GT(r.copies.size(), 60u);
    EXPECT_EQ(r.copies.size() + r.leftOut, 150u);
    for (std::size_t i = 0; i < r.copies.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            Vec3d d = middleOf(r.copies[i]) - middleOf(r.copies[j]);
            d.x -= 8 * std::round(d.x / 8);
            d.y -= 6 * std::round(d.y / 6);
            EXPECT_GE(length(d), 0.5 * (length(r.copies[i].x) + length(r.copies[j].x)) + 0.05 - 1e-9);
        }
    }
}

TEST(MeshScatter, FractionIsThatOfTheTile) {
    MeshScatter o;
    o.fraction = 0.3;
    o.scale = {0.3, 0.6};
    const ScatterResult r = scatter(o, kBall, kExtent);
    double volume = 0, largest = 0.6 * 0.6 * 0.6 * kBall.volume;
    for (const Transform& t : r.copies) {
        volume += t.determinant() * kBall.volume;
    }
    EXPECT_GE(volume, 0.3 * 192);
    EXPECT_LE(volume, 0.3 * 192 + largest);
}

TEST(MeshScatter, SeedsDifferAndRepeat) {
    MeshScatter o;
    o.count = 5;
    const auto first = scatter(o, kBall, kExtent).copies, again = scatter(o, kBall, kExtent).copies;
    o.seed = 1;
    const auto other = scatter(o, kBall, kExtent).copies;
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_TRUE(first[i] == again[i]);
        EXPECT_FALSE(first[i] == other[i]);
    }
}

TEST(MeshScatter, TurnsAboutTheVertical) {
    MeshScatter o;
    o.count = 20;
    o.turn = MeshScatter::Turn::Vertical;
    for (const Transform& t : scatter(o, kBall, kExtent).copies) {
        EXPECT_EQ(t.z, Vec3d(0, 0, 1));
    }
    o.turn = MeshScatter::Turn::None;
    EXPECT_EQ(scatter(o, kBall, kExtent).copies[3].x, Vec3d(1, 0, 0));
}

// Spheres at random places, overlapping: the share left free is exp(-sum of their volumes / tile) (Poisson).
TEST(MeshScatter, OverlappingVoidsLeaveTheShareOfABooleanModel) {
    const Acquired a =
        acquired(R"({"size": [64, 64, 64], "voxel": 0.25, "matrix": {"name": "m", "sigma_s": 1}, "meshes": [
        {"shape": "sphere", "material": "none", "scatter": {"count": 900, "scale": 2, "depth": [-1, 17]}}]})");
    const double n = 900 / (16.0 * 16 * 18), expected = std::exp(-n * 4.0 / 3 * kPi);
    EXPECT_NEAR(shareOf(a, "m"), expected, 0.05 * expected);
}

TEST(MeshShapes, HaveTheirVolumesAndAreClosed) {
    const auto volume = [](const std::string& shape) {
        MeshRecipe r =
            parseMeshRecipe(R"({"size": 8, "voxel": 1, "meshes": [{"material": "x", )" + shape + "}]}", "r", "");
        const MendedMesh m = repair(makeShape(r.meshes[0].source, r.extentMm(), 3), "shape");
        EXPECT_TRUE(m.repair.sound()) << shape << ": " << m.repair.summary();
        return m.repair.volume;
    };
    EXPECT_NEAR(volume(R"("shape": "sphere")"), kPi / 6, 1e-12);
    EXPECT_NEAR(volume(R"("shape": "pebble", "seed": 4)"), kPi / 6, 1e-12);
    EXPECT_NEAR(volume(R"("shape": "cylinder")"), kPi / 4, 1e-12);
    EXPECT_NEAR(volume(R"("shape": "box")"), 1, 1e-12);
    EXPECT_NEAR(volume(R"("shape": "layer", "depth": [1, 3.5])"), 8 * 8 * 2.5, 1e-9);
    EXPECT_NEAR(volume(R"("shape": "layer", "depth": [1, 4], "wave": 0.3, "cells": 3)"), 8 * 8 * 3, 8 * 8 * 0.3);
    EXPECT_GT(volume(R"("shape": "layer", "depth": [1, 1.1], "wave": 0.5)"), 0) << "sound where its waves cross, too";
}

TEST(MeshShapes, FitFillsTheTileInItsMiddle) {
    const Acquired a = acquired(R"({"size": [40, 40, 20], "voxel": 0.1, "matrix": {"name": "m"}, "meshes": [
        {"file": "a", "material": {"name": "i", "sigma_s": 1}, "fit": 0.5, "rotate": [0, 90, 0]}]})",
                                {boxMesh({4, 1, 1}, {70, -30, 12})});
    // Upright it is 1 x 1 x 4; the tile's 2 mm of depth allow half of that, and half of it is wanted.
    EXPECT_NEAR(shareOf(a, "i"), 1 * 0.25 * 0.25 / 32, 1e-5);
    EXPECT_EQ(a.volume.extinction[a.volume.index(20, 20, 10)].x, 1);
    EXPECT_EQ(a.volume.extinction[a.volume.index(20, 20, 16)].x, 0);
}

} // namespace
