// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/map_cache.h"
#include "stfLib/cache/map_io.h"

#include "tests/unit/support/environment.h"
#include "tests/unit/support/files.h"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

ExemplarMap someMap() {
    ExemplarMap m;
    m.tileMm = {10, 7.5};
    m.description = "synthesised: a test";
    for (int i = 0; i < 12; ++i) {
        m.cornerCoords.push_back({0.1f * float(i), std::sin(float(i))});
        m.gradientX.push_back({1, float(i), 0});
        m.gradientY.push_back({0, 1, 1e-30f * float(i)});
    }
    return m;
}

void expectEqual(const ExemplarMap& a, const ExemplarMap& b) {
    EXPECT_TRUE(a.cornerCoords == b.cornerCoords);
    EXPECT_TRUE(a.gradientX == b.gradientX);
    EXPECT_TRUE(a.gradientY == b.gradientY);
    EXPECT_EQ(a.tileMm.x, b.tileMm.x);
    EXPECT_EQ(a.tileMm.y, b.tileMm.y);
    EXPECT_EQ(a.description, b.description);
}

class MapCache : public testing::Test {
protected:
    struct Result {
        std::shared_ptr<const ExemplarMap> map;
        bool made = false;
        std::vector<std::string> messages;
    };
    Result get(const std::string& key) const {
        Result r;
        Progress progress;
        const auto make = [&] {
            r.made = true;
            return someMap();
        };
        r.map = cachedMaps(folder_.path().string())(
            key, make, progress, [&](Severity, const std::string& text) { r.messages.push_back(text); });
        return r;
    }
    std::filesystem::path entry() const {
        for (const auto& e : std::filesystem::recursive_directory_iterator(folder_.path())) {
            if (e.path().extension() == ".map") {
                return e.path();
            }
        }
        return {};
    }

    const TemporaryFolder folder_;
};

TEST_F(MapCache, SecondCallReadsWhatTheFirstWrote) {
    const Result first = get("a");
    EXPECT_TRUE(first.made);
    const Result second = get("a");
    EXPECT_FALSE(second.made);
    EXPECT_TRUE(second.messages.empty());
    expectEqual(*first.map, *second.map);
    expectEqual(*second.map, someMap());
    EXPECT_TRUE(get("b").made);
    const StoreSummary s = mapStore(folder_.path().string())->summary();
    EXPECT_EQ(s.entries, 2u);
    EXPECT_GT(s.bytes, 2 * 12 * 32u);
    EXPECT_EQ(mapStore(folder_.path().string())->clear().entries, 2u);
    EXPECT_TRUE(get("a").made);
}

TEST_F(MapCache, DamagedEntryIsMadeAgain) {
    get("a");
    const std::filesystem::path file = entry();
    const auto size = std::filesystem::file_size(file);
    std::filesystem::resize_file(file, size - 1);
    Result again = get("a");
    EXPECT_TRUE(again.made);
    ASSERT_EQ(again.messages.size(), 1u);
    EXPECT_NE(again.messages[0].find("a cached map is made again"), std::string::npos) << again.messages[0];
    {
        std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
        bytes.seekp(std::streamoff(size / 2));
        bytes.put('x');
    }
    again = get("a");
    EXPECT_TRUE(again.made);
    EXPECT_EQ(again.messages.size(), 1u);
    EXPECT_FALSE(get("a").made);
}

TEST_F(MapCache, OffByTheEnvironment) {
    const Environment off("HDSTF_CACHE_MAX_MB", "0");
    EXPECT_TRUE(get("a").made);
    EXPECT_TRUE(get("a").made);
    EXPECT_TRUE(entry().empty());
}

TEST_F(MapCache, FilesOfAnotherKindAreRefusedByName) {
    const std::string path = folder_.file("m.map");
    const auto complaint = [&] {
        try {
            readExemplarMap(path);
        } catch (const Error& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    EXPECT_EQ(complaint().rfind(path, 0), 0u) << "missing";
    for (const std::string& text : {std::string(), std::string("short"), std::string(500, 'x')}) {
        std::ofstream(path, std::ios::binary) << text;
        EXPECT_EQ(complaint().rfind(path, 0), 0u) << text.size();
    }
    writeExemplarMap(someMap(), path);
    EXPECT_TRUE(complaint().empty());
    const auto size = std::filesystem::file_size(path);
    // A header that asks for more than there is must not be believed.
    for (const std::streamoff at : {28, 32, 38}) {
        writeExemplarMap(someMap(), path);
        std::fstream bytes(path, std::ios::in | std::ios::out | std::ios::binary);
        bytes.seekp(at);
        bytes.put(char(0x7f));
        bytes.close();
        EXPECT_EQ(complaint().rfind(path, 0), 0u) << at;
    }
    writeExemplarMap(someMap(), path);
    std::filesystem::resize_file(path, size - 32);
    EXPECT_NE(complaint().find("length"), std::string::npos);
    EXPECT_THROW(writeExemplarMap(someMap(), folder_.file("no/such/folder.map")), Error);
}

} // namespace
