// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/base_volume.h"

#include "tests/unit/support/files.h"
#include "tests/unit/volume/volumes.h"

#include <functional>
#include <limits>
#include <set>

using namespace stf;
using namespace stf::test;
using testing::IsSubstring;

namespace {

const float kNan = std::numeric_limits<float>::quiet_NaN();
const float kInf = std::numeric_limits<float>::infinity();

std::string complaint(const std::function<void(BaseVolume&)>& damage) {
    BaseVolume v = varied({4, 3, 5});
    EXPECT_NO_THROW(validate(v));
    damage(v);
    return messageOf<Error>([&] { validate(v); });
}

TEST(Validate, NamesGridCountAndVoxel) {
    const std::string text = complaint([](BaseVolume& v) {
        v.extinction[v.index(2, 1, 3)].y = -1;
        v.extinction[v.index(3, 2, 4)].x = kNan;
    });
    EXPECT_PRED_FORMAT2(IsSubstring, "'extinction'", text);
    EXPECT_PRED_FORMAT2(IsSubstring, "2 value(s)", text);
    EXPECT_PRED_FORMAT2(IsSubstring, "(2, 1, 3)", text);
}

TEST(Validate, RefusesValues) {
    for (float bad : {kNan, kInf, -kInf, -1e-3f}) {
        EXPECT_PRED_FORMAT2(IsSubstring, "'extinction'", complaint([&](BaseVolume& v) { v.extinction[7].z = bad; }));
        EXPECT_PRED_FORMAT2(IsSubstring, "'albedo'", complaint([&](BaseVolume& v) { v.albedo[7].y = bad; }));
        EXPECT_PRED_FORMAT2(IsSubstring, "'emission'", complaint([&](BaseVolume& v) { v.emission[7].x = bad; }));
        EXPECT_PRED_FORMAT2(IsSubstring, "'ior'", complaint([&](BaseVolume& v) { v.ior[7] = bad; }));
    }
    for (float bad : {kNan, kInf, -kInf}) {
        EXPECT_PRED_FORMAT2(IsSubstring, "'surface'", complaint([&](BaseVolume& v) { v.surface[7] = bad; }));
    }
    for (float bad : {1.0f + 1e-6f, 2.0f}) {
        EXPECT_PRED_FORMAT2(IsSubstring, "'albedo'", complaint([&](BaseVolume& v) { v.albedo[7].x = bad; }));
    }
    for (float bad : {1.0f, -1.0f, 1.5f, kNan, kInf}) {
        EXPECT_PRED_FORMAT2(IsSubstring, "'g'", complaint([&](BaseVolume& v) { v.g[7] = bad; }));
    }
    EXPECT_PRED_FORMAT2(IsSubstring, "'extinction'", complaint([](BaseVolume& v) { v.extinction[7].x = 2e9f; }));
    EXPECT_PRED_FORMAT2(IsSubstring, "core", complaint([](BaseVolume& v) { v.coreSigmaA.y = -1; }));
    EXPECT_PRED_FORMAT2(IsSubstring, "core", complaint([](BaseVolume& v) { v.coreSigmaSPrime.z = double(kNan); }));
}

TEST(Validate, AcceptsTheEndsOfRanges) {
    BaseVolume v = varied({4, 3, 5});
    v.albedo[0] = Rgb(1.0f);
    v.extinction[0] = Rgb(0.0f, 1e9f, 1e-30f);
    v.g[0] = std::nextafter(1.0f, 0.0f);
    v.g[1] = std::nextafter(-1.0f, 0.0f);
    EXPECT_NO_THROW(validate(v));
    v.g.clear();
    v.ior.clear();
    v.surface.clear();
    v.emission.clear();
    EXPECT_NO_THROW(validate(v));
}

TEST(Validate, RefusesArraysOfAnotherSize) {
    const std::string text = complaint([](BaseVolume& v) { v.albedo.pop_back(); });
    EXPECT_PRED_FORMAT2(IsSubstring, "'albedo'", text);
    EXPECT_PRED_FORMAT2(IsSubstring, "59", text);
    EXPECT_PRED_FORMAT2(IsSubstring, "60", text);
    EXPECT_PRED_FORMAT2(IsSubstring, "'extinction'", complaint([](BaseVolume& v) { v.extinction.clear(); }));
    EXPECT_PRED_FORMAT2(IsSubstring, "'albedo'", complaint([](BaseVolume& v) { v.albedo.clear(); }));
    EXPECT_PRED_FORMAT2(IsSubstring, "'g'", complaint([](BaseVolume& v) { v.g.push_back(0); }));
    EXPECT_PRED_FORMAT2(IsSubstring, "'surface'", complaint([](BaseVolume& v) { v.surface.resize(2); }));
}

TEST(Validate, RefusesTileSizes) {
    for (const Vec3i& size : {Vec3i(0, 3, 5), Vec3i(4, -3, -5), Vec3i(1 << 30, 1, 1), Vec3i(1 << 10, 1 << 10, 1 << 10),
                              Vec3i(1 << 30, 1 << 30, 1 << 30), Vec3i(-4, -3, 5)}) {
        EXPECT_PRED_FORMAT2(IsSubstring, "tile size", complaint([&](BaseVolume& v) { v.size = size; }));
    }
    for (double edge : {0.0, -1.0, double(kNan), double(kInf)}) {
        EXPECT_PRED_FORMAT2(IsSubstring, "voxel size", complaint([&](BaseVolume& v) { v.voxelMm.y = edge; }));
    }
}

TEST(ContentHash, ChangesWithEverythingThatTransportReads) {
    const BaseVolume original = varied({4, 3, 5});
    std::set<std::string> hashes{original.contentHash()};
    EXPECT_EQ(original.contentHash(), varied({4, 3, 5}).contentHash());
    EXPECT_EQ(original.contentHash().size(), 32u);
    const std::function<void(BaseVolume&)> changes[] = {
        [](BaseVolume& v) { v.extinction[9].z = std::nextafter(v.extinction[9].z, 1e9f); },
        [](BaseVolume& v) { v.albedo[20].x = std::nextafter(v.albedo[20].x, 2.0f); },
        [](BaseVolume& v) { v.g[21] += 0.01f; },
        [](BaseVolume& v) { v.ior[22] += 0.01f; },
        [](BaseVolume& v) { v.surface[23] -= 0.01f; },
        [](BaseVolume& v) { v.voxelMm.x *= 2; },
        [](BaseVolume& v) { v.voxelMm.y *= 2; },
        [](BaseVolume& v) { v.voxelMm.z *= 2; },
        [](BaseVolume& v) {
            v.size = {3, 4, 5};
        },
        [](BaseVolume& v) { std::swap(v.extinction[17], v.extinction[18]); },
        [](BaseVolume& v) { v.g.clear(); },
        [](BaseVolume& v) { v.g.swap(v.surface); },
        [](BaseVolume& v) { v.surface.clear(); },
    };
    std::size_t distinct = 1;
    for (const auto& change : changes) {
        BaseVolume v = original;
        change(v);
        hashes.insert(v.contentHash());
        EXPECT_EQ(hashes.size(), ++distinct);
    }
}

TEST(ContentHash, IgnoresWhatTransportDoesNotRead) {
    BaseVolume v = varied({4, 3, 5});
    const std::string hash = v.contentHash();
    v.name = "another";
    v.coreSigmaA = {9, 9, 9};
    EXPECT_EQ(v.contentHash(), hash);
}

TEST(ContentHash, OfTexts) {
    EXPECT_EQ(contentHashOf("a"), contentHashOf("a"));
    EXPECT_NE(contentHashOf("a"), contentHashOf("b"));
    EXPECT_EQ(contentHashOf("").size(), 32u);
}

TEST(CropDepth, KeepsTheUpperLayers) {
    const BaseVolume v = varied({4, 3, 5}), c = cropDepth(v, 2);
    EXPECT_EQ(c.size, Vec3i(4, 3, 2));
    EXPECT_NO_THROW(validate(c));
    for (int x = 0; x < 4; ++x) {
        for (int z = 0; z < 2; ++z) {
            EXPECT_EQ(c.extinction[c.index(x, 1, z)], v.extinction[v.index(x, 1, z)]);
            EXPECT_EQ(c.albedo[c.index(x, 1, z)], v.albedo[v.index(x, 1, z)]);
            EXPECT_EQ(c.g[c.index(x, 1, z)], v.g[v.index(x, 1, z)]);
            EXPECT_EQ(c.surface[c.index(x, 1, z)], v.surface[v.index(x, 1, z)]);
        }
    }
    EXPECT_EQ(c.coreSigmaSPrime, v.coreSigmaSPrime);
}

TEST(CropDepth, ClampsTheNumberOfLayers) {
    const BaseVolume v = varied({4, 3, 5});
    EXPECT_EQ(cropDepth(v, 0).size.z, 1);
    EXPECT_EQ(cropDepth(v, -7).size.z, 1);
    EXPECT_EQ(cropDepth(v, 5).contentHash(), v.contentHash());
    EXPECT_EQ(cropDepth(v, 99).contentHash(), v.contentHash());
    const BaseVolume bare = homogeneous({2, 2, 4}, {1, 1, 1}, Rgb(1.0f), Rgb(0.5f));
    EXPECT_TRUE(cropDepth(bare, 3).g.empty());
}

TEST(Subdivide, EveryVoxelBecomesEight) {
    BaseVolume v = varied({4, 3, 5});
    v.surface.clear();
    const BaseVolume fine = subdivide(v);
    EXPECT_EQ(fine.size, Vec3i(8, 6, 10));
    EXPECT_EQ(fine.extentMm(), v.extentMm());
    EXPECT_NO_THROW(validate(fine));
    for (int z = 0; z < 10; ++z) {
        for (int y = 0; y < 6; ++y) {
            for (int x = 0; x < 8; ++x) {
                const std::size_t i = fine.index(x, y, z), j = v.index(x / 2, y / 2, z / 2);
                ASSERT_EQ(fine.extinction[i], v.extinction[j]);
                ASSERT_EQ(fine.albedo[i], v.albedo[j]);
                ASSERT_EQ(fine.g[i], v.g[j]);
                ASSERT_EQ(fine.ior[i], v.ior[j]);
                ASSERT_EQ(fine.emission[i], v.emission[j]);
            }
        }
    }
    EXPECT_EQ(fine.coreSigmaSPrime, v.coreSigmaSPrime);
    EXPECT_TRUE(subdivide(homogeneous({2, 2, 4}, {1, 1, 1}, Rgb(1.0f), Rgb(0.5f))).g.empty());
}

TEST(Subdivide, NeitherReliefsNorTooManyVoxels) {
    EXPECT_THROW(subdivide(varied({4, 3, 5})), Error);
    BaseVolume large;
    large.size = {512, 256, 256}; // no values: it is refused before any is read
    EXPECT_THROW(subdivide(large), Error);
}

TEST(BaseVolume, LaterallyUniform) {
    BaseVolume v = homogeneous({3, 2, 4}, {1, 1, 1}, Rgb(1.0f), Rgb(0.5f), 0.3f);
    EXPECT_TRUE(v.laterallyUniform());
    for (std::size_t i = 6; i < 12; ++i) { // a layer of its own
        v.extinction[i] = Rgb(2.0f);
    }
    EXPECT_TRUE(v.laterallyUniform());
    BaseVolume g = v, k = v, a = v;
    g.g[8] = 0.31f;
    k.extinction[8].x = 2.1f;
    a.albedo[8].z = 0.51f;
    EXPECT_FALSE(g.laterallyUniform());
    EXPECT_FALSE(k.laterallyUniform());
    EXPECT_FALSE(a.laterallyUniform());
    EXPECT_TRUE(homogeneous({1, 1, 9}, {1, 1, 1}, Rgb(1.0f), Rgb(0.5f)).laterallyUniform());
}

TEST(BaseVolume, HasRelief) {
    BaseVolume v = homogeneous({3, 2, 4}, {1, 1, 1}, Rgb(1.0f), Rgb(0.5f));
    EXPECT_FALSE(v.hasRelief());
    BaseVolume hole = v;
    hole.extinction[5] = Rgb(0.0f);
    EXPECT_TRUE(hole.hasRelief());
    v.surface.assign(v.voxelCount(), -1.0f);
    EXPECT_FALSE(v.hasRelief());
    v.surface[0] = 0.1f;
    EXPECT_TRUE(v.hasRelief());
}

} // namespace
