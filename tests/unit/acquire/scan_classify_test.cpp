// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_classify.h"

#include "stfLib/acquire/box_filter.h"
#include "stfLib/base/random.h"
#include "tests/unit/support/files.h"

#include <cmath>
#include <numeric>

using namespace stf;
using namespace stf::test;

namespace {

Scan noise(const Vec3i& size, const Vec3d& spacing) {
    Scan s{size, spacing, {}};
    CounterRng rng(9, 0);
    for (std::size_t i = 0; i < s.voxelCount(); ++i) {
        s.values.push_back(100 * rng.uniform());
    }
    return s;
}

ScanClassifier twoSteps(double width = 20) {
    return {rampsAt({30, 60}, {width}), {true, false, false}, 0, 0};
}

TEST(BoxFilter, WeightsAreSharesOfLength) {
    for (const auto& [from, to] : {std::pair{7, 3}, {3, 7}, {5, 5}, {100, 1}, {1, 9}, {13, 12}}) {
        const AxisWeights w = boxWeights(from, to);
        std::vector<double> given(std::size_t(from), 0.0);
        for (int i = 0; i < to; ++i) {
            double sum = 0;
            for (int j = 0; j < w.count(i); ++j) {
                const double x = w.weights[std::size_t(w.begin[std::size_t(i)] + j)];
                sum += x;
                given[std::size_t(w.first[std::size_t(i)] + j)] += x * from / to;
            }
            EXPECT_NEAR(sum, 1, 1e-12);
        }
        for (const double g : given) { // every old cell is given away exactly once
            EXPECT_NEAR(g, 1, 1e-9) << from << " to " << to;
        }
    }
}

TEST(BoxFilter, LinearKeepsRamps) {
    const AxisWeights w = boxOrLinearWeights(8, 40);
    for (int i = 2; i < 38; ++i) {
        double x = 0;
        for (int j = 0; j < w.count(i); ++j) {
            x += w.weights[std::size_t(w.begin[std::size_t(i)] + j)] * (w.first[std::size_t(i)] + j + 0.5);
        }
        EXPECT_NEAR(x, (i + 0.5) / 5, 1e-12);
    }
}

// Volumes of materials, from a sum over voxels that knows of no filter.
TEST(ClassifyScan, KeepsVolumes) {
    const Scan s = noise({23, 17, 11}, {0.3, 0.5, 0.9});
    const ScanClassifier c = twoSteps();
    double volume[3] = {0, 0, 0}, f[3];
    for (const float v : s.values) {
        c.transfer.evaluate(double(v), f);
        for (int m = 0; m < 3; ++m) {
            volume[m] += f[m] / double(s.voxelCount());
        }
    }
    Progress progress;
    for (const Vec3i& size : {Vec3i(23, 17, 11), Vec3i(10, 9, 4), Vec3i(40, 17, 30), Vec3i(1, 1, 1)}) {
        const TileField field = classifyScan(viewAlong(s, "+z"), c, {}, size, progress);
        EXPECT_EQ(field.materials, 2);
        EXPECT_NEAR(field.voxelMm.x * size.x, 23 * 0.3, 1e-12);
        const auto means = meanFractions(field);
        EXPECT_NEAR(means[0], volume[1], 1e-6);
        EXPECT_NEAR(means[1], volume[2], 1e-6);
    }
}

TEST(ClassifyScan, CheckerOfHalves) {
    // A checker of single voxels, two to one: every voxel is half and half.
    Scan s{{8, 8, 8}, {1, 1, 1}, {}};
    for (int i = 0; i < 512; ++i) {
        s.values.push_back((i + i / 8 + i / 64) % 2 ? 100.0f : 0.0f);
    }
    Progress progress;
    const TileField field =
        classifyScan(viewAlong(s, "+z"), {rampsAt({50}, {}), {true, false}, 0, 0}, {}, {4, 4, 4}, progress);
    for (const float f : field.fractions) {
        EXPECT_EQ(f, 0.5f);
    }
}

// Air against a bright material blurred over two voxels passes the values of a third, which is not there.
TEST(ClassifyScan, GradientTakesThePeelOffEdges) {
    Scan s{{24, 4, 4}, {0.5, 0.5, 0.5}, {}};
    for (int i = 0; i < 24 * 16; ++i) {
        s.values.push_back(float(100 / (1 + std::exp(-(i % 24 - 11.8) / 0.8))));
    }
    Progress progress;
    ScanClassifier c = twoSteps(10);
    const auto byValue = meanFractions(classifyScan(viewAlong(s, "+z"), c, {}, s.size, progress));
    c.flat = 10;
    c.steep = 20;
    const auto byEdge = meanFractions(classifyScan(viewAlong(s, "+z"), c, {}, s.size, progress));
    EXPECT_GT(byValue[0], 0.02);
    EXPECT_LT(byEdge[0], 0.4 * byValue[0]);
    // 11.7 voxels from the edge to the end, of 24.
    EXPECT_NEAR(byEdge[1], (23.5 - 11.8) / 24, 0.01);
    // A gentle slope stays what its values are.
    Scan ramp = s;
    for (std::size_t i = 0; i < ramp.values.size(); ++i) {
        ramp.values[i] = float(i % 24) * 4;
    }
    c.flat = 20;
    c.steep = 40;
    const auto slope = meanFractions(classifyScan(viewAlong(ramp, "+z"), c, {}, s.size, progress));
    EXPECT_NEAR(slope[0], 7.5 / 24, 0.02);
}

TEST(ScanView, TurnsAndNeverMirrors) {
    const Scan s = noise({3, 4, 5}, {1, 2, 3});
    const ScanView z = viewAlong(s, "+z"), x = viewAlong(s, "+x"), minusZ = viewAlong(s, "-z"),
                   minusY = viewAlong(s, "-y");
    EXPECT_EQ(z(1, 2, 3), s.values[s.index(1, 2, 3)]);
    EXPECT_EQ(x.size, Vec3i(4, 5, 3));
    EXPECT_EQ(x.spacingMm, Vec3d(2, 3, 1));
    EXPECT_EQ(x(3, 4, 2), s.values[s.index(2, 3, 4)]);
    EXPECT_EQ(minusZ(1, 0, 0), s.values[s.index(1, 3, 4)]); // y and z turned round
    EXPECT_EQ(minusY.size, Vec3i(5, 3, 4));
    EXPECT_EQ(minusY(0, 0, 0), s.values[s.index(2, 3, 0)]);
    EXPECT_THROW(viewAlong(s, "z"), Error);
    EXPECT_THROW(viewAlong(s, "+w"), Error);
}

TEST(ParseCrop, VoxelsAndMillimetres) {
    const Vec3i size(100, 50, 20);
    const Vec3d spacing(0.5, 1, 2);
    EXPECT_EQ(parseCrop("", size, spacing).hi, size);
    const VoxelBox b = parseCrop("10:20,,5:", size, spacing);
    EXPECT_EQ(b.lo, Vec3i(10, 0, 5));
    EXPECT_EQ(b.hi, Vec3i(20, 50, 20));
    const VoxelBox mm = parseCrop("5:20mm,:10mm,4.1:8mm", size, spacing);
    EXPECT_EQ(mm.lo, Vec3i(10, 0, 2));
    EXPECT_EQ(mm.hi, Vec3i(40, 10, 4));
    for (const char* bad : {"1:2", "1:2,3:4", "5:5,,", "-1:5,,", "0:101,,", "a:5,,", "5,,", "1e30:2e30,,", "0:5,,,"}) {
        EXPECT_THROW(parseCrop(bad, size, spacing), Error) << bad;
    }
}

} // namespace
