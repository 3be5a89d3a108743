// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/near_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

using namespace stf;
using testing::ElementsAre;
using testing::IsEmpty;

namespace {

TEST(NearNames, NearestFirst) {
    const std::vector<std::string> names{"Marble", "Apple", "Merlot", "Garble"};
    EXPECT_THAT(nearNames("marbel", names), ElementsAre("Marble"));
    EXPECT_THAT(nearNames("garbl", names), ElementsAre("Garble", "Marble"));
    EXPECT_THAT(nearNames("garbl", names, 1), ElementsAre("Garble"));
}

TEST(NearNames, CaseAndSpacesDoNotCount) {
    EXPECT_EQ(comparableName("Low-fat Soy_Milk"), "lowfatsoymilk");
    EXPECT_THAT(nearNames("SKIM MILK", {"Skimmilk", "Wholemilk"}), ElementsAre("Skimmilk"));
}

TEST(NearNames, PartsAreNear) {
    EXPECT_THAT(nearNames("soy", {"Regular Soy Milk", "Coke"}), ElementsAre("Regular Soy Milk"));
    EXPECT_THAT(nearNames("a", {"Spectralon"}), IsEmpty()) << "a letter is in nearly everything";
}

TEST(NearNames, Sentence) {
    EXPECT_EQ(didYouMean("xylophone", {"Marble"}), "");
    EXPECT_EQ(didYouMean("skin", {"Skin1", "Skin2"}), " (did you mean Skin1 or Skin2?)");
    EXPECT_EQ(didYouMean("skin", {"Skin1", "Skin2", "Skin3"}), " (did you mean Skin1, Skin2 or Skin3?)");
}

} // namespace
