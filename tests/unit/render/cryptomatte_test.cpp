// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/cryptomatte.h"
#include "stfLib/render/film.h"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

// Published: by the author's own test programs and, for the last, by Wikipedia's table.
TEST(MurmurHash, AgreesWithPublishedVectors) {
    EXPECT_EQ(murmurHash3(""), 0u);
    EXPECT_EQ(murmurHash3("", 1), 0x514e28b7u);
    EXPECT_EQ(murmurHash3("", 0xffffffffu), 0x81f16f39u);
    EXPECT_EQ(murmurHash3("test"), 0xba6bd213u);
    EXPECT_EQ(murmurHash3("test", 0x9747b28cu), 0x704b81dcu);
    EXPECT_EQ(murmurHash3("Hello, world!"), 0xc0363e43u);
    EXPECT_EQ(murmurHash3("Hello, world!", 0x9747b28cu), 0x24884cbau);
    EXPECT_EQ(murmurHash3("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
    EXPECT_EQ(murmurHash3("The quick brown fox jumps over the lazy dog", 0x9747b28cu), 0x2fa826cdu);
}

// Floats of names, as the reference implementation's own tests have them.
TEST(Cryptomatte, FloatsAgreeWithTheReferenceImplementation) {
    const auto value = [](const char* name) { return double(cryptomatteFloat(cryptomatteId(name))); };
    EXPECT_NEAR(value("hello"), 6.0705627102400005616e-17, 1e-28);
    EXPECT_NEAR(value("cube"), -4.08461912519e+15, 1e4);
    EXPECT_NEAR(value("sphere"), 2.79018604383e+15, 1e4);
    EXPECT_NEAR(value("plane"), 3.66557617593e-11, 1e-22);
}

TEST(Cryptomatte, IdsAreNormalFloats) {
    int turned = 0;
    for (int i = 0; i < 20000; ++i) {
        const std::string name = "/World/Prim_" + std::to_string(i);
        const std::uint32_t id = cryptomatteId(name);
        EXPECT_TRUE(std::isnormal(cryptomatteFloat(id))) << name;
        turned += id != murmurHash3(name);
    }
    EXPECT_NEAR(turned, 20000 * 2 / 256.0, 60) << "two of 256 exponents";
}

std::uint32_t idOf(float value) {
    std::uint32_t id = 0;
    std::memcpy(&id, &value, sizeof(id));
    return id;
}

TEST(Coverage, IsRankedAndAMeanOverSamples) {
    Film film;
    film.keepCoverage(true);
    film.resize(1, 1);
    const std::uint32_t ids[] = {cryptomatteId("a"), cryptomatteId("b"), cryptomatteId("c")};
    for (int i = 0; i < 8; ++i) {
        PixelSample s;
        s.cover(ids[2], 0.25f); // a veil, before either
        s.cover(ids[i < 2 ? 0 : 1], 0.5f);
        s.cover(ids[2], 0.125f);
        EXPECT_EQ(s.alpha, 0.875f);
        film.add(0, 0, s);
    }
    const std::vector<float> first = film.read(Aov::CryptoObject00), second = film.read(Aov::CryptoObject01),
                             third = film.read(Aov::CryptoObject02);
    EXPECT_EQ(idOf(first[0]), idOf(cryptomatteFloat(std::min(ids[1], ids[2])))) << "equal ones by id";
    EXPECT_EQ(first[1], 0.375f);
    EXPECT_EQ(idOf(first[2]), std::max(ids[1], ids[2]));
    EXPECT_EQ(first[3], 0.375f);
    EXPECT_EQ(idOf(second[0]), ids[0]);
    EXPECT_EQ(second[1], 0.125f);
    EXPECT_EQ(second[2], 0);
    EXPECT_EQ(third, std::vector<float>(4, 0.0f));
    EXPECT_EQ(first[1] + first[3] + second[1], film.read(Aov::Alpha)[0]);
}

TEST(Coverage, IsNotKeptUnasked) {
    Film film;
    film.resize(1, 1);
    PixelSample s;
    s.cover(cryptomatteId("a"), 1);
    film.add(0, 0, s);
    EXPECT_EQ(film.read(Aov::CryptoObject00), std::vector<float>(4, 0.0f));
    EXPECT_EQ(film.read(Aov::Alpha)[0], 1);
}

TEST(Coverage, OfManyObjectsInOneSampleLosesNone) {
    PixelSample s;
    for (std::uint32_t i = 1; i <= 10; ++i) {
        s.cover(i, 0.0625f);
    }
    float sum = 0;
    for (int i = 0; i < s.coverCount; ++i) {
        sum += s.covers[i].amount;
    }
    EXPECT_EQ(sum, s.alpha);
}

} // namespace
} // namespace stf::test
