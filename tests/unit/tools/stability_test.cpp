// SPDX-License-Identifier: Apache-2.0
// Each case of `stf stability` is a test, and the suite covers what it says.
#include "tools/stability/stability_case.h"

#include <cctype>
#include <gtest/gtest.h>
#include <set>

namespace stf {

// How gtest names a case where it fails.
static void PrintTo(const StabilityCase& c, std::ostream* out) {
    *out << c.id;
}

} // namespace stf

namespace stf::test {
namespace {

class Stability : public testing::TestWithParam<StabilityCase> {};

TEST_P(Stability, Holds) {
    StabilityRun run;
    const StabilityOutcome o = runStabilityCase(GetParam(), run);
    std::printf("%s\n", o.measured.c_str());
    EXPECT_TRUE(o.ok) << GetParam().input << "; must hold: " << GetParam().mustHold << "; measured: " << o.measured;
}

INSTANTIATE_TEST_SUITE_P(Cases, Stability, testing::ValuesIn(stabilityCases()), [](const auto& one) {
    std::string name = one.param.id;
    for (char& c : name) {
        c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
    }
    return "Point" + name;
});

TEST(StabilitySuite, CoversAllPointsAlsoWhenQuick) {
    for (int point = 1; point <= 13; ++point) {
        EXPECT_FALSE(chooseStabilityCases({std::to_string(point)}, false).empty()) << point;
        if (point != 13) { // convergence is not to be had quickly
            EXPECT_FALSE(chooseStabilityCases({std::to_string(point)}, true).empty()) << point;
        }
    }
    std::set<std::string> ids;
    for (const StabilityCase& c : stabilityCases()) {
        EXPECT_TRUE(ids.insert(c.id).second) << c.id;
        EXPECT_FALSE(c.input.empty() || c.mustHold.empty()) << c.id;
    }
}

TEST(StabilitySuite, IsChosenByPointAndId) {
    for (const StabilityCase& c : chooseStabilityCases({"1"}, false)) {
        EXPECT_EQ(c.id.rfind("1.", 0), 0u) << c.id;
    }
    EXPECT_EQ(chooseStabilityCases({"8.light-doubled"}, false).size(), 1u);
    EXPECT_THROW(chooseStabilityCases({"8.light"}, false), Error);
    EXPECT_THROW(chooseStabilityCases({"14"}, false), Error);
}

TEST(StabilitySuite, WhatThrowsFails) {
    StabilityRun run;
    StabilityCase c;
    c.run = [](StabilityRun&) -> StabilityOutcome { throw Error("it broke"); };
    const StabilityOutcome o = runStabilityCase(c, run);
    EXPECT_FALSE(o.ok);
    EXPECT_EQ(o.measured, "failed: it broke");
}

} // namespace
} // namespace stf::test
