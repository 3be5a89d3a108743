// SPDX-License-Identifier: Apache-2.0
#include "hdStf/settings.h"

#include "hdStf/renderStats.h"
#include "hdStf/settingTable.h"
#include "hdStf/tokens.h"

#include "test_host.h"

#include "pxr/base/gf/vec4f.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <set>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

VtValue normalized(const char* key, const VtValue& value) {
    return HdStfNormalizeSetting(HdStfMakeSettingDescriptors(), TfToken(key), value);
}

TEST(Settings, ValuesTakeTheTypeOfTheDefault) {
    EXPECT_EQ(normalized("stf:samples", VtValue(16L)), VtValue(16));
    EXPECT_EQ(normalized("stf:samples", VtValue(std::string("16"))), VtValue(16));
    EXPECT_EQ(normalized("stf:tableSeed", VtValue(std::string("3"))), VtValue(3));
    EXPECT_EQ(normalized("stf:quality", VtValue(0.5)), VtValue(0.5f));
    // Blender hands booleans over as integers.
    EXPECT_EQ(normalized("stf:denoise", VtValue(1)), VtValue(true));
    EXPECT_EQ(normalized("stf:motionBlur", VtValue(0L)), VtValue(false));
    EXPECT_EQ(normalized("stageMetersPerUnit", VtValue(1.0f)), VtValue(1.0));
    EXPECT_EQ(normalized("stf:transport", VtValue(TfToken("classic"))), VtValue(std::string("classic")));
}

TEST(Settings, ValuesOutOfRangeAreBroughtInOrRefused) {
    EXPECT_EQ(normalized("stf:samples", VtValue(-3)), VtValue(1));
    EXPECT_EQ(normalized("stf:threads", VtValue(-1)), VtValue(0));
    EXPECT_TRUE(normalized("stf:quality", VtValue(0.0f)).IsEmpty());
    EXPECT_TRUE(normalized("stageMetersPerUnit", VtValue(std::numeric_limits<double>::quiet_NaN())).IsEmpty());
    EXPECT_TRUE(normalized("stf:samples", VtValue(std::string("many"))).IsEmpty());
    EXPECT_TRUE(normalized("stf:transport", VtValue(std::string("similarity"))).IsEmpty());
    EXPECT_EQ(normalized("stf:integrator", VtValue(TfToken("reference"))), VtValue(std::string("reference")));
    EXPECT_TRUE(normalized("stf:integrator", VtValue(std::string("bdpt"))).IsEmpty());
    EXPECT_TRUE(normalized("noSuchSetting", VtValue(1)).IsEmpty());
}

TEST(Settings, TokensNameTheRowsOfTheTable) {
    std::set<std::string> tokens, keys;
    for (TfToken const& token : HdStfRenderSettingsTokens->allTokens) {
        tokens.insert(token.GetString());
    }
    for (stf::SettingRow const& row : stf::settingTable()) {
        keys.insert(row.key);
    }
    EXPECT_EQ(tokens, keys);
}

TEST(Settings, DescriptorsAreTheTable) {
    const HdRenderSettingDescriptorList list = HdStfMakeSettingDescriptors();
    std::vector<stf::SettingRow> const& table = stf::settingTable();
    ASSERT_EQ(list.size(), table.size());
    for (size_t i = 0; i < list.size(); ++i) {
        EXPECT_EQ(list[i].key, table[i].key);
        EXPECT_EQ(list[i].name, table[i].name);
        // Every default is a value of its own setting, and every choice is taken.
        EXPECT_EQ(normalized(table[i].key.c_str(), list[i].defaultValue), list[i].defaultValue) << table[i].key;
        for (std::string const& choice : table[i].choices) {
            EXPECT_EQ(normalized(table[i].key.c_str(), VtValue(choice)), VtValue(choice));
        }
    }
}

