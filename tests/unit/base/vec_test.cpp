// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/vec.h"

#include "stfLib/base/random.h"

#include <gtest/gtest.h>
#include <limits>

using namespace stf;

namespace {

template<class T>
void expectFrame(const Vec3<T>& n) {
    Vec3<T> t, b;
    orthonormalBasis(n, t, b);
    const T eps = 8 * std::numeric_limits<T>::epsilon();
    EXPECT_NEAR(length(t), T(1), eps);
    EXPECT_NEAR(length(b), T(1), eps);
    EXPECT_NEAR(dot(t, b), T(0), eps);
    EXPECT_NEAR(dot(t, n), T(0), eps);
    EXPECT_NEAR(dot(b, n), T(0), eps);
    EXPECT_NEAR(length(cross(t, b) - n), T(0), eps) << "not right-handed";
}

TEST(OrthonormalBasis, AtThePoles) {
    for (float z : {1.0f, -1.0f}) {
        for (float zero : {0.0f, -0.0f}) {
            expectFrame(Vec3f(zero, zero, z));
            expectFrame(Vec3d(double(zero), double(zero), double(z)));
        }
    }
}

TEST(OrthonormalBasis, NearThePolesAndTheEquator) {
    for (float e : {1e-3f, 1e-5f, 1e-7f, 1e-20f}) {
        for (float sign : {1.0f, -1.0f}) {
            expectFrame(normalize(Vec3f(e, -e, sign)));
            expectFrame(normalize(Vec3f(1, 0.3f, sign * e)));
        }
    }
    expectFrame(Vec3f(1, 0, 0.0f));
    expectFrame(Vec3f(0, -1, -0.0f));
}

TEST(OrthonormalBasis, Everywhere) {
    CounterRng rng(1, 0);
    for (int i = 0; i < 10000; ++i) {
        expectFrame(normalize(Vec3f(rng.uniform() - 0.5f, rng.uniform() - 0.5f, rng.uniform() - 0.5f)));
    }
}

TEST(Vec, NormalizeLeavesWhatHasNoDirection) {
    EXPECT_EQ(normalize(Vec3f(0.0f)), Vec3f(0.0f));
    const float inf = std::numeric_limits<float>::infinity();
    EXPECT_EQ(normalize(Vec3f(inf, 0, 0)), Vec3f(inf, 0, 0));
    EXPECT_NEAR(length(normalize(Vec3f(3, 4, 12))), 1.0f, 1e-6f);
}

TEST(Vec, Box) {
    Box3f box;
    EXPECT_TRUE(box.empty());
    EXPECT_EQ(box.diagonal(), 0.0f);
    box.add({1, 2, 3});
    EXPECT_FALSE(box.empty());
    box.add({4, 6, 3});
    EXPECT_FLOAT_EQ(box.diagonal(), 5.0f);
}

TEST(Vec, LuminanceOfWhiteIsOne) {
    EXPECT_FLOAT_EQ(luminance(Rgb(1.0f)), 1.0f);
}

} // namespace
