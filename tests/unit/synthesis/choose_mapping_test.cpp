// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/choose_mapping.h"

#include "stfLib/base/random.h"
#include "tests/unit/synthesis/synthesis_fixture.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

MappingChoice choose(const std::string& mapping, const ControlMesh& mesh, const BaseVolume& v = waves(8)) {
    return chooseMapping(mapping, refinedOf(mesh), v);
}

} // namespace

TEST(ChooseMapping, AutoTakesUsableTextureCoordinates) {
    EXPECT_EQ(choose("auto", torus(3, 1, 24, 12)).mapping, Mapping::Uv);
    EXPECT_EQ(choose("auto", rectangle(3, 1, 4, 4)).mapping, Mapping::Uv); // stretched threefold
}

TEST(ChooseMapping, AutoSynthesizesWithout) {
    const MappingChoice none = choose("auto", sphere(6));
    EXPECT_EQ(none.mapping, Mapping::Synthesize);
    EXPECT_NE(none.why.find("no texture coordinates"), std::string::npos);

    ControlMesh flat = rectangle(1, 1, 4, 4);
    for (Vec2f& uv : flat.uvs) {
        uv = {0.5f, 0.5f};
    }
    EXPECT_NE(choose("auto", flat).why.find("without area"), std::string::npos);

    ControlMesh half = rectangle(1, 1, 4, 4);
    for (Vec2f& uv : half.uvs) {
        uv.x = std::max(uv.x, 0.5f);
    }
    EXPECT_NE(choose("auto", half).why.find("collapsed on 50 %"), std::string::npos) << choose("auto", half).why;

    ControlMesh thin = rectangle(1, 1, 4, 4);
    for (Vec2f& uv : thin.uvs) {
        uv.x *= 20;
    }
    EXPECT_NE(choose("auto", thin).why.find("stretched"), std::string::npos);
}

TEST(ChooseMapping, WordsAreObeyed) {
    EXPECT_EQ(choose("synthesize", rectangle(1, 1, 2, 2)).mapping, Mapping::Synthesize);
    EXPECT_EQ(choose("uv", sphere(4)).mapping, Mapping::Uv); // which then says that there are none
}

TEST(ChooseMapping, RandomSamplesAreBlended) {
    BaseVolume v = waves(64);
    std::fill(v.albedo.begin(), v.albedo.end(), Rgb(0.9f));
    CounterRng rng(1, 1);
    for (Rgb& k : v.extinction) {
        k = Rgb(0.5f + rng.uniform());
    }
    const MappingChoice random = choose("auto", sphere(4), v);
    EXPECT_EQ(random.mapping, Mapping::Blend) << random.why;
    EXPECT_NE(random.why.find("random"), std::string::npos);
    EXPECT_EQ(choose("auto", rectangle(1, 1, 2, 2), v).mapping, Mapping::Uv);
    EXPECT_EQ(choose("synthesize", sphere(4), v).mapping, Mapping::Synthesize);
    EXPECT_EQ(choose("blend", rectangle(1, 1, 2, 2), v).mapping, Mapping::Blend);
    EXPECT_EQ(choose("blend", sphere(4), waves(64)).mapping, Mapping::Blend); // asked for, ghosts and all
    v.surface.assign(v.voxelCount(), -0.1f);
    v.surface[0] = 0.1f;
    const MappingChoice relief = choose("blend", sphere(4), v);
    EXPECT_EQ(relief.mapping, Mapping::Synthesize);
    EXPECT_NE(relief.why.find("relief"), std::string::npos);
}

TEST(ChooseMapping, AUniformSampleNeedsNoSynthesis) {
    BaseVolume v = waves(8);
    std::fill(v.albedo.begin(), v.albedo.end(), Rgb(0.9f));
    EXPECT_EQ(choose("auto", sphere(4), v).mapping, Mapping::Anywhere);
    EXPECT_EQ(choose("synthesize", sphere(4), v).mapping, Mapping::Anywhere);
    EXPECT_EQ(choose("auto", rectangle(1, 1, 2, 2), v).mapping, Mapping::Uv);
}

TEST(ChooseMapping, AnywhereIsIsometricPerTriangle) {
    const RefinedSurface s = refinedOf(sphere(4));
    const ExemplarMap map = mapAnywhere(s, {4, 4}, 0.25);
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c) {
            const Vec2f d =
                map.cornerCoords[3 * t + std::size_t(c)] - map.cornerCoords[3 * t + std::size_t((c + 1) % 3)];
            const float l =
                length(s.points[std::size_t(s.triangles[t][c])] - s.points[std::size_t(s.triangles[t][(c + 1) % 3])]);
            EXPECT_NEAR(std::hypot(d.x, d.y), 4 * l, 1e-4);
        }
    }
    EXPECT_THROW(mapAnywhere(s, {4, 4}, 0), Error);
}
