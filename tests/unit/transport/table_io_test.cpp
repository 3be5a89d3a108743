// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/stf_table.h"

#include "stfLib/base/error.h"
#include "stfLib/base/random.h"
#include "tests/unit/support/files.h"

using namespace stf;
using namespace stf::test;

namespace {

StfTable made() {
    StfTable t;
    t.size = {3, 5, 2};
    t.voxelMm = {0.5, 0.25, 0.125};
    t.directions = DirectionSet(3, 4);
    CounterRng rng(1, 1);
    const auto fill = [&](std::vector<float>& values, std::size_t count) {
        values.resize(count);
        for (float& v : values) {
            v = rng.uniform() < 0.2f ? 0.0f : rng.uniform() * 1e-6f; // zeros are inactive in the file
        }
    };
    fill(t.multiple, 30 * 12 * 3);
    fill(t.transmitted, 15 * 12 * 3);
    fill(t.direct, 15 * 12 * 3);
    for (int i = 0; i < 30; ++i) {
        t.backlight.emplace_back(rng.uniform(), rng.uniform(), 1e30f);
    }
    for (int i = 0; i < 15; ++i) {
        t.reflectedBelow.emplace_back(0.0f, rng.uniform(), 1.0f);
    }
    t.volumeHash = "abc";
    t.photonsPerDirection = 12345678901ull;
    t.seed = 99;
    t.relativeError = 0.0123;
    t.seconds = 1.5;
    return t;
}

TEST(TableIo, RoundTripIsExact) {
    const TemporaryFolder folder;
    const StfTable t = made();
    writeTable(t, "key", folder.file("t.vdb"));
    for (const char* key : {"key", ""}) { // no key: whatever it was made for
        const StfTable r = readTable(folder.file("t.vdb"), key);
        EXPECT_EQ(r.size, t.size);
        EXPECT_EQ(r.voxelMm, t.voxelMm);
        EXPECT_EQ(r.directions.polars(), 3);
        EXPECT_EQ(r.directions.azimuths(), 4);
        EXPECT_TRUE(r.multiple == t.multiple);
        EXPECT_TRUE(r.transmitted == t.transmitted);
        EXPECT_TRUE(r.direct == t.direct);
        EXPECT_TRUE(r.backlight == t.backlight);
        EXPECT_TRUE(r.reflectedBelow == t.reflectedBelow);
        EXPECT_EQ(r.volumeHash, t.volumeHash);
        EXPECT_EQ(r.form, t.form);
        EXPECT_EQ(r.photonsPerDirection, t.photonsPerDirection);
        EXPECT_EQ(r.seed, t.seed);
        EXPECT_EQ(r.relativeError, t.relativeError);
        EXPECT_EQ(r.seconds, t.seconds);
        EXPECT_EQ(r.bytes(), t.bytes());
    }
}

TEST(TableIo, RefusesAnotherKey) {
    const TemporaryFolder folder;
    const std::string path = folder.file("t.vdb");
    writeTable(made(), "key", path);
    const std::string text = messageOf<Error>([&] { readTable(path, "another"); });
    EXPECT_EQ(text.find(path + ": "), 0u) << text;
}

TEST(TableIo, RefusesMissingTruncatedAndForeignFiles) {
    const TemporaryFolder folder;
    const std::string path = folder.file("t.vdb");
    EXPECT_THROW(readTable(path, ""), Error);
    writeTable(made(), "key", path);
    const auto size = std::filesystem::file_size(path);
    for (int eighths = 7; eighths >= 0; --eighths) {
        std::filesystem::resize_file(path, size * std::uintmax_t(eighths) / 8);
        EXPECT_THROW(readTable(path, "key"), Error) << eighths;
    }
    std::ofstream(path, std::ios::trunc) << "no table";
    EXPECT_THROW(readTable(path, "key"), Error);
}

TEST(TableIo, BlendsDirections) {
    StfTable t = made();
    DirectionWeights w;
    w.count = 2;
    w.index[0] = 1, w.weight[0] = 0.25f;
    w.index[1] = 7, w.weight[1] = 0.5f;
    const Rgb m = t.multipleAt(4, w);
    for (int c = 0; c < 3; ++c) {
        const std::size_t at = std::size_t(4 * 12 * 3 + c);
        EXPECT_FLOAT_EQ(m[c], 0.25f * t.multiple[at + 3] + 0.5f * t.multiple[at + 21]);
    }
    w.count = 0;
    EXPECT_EQ(t.transmittedAt(0, w), Rgb(0.0f));
}

} // namespace
