// SPDX-License-Identifier: Apache-2.0
// The one table of settings and variables against the documentation and the sources.
#include "hdStf/settingTable.h"

#include "hdStf/settingDocs.h"
#include "stfLib/base/error.h"
#include "stfLib/render/exactness.h"
#include "stfLib/render/pixel_filter.h"

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <regex>
#include <set>
#include <sstream>

namespace stf::test {
namespace {

std::string textOf(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    EXPECT_TRUE(file) << path;
    return text.str();
}

const std::filesystem::path kSources = STF_SOURCE_FOLDER;

TEST(SettingTable, TheDocumentationIsThatOfTheTable) {
    const std::string text = textOf(kSources / "docs/settings.md");
    EXPECT_EQ(withSettingTables(text), text) << "run: stf settings --update docs/settings.md";
    EXPECT_THAT(
        text, ::testing::HasSubstr("| `stf:samples` | int | 64 | at least 1 | `HDSTF_SAMPLES` | samples per pixel |"));
}

TEST(SettingTable, ADocumentWithoutMarksIsRefused) {
    EXPECT_THROW(withSettingTables("# Settings\n"), Error);
    EXPECT_THROW(withSettingTables("<!-- stf settings: settings -->\n"), Error);
}

TEST(SettingTable, KeysAndVariablesAreThereOnce) {
    std::set<std::string> keys;
    for (const SettingRow& row : settingTable()) {
        EXPECT_TRUE(keys.insert(row.key).second) << row.key;
        EXPECT_FALSE(row.meaning.empty()) << row.key;
    }
    const std::vector<std::string> names = variableNames();
    EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
}

// None is read that is not documented.
TEST(SettingTable, EveryVariableThatTheSourcesReadIsInIt) {
    const std::vector<std::string> names = variableNames();
    const std::regex read("(?:[gG]etenv|environment|environ\\.get|environ)[(\\[]\"(HDSTF_[A-Z_]+)\"");
    std::set<std::string> found;
    for (const char* folder : {"stfLib", "hdStf", "tools", "tests"}) {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(kSources / folder)) {
            const std::string ending = entry.path().extension().string();
            if (ending != ".cpp" && ending != ".h" && ending != ".py") {
                continue;
            }
            const std::string text = textOf(entry.path());
            for (std::sregex_iterator m(text.begin(), text.end(), read), end; m != end; ++m) {
                found.insert((*m)[1]);
            }
        }
    }
    EXPECT_GE(found.size(), 6u) << "the search finds what it looks for";
    for (const std::string& name : found) {
        EXPECT_THAT(names, ::testing::Contains(name));
    }
}

TEST(SettingTable, ChoicesAreThoseThatTheRendererKnows) {
    for (const SettingRow& row : settingTable()) {
        for (const std::string& choice : row.choices) {
            PixelFilter::Shape shape;
            if (row.key == "stf:pixelFilter") {
                EXPECT_TRUE(PixelFilter::shapeFromName(choice, shape)) << choice;
            } else if (row.key == "stf:exact") {
                EXPECT_NE(Exactness::parse(choice), Exactness()) << choice;
            } else {
                EXPECT_TRUE(row.key == "stf:transport" || row.key == "stf:integrator") << row.key;
            }
        }
    }
}

TEST(SettingTable, RangesInWords) {
    SettingRow row;
    row.own = 1.0f;
    EXPECT_EQ(settingRange(row), "");
    row.least = 0;
    EXPECT_EQ(settingRange(row), "at least 0");
    row.aboveLeast = true;
    EXPECT_EQ(settingRange(row), "above 0");
    row.most = 64;
    row.aboveLeast = false;
    EXPECT_EQ(settingRange(row), "0 to 64");
    SettingRow word;
    word.choices = {"a", "b"};
    EXPECT_EQ(settingRange(word), "`a`, `b`");
    word.several = true;
    EXPECT_EQ(settingRange(word), "any of `a`, `b`");
}

TEST(SettingTable, SeveralChoicesAtOnce) {
    SettingRow row;
    row.own = std::string();
    row.choices = {"a", "b"};
    EXPECT_TRUE(settingChooses(row, "a"));
    EXPECT_FALSE(settingChooses(row, "")) << "one has to be chosen";
    EXPECT_FALSE(settingChooses(row, "a,b"));
    row.several = true;
    for (const char* text : {"", "a", "b", "a,b", "b,a"}) {
        EXPECT_TRUE(settingChooses(row, text)) << text;
        EXPECT_TRUE(settingTakes(row, text)) << text;
    }
    for (const char* text : {"c", "a,c", "a,", ",a", "a b", ","}) {
        EXPECT_FALSE(settingChooses(row, text)) << text;
    }
}

TEST(SettingTable, ValuesInWords) {
    EXPECT_EQ(settingText(true), "on");
    EXPECT_EQ(settingText(0.02f), "0.02");
    EXPECT_EQ(settingText(std::string("dE1")), "dE1");
    EXPECT_EQ(settingText(std::array<float, 4>{0, 0, 1, 1}), "0 0 1 1");
    EXPECT_EQ(settingType(0.01), "double");
    EXPECT_EQ(settingType(std::array<float, 4>{}), "float4");
}

} // namespace
} // namespace stf::test
