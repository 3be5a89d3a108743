// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shaped_emission.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr float kPi = 3.14159265f;

Vec3f away(float degrees, float turn = 0) {
    const float a = degrees * kPi / 180;
    return {std::sin(a) * std::cos(turn), std::sin(a) * std::sin(turn), -std::cos(a)};
}

float green(const LightShaping& s, float degrees) {
    return ShapedEmission("/light", s, {}).factor(away(degrees)).y;
}

std::string profile(const std::string& numbers) {
    return "IESNA:LM-63-2002\r\n[TEST] made up\r\nTILT=NONE\r\n" + numbers;
}

TEST(ShapedEmission, NothingAskedForChangesNothing) {
    EXPECT_TRUE(ShapedEmission("/light", LightShaping(), {}).none());
    EXPECT_EQ(green(LightShaping(), 120), 1);
}

TEST(ShapedEmission, FocusIsAPowerOfTheCosine) {
    LightShaping s;
    s.focus = 3;
    EXPECT_NEAR(green(s, 60), 0.125f, 1e-6f);
    EXPECT_NEAR(green(s, 120), 0.125f, 1e-6f); // behind as well: UsdLux takes the absolute value
    s.focusTint = Rgb(1, 0.5f, 0);
    const Rgb c = ShapedEmission("/light", s, {}).factor(away(60));
    EXPECT_NEAR(c.x, 1, 1e-6f);
    EXPECT_NEAR(c.y, 0.5f * 0.875f + 0.125f, 1e-6f);
    s.focus = -2; // ignored
    EXPECT_EQ(green(s, 60), 1);
}

TEST(ShapedEmission, ConesEndHardOrSoft) {
    LightShaping s;
    s.coneAngle = 30;
    EXPECT_EQ(green(s, 29.9f), 1);
    EXPECT_EQ(green(s, 30.1f), 0);
    s.coneSoftness = 0.5f; // from 15 degrees on
    EXPECT_EQ(green(s, 14.9f), 1);
    EXPECT_NEAR(green(s, 22.5f), 0.5f, 1e-5f);
    EXPECT_NEAR(green(s, 18.75f), 1 - 0.15625f, 1e-5f);
}

TEST(IesProfile, ReadsAndInterpolates) {
    // Axially symmetric: 100 candela downward, 50 at 90 degrees, none above.
    const IesProfile p = IesProfile::parse(profile("1 1000 2 3 1 1 2 0 0 0\n 1 1 60\n0 45 90\n0\n50 40 25\n"));
    EXPECT_NEAR(p.intensity(0, 0), 100, 1e-4f);
    EXPECT_NEAR(p.intensity(kPi / 4, 2), 80, 1e-3f);
    EXPECT_NEAR(p.intensity(67.5f * kPi / 180, -1), 65, 1e-3f);
    EXPECT_EQ(p.intensity(2, 0), 0);
    // Linear in the angle: 2 pi times the integral of I sin, in two pieces.
    const auto piece = [](double a, double b, double from, double to) {
        const double slope = (b - a) / (to - from);
        return a * std::cos(from) - b * std::cos(to) + slope * (std::sin(to) - std::sin(from));
    };
    const double q = double(kPi) / 4;
    EXPECT_NEAR(p.power(), 2 * double(kPi) * (piece(100, 80, 0, q) + piece(80, 50, q, 2 * q)), 0.01);
}

TEST(IesProfile, HorizontalSymmetries) {
    const std::string head = "1 1000 1 2 3 1 2 0 0 0 1 1 60 0 90 ";
    const IesProfile quadrant = IesProfile::parse(profile(head + "0 45 90  10 10 20 20 40 40"));
    for (float turn : {0.5f, kPi - 0.5f, kPi + 0.5f, -0.5f}) {
        EXPECT_NEAR(quadrant.intensity(1, turn), quadrant.intensity(1, 0.5f), 1e-3f);
    }
    EXPECT_NEAR(quadrant.intensity(1, kPi / 2), 40, 1e-3f);
    const IesProfile half = IesProfile::parse(profile(head + "0 90 180  10 10 20 20 40 40"));
    EXPECT_NEAR(half.intensity(1, kPi), 40, 1e-3f);
    EXPECT_NEAR(half.intensity(1, -kPi / 2), 20, 1e-3f);
    const IesProfile whole = IesProfile::parse(profile(head + "0 180 360  10 10 20 20 10 10"));
    EXPECT_NEAR(whole.intensity(1, 1.5f * kPi), 15, 1e-3f);
}

TEST(IesProfile, BadFilesAreNamed) {
    const auto reason = [](const std::string& text) {
        try {
            IesProfile::parse(text);
        } catch (const Error& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    EXPECT_THAT(reason("hello"), ::testing::HasSubstr("not a photometric profile"));
    EXPECT_THAT(reason("TILT=INCLUDE\n1 2"), ::testing::HasSubstr("tilt"));
    EXPECT_THAT(reason(profile("1 1000 1 3 1 1 2 0 0 0 1 1 60 0 45 90 0 50 40")), ::testing::HasSubstr("candela"));
    EXPECT_THAT(reason(profile("1 1000 1 3 1 2 2 0 0 0 1 1 60 0 45 90 0 50 40 25")), ::testing::HasSubstr("type C"));
    EXPECT_THAT(reason(profile("1 1000 1 3 1 1 2 0 0 0 1 1 60 0 95 90 0 50 40 25")), ::testing::HasSubstr("ascend"));
    EXPECT_THAT(reason(profile("1 1000 1 3 1 1 2 0 0 0 1 1 60 0 45 90 0 50 -40 25")), ::testing::HasSubstr("negative"));
    EXPECT_THAT(reason(profile("1 1000 1 3e9 1 1 2 0 0 0 1 1 60")), ::testing::HasSubstr("number of vertical"));
    std::string said;
    LightShaping s;
    s.iesFile = "/nowhere/lamp.ies";
    const ShapedEmission e("/light", s, [&](Severity, const std::string& t) { said = t; });
    EXPECT_THAT(said, ::testing::AllOf(::testing::HasSubstr("/light"), ::testing::HasSubstr("lamp.ies")));
    EXPECT_TRUE(e.none());
}

} // namespace
} // namespace stf::test
