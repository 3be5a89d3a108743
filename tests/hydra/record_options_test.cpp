// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/image.h"
#include "tools/stfrecord/options.h"

#include "stfLib/base/temporary_folder.h"

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>

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

std::optional<int> parse(std::vector<std::string> words, Options& options) {
    words.insert(words.begin(), {"stfrecord", "in.usda", "out.exr"});
    std::vector<char*> argv;
    for (std::string& word : words) {
        argv.push_back(word.data());
    }
    return parseOptions(static_cast<int>(argv.size()), argv.data(), options);
}

TEST(RecordOptions, Crop) {
    Options options;
    EXPECT_FALSE(parse({"--crop", "0.25,0,0.5,1"}, options));
    EXPECT_EQ(*options.crop, (std::array<float, 4>{0.25f, 0, 0.5f, 1}));
    EXPECT_FALSE(parse({"--crop=-0.1,-0.1,1.1,1.1"}, options));
    EXPECT_EQ((*options.crop)[0], -0.1f);
    for (const char* bad : {"0,0,1", "0,0,1,1,1", "0.5,0,0.5,1", "0,1,1,0", "a,0,1,1", "0,0,nan,1"}) {
        EXPECT_EQ(parse({"--crop", bad}, options), std::optional<int>(BadUsage)) << bad;
    }
}

// The image lies in its frame: data window and display window as OpenEXR has them, rows from the top.
TEST(RecordOptions, WindowsAreWritten) {
    const stf::TemporaryFolder folder;
    Image image;
    image.width = 3;
    image.height = 2;
    image.frame = {-10, -20, 40, 30};
    image.layers = {{"alpha", 1, {1, 2, 3, 4, 5, 6}, {}}};
    writeExr(image, folder.file("part.exr"));
    Imf::InputFile file(folder.file("part.exr").c_str());
    EXPECT_EQ(file.header().displayWindow(), Imath::Box2i({0, 0}, {39, 29}));
    const Imath::Box2i data = file.header().dataWindow();
    EXPECT_EQ(data, Imath::Box2i({10, 20}, {12, 21}));
    std::vector<float> read(6);
    Imf::FrameBuffer frame;
    frame.insert("alpha.A", Imf::Slice::Make(Imf::FLOAT, read.data(), data));
    file.setFrameBuffer(frame);
    file.readPixels(data.min.y, data.max.y);
    EXPECT_EQ(read, image.layers[0].floats);
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