TEST(Settings, EdgesOfRanges) {
    EXPECT_EQ(normalized("stf:pixelFilterWidth", VtValue(64.0f)), VtValue(64.0f));
    EXPECT_TRUE(normalized("stf:pixelFilterWidth", VtValue(64.5f)).IsEmpty());
    EXPECT_TRUE(normalized("stf:pixelFilterWidth", VtValue(-1.0f)).IsEmpty());
    EXPECT_EQ(normalized("stf:errorTarget", VtValue(0.0f)), VtValue(0.0f));
    EXPECT_TRUE(normalized("stf:errorTarget", VtValue(std::numeric_limits<float>::infinity())).IsEmpty());
    EXPECT_EQ(normalized("stf:seed", VtValue(-5)), VtValue(-5));
    EXPECT_EQ(normalized("stf:maxDepth", VtValue(-1)), VtValue(0));
    const VtValue window(GfVec4f(-0.5f, 0, 1.5f, 1));
    EXPECT_EQ(normalized("dataWindowNDC", window), window);
    EXPECT_TRUE(normalized("dataWindowNDC", VtValue(GfVec4f(1, 0, 0, 1))).IsEmpty());
    EXPECT_TRUE(normalized("dataWindowNDC", VtValue(GfVec4f(0, 0, 16, 1))).IsEmpty());
}

TEST(Settings, EnvironmentChangesDefaults) {
    setenv("HDSTF_SAMPLES", "7", 1);
    setenv("HDSTF_QUALITY", "nonsense", 1);
    setenv("HDSTF_ERROR_TARGET", "-1", 1);
    const HdRenderSettingDescriptorList list = HdStfMakeSettingDescriptors();
    unsetenv("HDSTF_SAMPLES");
    unsetenv("HDSTF_QUALITY");
    unsetenv("HDSTF_ERROR_TARGET");
    const auto of = [&list](char const* key) {
        for (HdRenderSettingDescriptor const& descriptor : list) {
            if (descriptor.key == key) {
                return descriptor.defaultValue;
            }
        }
        return VtValue();
    };
    EXPECT_EQ(of("stf:samples"), VtValue(7));
    EXPECT_EQ(of("stf:quality"), VtValue(0.02f));
    EXPECT_EQ(of("stf:errorTarget"), VtValue(0.0f));
}

TEST(Settings, SettingsAtCreationAreNormalized) {
    HdRenderSettingsMap map;
    map[TfToken("stf:samples")] = VtValue(9L);
    map[TfToken("stf:seed")] = VtValue(std::string("not a number"));
    const HdStfRenderDelegate delegate(map);
    EXPECT_EQ(delegate.GetRenderSetting(TfToken("stf:samples")), VtValue(9));
    EXPECT_EQ(delegate.GetRenderSetting(TfToken("stf:seed")), VtValue(0));
}

TEST(Settings, PanelsAreOfferedTypesTheyHaveWidgetsFor) {
    const HdStfRenderDelegate delegate;
    const HdRenderSettingDescriptorList list = delegate.GetRenderSettingDescriptors();
    EXPECT_EQ(list.size(), HdStfMakeSettingDescriptors().size() - 1); // dataWindowNDC is for hosts to set, not to show
    for (HdRenderSettingDescriptor const& descriptor : list) {
        VtValue const& value = descriptor.defaultValue;
        EXPECT_TRUE(value.IsHolding<bool>() || value.IsHolding<int>() || value.IsHolding<float>() ||
                    value.IsHolding<std::string>())
            << descriptor.key << " is of type " << value.GetTypeName();
        EXPECT_FALSE(delegate.GetRenderSetting(descriptor.key).IsEmpty()) << descriptor.key;
    }
    EXPECT_EQ(delegate.GetRenderSetting(TfToken("stageMetersPerUnit")), VtValue(0.01));
    EXPECT_EQ(delegate.GetRenderSetting(TfToken("dataWindowNDC")), VtValue(GfVec4f(0, 0, 1, 1)));
}

