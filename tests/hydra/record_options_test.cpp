// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/image.h"
#include "tools/stfrecord/options.h"

#include <gtest/gtest.h>

namespace stfrecord {
namespace {

std::vector<double> frames(const std::string& text) {
    std::string error;
    return parseFrames(text, error);
}

TEST(RecordOptions, Frames) {
    EXPECT_EQ(frames("7"), (std::vector<double>{7}));
    EXPECT_EQ(frames("1:3"), (std::vector<double>{1, 2, 3}));
    EXPECT_EQ(frames("3:1"), (std::vector<double>{3, 2, 1}));
    EXPECT_EQ(frames("1:10x4"), (std::vector<double>{1, 5, 9}));
    EXPECT_EQ(frames("0:1x0.5,9"), (std::vector<double>{0, 0.5, 1, 9}));
    for (const char* bad : {"", "a", "1:", "1:2x0", "1:2x-1", "1:2x", "1::2", "0:1e30", "nan"}) {
        EXPECT_TRUE(frames(bad).empty()) << bad;
    }
}

TEST(RecordOptions, FilePerFrame) {
    EXPECT_EQ(framePath("a.exr", 7, false), "a.exr");
    EXPECT_EQ(framePath("a.exr", 7, true), "a.0007.exr");
    EXPECT_EQ(framePath("d.x/a", 7, true), "d.x/a.0007");
    EXPECT_EQ(framePath("a.###.exr", 7, false), "a.007.exr");
    EXPECT_EQ(framePath("a.##.exr", 1234.5, true), "a.1234.500.exr");
    EXPECT_EQ(framePath("a.#.exr", -2, true), "a.-2.exr");
}

TEST(RecordOptions, ChannelNames) {
    EXPECT_EQ(channelNames({"color", 4, {}, {}}), (std::vector<std::string>{"R", "G", "B", "A"}));
    EXPECT_EQ(channelNames({"normal", 3, {}, {}}), (std::vector<std::string>{"normal.X", "normal.Y", "normal.Z"}));
    EXPECT_EQ(channelNames({"depth", 1, {}, {}}), (std::vector<std::string>{"depth.Z"}));
    EXPECT_EQ(channelNames({"primId", 1, {}, {0}}), (std::vector<std::string>{"primId.id"}));
    EXPECT_EQ(channelNames({"stf:core", 3, {}, {}}),
              (std::vector<std::string>{"stf:core.R", "stf:core.G", "stf:core.B"}));
}

} // namespace
} // namespace stfrecord
