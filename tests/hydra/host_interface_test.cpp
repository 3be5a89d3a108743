// SPDX-License-Identifier: Apache-2.0
#include "hdStf/hostInterface.h"

#include "hdStf/settings.h"
#include "test_host.h"

#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

nlohmann::json call(size_t (*function)(char*, size_t)) {
    std::string text(function(nullptr, 0), 'x');
    EXPECT_EQ(function(text.data(), text.size()), text.size());
    EXPECT_EQ(text.back(), 0);
    text.pop_back();
    return nlohmann::json::parse(text);
}

// Panels made from this text show what panels made from the descriptors show.
TEST(HostInterface, SettingsAreTheDescriptors) {
    const nlohmann::json list = call(hdStfSettingsJson);
    const HdRenderSettingDescriptorList descriptors = HdStfPanelDescriptors(HdStfMakeSettingDescriptors());
    ASSERT_EQ(list.size(), descriptors.size());
    for (size_t i = 0; i < list.size(); ++i) {
        EXPECT_EQ(list[i]["key"], descriptors[i].key.GetString());
        EXPECT_EQ(list[i]["name"], descriptors[i].name);
        EXPECT_FALSE(list[i]["description"].get<std::string>().empty());
        const VtValue& value = descriptors[i].defaultValue;
        EXPECT_EQ(list[i]["default"].is_boolean(), value.IsHolding<bool>()) << list[i];
        EXPECT_EQ(list[i]["default"].is_number_integer(), value.IsHolding<int>()) << list[i];
        EXPECT_EQ(list[i]["default"].is_number_float(), value.IsHolding<float>()) << list[i];
        EXPECT_EQ(list[i]["default"].is_string(), value.IsHolding<std::string>()) << list[i];
    }
}

TEST(HostInterface, RangesAndChoicesAreNamed) {
    std::map<std::string, nlohmann::json> settings;
    for (const nlohmann::json& setting : call(hdStfSettingsJson)) {
        settings[setting["key"]] = setting;
    }
    EXPECT_EQ(settings["stf:samples"]["least"], 1);
    EXPECT_FALSE(settings["stf:samples"].contains("most"));
    EXPECT_EQ(settings["stf:pixelFilterWidth"]["most"], 64);
    EXPECT_EQ(settings["stf:transport"]["choices"], nlohmann::json({"dE1", "classic"}));
    EXPECT_EQ(settings["stf:transport"]["description"].get<std::string>().find('`'), std::string::npos);
}

TEST(HostInterface, StatusIsThatOfTheDelegateMadeLast) {
    const size_t before = hdStfStatusJson(nullptr, 0);
    EXPECT_EQ(before, 3u) << "an empty object and a zero: no delegate is there";
    TestHost host(testScene("    asset primvars:stf:baseVolume = @./none.vdb@"));
    ASSERT_TRUE(host.renderToEnd());
    const nlohmann::json status = call(hdStfStatusJson);
    EXPECT_EQ(status["annotation"], "done");
    EXPECT_EQ(status["percentDone"], 100.0);
    ASSERT_EQ(status["messages"].size(), 1u) << status;
    EXPECT_EQ(status["messages"][0]["severity"], "error");
    EXPECT_NE(status["messages"][0]["text"].get<std::string>().find("none.vdb"), std::string::npos);
    {
        const TestHost newer(testScene());
        EXPECT_TRUE(call(hdStfStatusJson)["messages"].empty());
    }
    EXPECT_EQ(call(hdStfStatusJson), status);
}

TEST(HostInterface, ShortBuffersAreFilledAndClosed) {
    char buffer[5] = {'x', 'x', 'x', 'x', 'x'};
    EXPECT_GT(hdStfSettingsJson(buffer, 4), 100u);
    EXPECT_STREQ(buffer, R"([{")");
    EXPECT_EQ(buffer[4], 'x');
}

} // namespace