TEST(Settings, EqualValuesRestartNothing) {
    TestHost host(testScene());
    ASSERT_TRUE(host.renderToEnd());
    host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(2));
    host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(2L));
    host.delegate->SetRenderSetting(TfToken("stageMetersPerUnit"), VtValue(0.01));
    host.delegate->SetRenderSetting(TfToken("noSuchSetting"), VtValue(1));
    EXPECT_FALSE(host.restarts());
    host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(3));
    EXPECT_TRUE(host.restarts());
    host.delegate->SetRenderSetting(TfToken("stageMetersPerUnit"), VtValue(1.0));
    EXPECT_TRUE(host.restarts());
    EXPECT_EQ(host.delegate->GetScene().metersPerUnit(), 1.0);
}

TEST(Settings, TheSeedOfTablesReachesTheRenderer) {
    TestHost host(testScene());
    EXPECT_EQ(host.delegate->GetStfSettings().tableSeed, 0u);
    ASSERT_TRUE(host.renderToEnd());
    host.delegate->SetRenderSetting(TfToken("stf:tableSeed"), VtValue(7));
    EXPECT_EQ(host.delegate->GetStfSettings().tableSeed, 7u);
    EXPECT_TRUE(host.restarts());
}

TEST(Settings, StatisticsHaveTheTypesHostsRead) {
    TestHost host(testScene());
    ASSERT_TRUE(host.renderToEnd());
    const VtDictionary stats = host.delegate->GetRenderStats();
    ASSERT_TRUE(stats.find("percentDone")->second.IsHolding<double>());
    EXPECT_EQ(stats.find("percentDone")->second.UncheckedGet<double>(), 100.0);
    EXPECT_TRUE(stats.find("totalClockTime")->second.IsHolding<double>());
    EXPECT_EQ(stats.find("numCompletedSamples")->second, VtValue(2));
    EXPECT_EQ(stats.find("fractionDone")->second, VtValue(1.0));
    EXPECT_EQ(stats.find("rendererStage")->second, VtValue(std::string("done")));
    EXPECT_EQ(stats.find("stf:stageFraction")->second, VtValue(1.0));
    ASSERT_TRUE(stats.find("totalMemory")->second.IsHolding<size_t>());
    const size_t now = stats.find("totalMemory")->second.UncheckedGet<size_t>();
    EXPECT_GT(now, size_t(1) << 20);
    EXPECT_LE(now, stats.find("peakMemory")->second.UncheckedGet<size_t>() + (size_t(1) << 20));
    EXPECT_TRUE(stats.find("stf:estimatedError")->second.IsHolding<double>());
}

TEST(Settings, StatisticsFollowTheJob) {
    HdStfMessages messages;
    HdStfRenderJob::Progress progress;
    progress.stage = "transport";
    progress.stageFraction = 0.25;
    progress.samplesWanted = 8;
    progress.clockSeconds = 1.5;
    const auto of = [&](char const* key) {
        const VtDictionary stats = HdStfMakeRenderStats(progress, messages);
        const auto it = stats.find(key);
        return it == stats.end() ? VtValue() : it->second;
    };
    EXPECT_EQ(of("rendererStage"), VtValue(std::string("transport")));
    EXPECT_EQ(of("stf:stageFraction"), VtValue(0.25));
    EXPECT_EQ(of("percentDone"), VtValue(0.0));
    EXPECT_EQ(of("totalClockTime"), VtValue(1.5));
    progress.samplesDone = 2;
    progress.stats.estimatedError = 0.125;
    EXPECT_EQ(of("rendererStage"), VtValue(std::string("render")));
    EXPECT_EQ(of("percentDone"), VtValue(25.0));
    EXPECT_EQ(of("fractionDone"), VtValue(0.25));
    EXPECT_EQ(of("stf:stageFraction"), VtValue(0.25));
    EXPECT_EQ(of("numCompletedSamples"), VtValue(2));
    EXPECT_EQ(of("stf:estimatedError"), VtValue(0.125));
    progress.finished = true; // by the error wanted, before all samples
    EXPECT_EQ(of("percentDone"), VtValue(100.0));
    EXPECT_EQ(of("rendererStage"), VtValue(std::string("done")));
}

} // namespace
