// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/table_cache.h"

#include "stfLib/transport/precompute.h"
#include "tests/unit/support/environment.h"
#include "tests/unit/support/files.h"
#include "tests/unit/volume/volumes.h"

#include <algorithm>

using namespace stf;
using namespace stf::test;

namespace {

class TableCache : public testing::Test {
protected:
    struct Result {
        std::shared_ptr<const StfTable> table;
        bool walked = false;
        std::vector<std::string> messages;
    };

    TableCache() {
        options_.polars = 2;
        options_.maxPhotons = 1000;
        options_.quality = 0.5f;
        volume_ = std::make_shared<BaseVolume>(homogeneous({2, 2, 3}, {1, 1, 1}, Rgb(1.0f), Rgb(0.8f)));
    }

    Result get(const std::string& folder) const {
        Result r;
        Progress progress([&](const std::string&, double) { r.walked = true; });
        r.table = cachedTables(folder)(volume_, options_, progress, [&](Severity severity, const std::string& text) {
            r.messages.push_back((severity == Severity::Warning ? "warning: " : "info: ") + text);
        });
        return r;
    }
    Result get() const { return get(folder_.path().string()); }

    std::vector<std::filesystem::path> files() const {
        std::vector<std::filesystem::path> all;
        for (const auto& e : std::filesystem::recursive_directory_iterator(folder_.path())) {
            if (e.is_regular_file()) {
                all.push_back(e.path());
            }
        }
        return all;
    }
    std::vector<std::filesystem::path> entries() const {
        std::vector<std::filesystem::path> tables = files();
        tables.erase(
            std::remove_if(tables.begin(), tables.end(), [](const auto& p) { return p.extension() != ".vdb"; }),
            tables.end());
        return tables;
    }

    const TemporaryFolder folder_;
    TransportOptions options_;
    std::shared_ptr<BaseVolume> volume_;
};

TEST_F(TableCache, SecondCallReadsWhatTheFirstWrote) {
    const Result first = get();
    EXPECT_TRUE(first.walked);
    EXPECT_TRUE(first.messages.empty());
    ASSERT_EQ(entries().size(), 1u);
    const Result second = get();
    EXPECT_FALSE(second.walked);
    EXPECT_TRUE(second.messages.empty());
    EXPECT_TRUE(second.table->multiple->factors == first.table->multiple->factors);
    EXPECT_TRUE(second.table->backlight->factors == first.table->backlight->factors);
    EXPECT_TRUE(second.table->transmitted->factors == first.table->transmitted->factors);
    EXPECT_EQ(second.table->seconds, first.table->seconds);
    EXPECT_EQ(second.table->volumeHash, volume_->contentHash());
}

TEST_F(TableCache, OtherOptionsAndVolumesAreOtherEntries) {
    get();
    options_.seed = 1;
    EXPECT_TRUE(get().walked);
    options_.quality = 0.4f;
    EXPECT_TRUE(get().walked);
    volume_->albedo[3].y = 0.7f;
    EXPECT_TRUE(get().walked);
    EXPECT_EQ(entries().size(), 4u);
    volume_->name = "renamed"; // not a matter of transport
    EXPECT_FALSE(get().walked);
}

TEST_F(TableCache, CorruptEntryIsMadeAgain) {
    const Result first = get();
    const std::filesystem::path file = entries().at(0);
    const auto size = std::filesystem::file_size(file);
    const auto expectRebuilt = [&] {
        const Result again = get();
        EXPECT_TRUE(again.walked);
        ASSERT_EQ(again.messages.size(), 1u);
        EXPECT_NE(again.messages[0].find("made again"), std::string::npos) << again.messages[0];
        EXPECT_TRUE(again.table->multiple->factors == first.table->multiple->factors);
        EXPECT_FALSE(get().walked) << "and kept";
        EXPECT_EQ(entries().size(), 1u);
    };
    std::filesystem::resize_file(file, size / 2);
    expectRebuilt();
    std::ofstream(file, std::ios::trunc) << "not a table";
    expectRebuilt();
    std::filesystem::resize_file(file, 0);
    expectRebuilt();
    {
        std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
        bytes.seekg(std::streamoff(size / 2));
        const char flipped = char(bytes.get() ^ 4);
        bytes.seekp(std::streamoff(size / 2));
        bytes.put(flipped);
    }
    expectRebuilt();
}

TEST_F(TableCache, FolderThatCannotBeWrittenIsReported) {
    std::ofstream(folder_.file("plain")) << "a file";
    const Result r = get(folder_.file("plain")); // no folder can be made there, not even by root
    ASSERT_TRUE(r.table);
    EXPECT_GT(r.table->multiple->node(0, 0, 0), 0);
    ASSERT_EQ(r.messages.size(), 1u);
    EXPECT_EQ(r.messages[0].find("warning: "), 0u);
    EXPECT_NE(r.messages[0].find("not kept"), std::string::npos);
    EXPECT_NE(r.messages[0].find("plain"), std::string::npos) << "names the place";
}

TEST_F(TableCache, EmptyFolderMeansTheEnvironment) {
    const Environment dir("HDSTF_CACHE_DIR", folder_.file("by_environment").c_str());
    EXPECT_TRUE(get("").walked);
    EXPECT_FALSE(get("").walked);
    ASSERT_EQ(entries().size(), 1u);
    EXPECT_NE(entries()[0].string().find("by_environment"), std::string::npos);
}

TEST_F(TableCache, CancelledKeepsNothing) {
    Progress progress;
    progress.cancel();
    EXPECT_THROW(cachedTables(folder_.path().string())(volume_, options_, progress, {}), Cancelled);
    EXPECT_TRUE(files().empty());
}

TEST_F(TableCache, TableOfAnotherFormatIsMadeAgain) {
    // A whole file of this key that is no table: what readTable() throws counts like damage.
    get();
    ContentStore store((folder_.path() / "tables").string(), 1'000'000);
    store.clear();
    StoreRecipe recipe;
    recipe.make = [] {};
    recipe.write = [](const std::string& path) { std::ofstream(path) << "of another time"; };
    Progress progress;
    store.fetch(volume_->contentHash() + ";" + options_.key(), recipe, progress, {});
    const Result r = get();
    EXPECT_TRUE(r.walked);
    ASSERT_EQ(r.messages.size(), 1u);
    EXPECT_NE(r.messages[0].find("made again"), std::string::npos) << r.messages[0];
    EXPECT_FALSE(get().walked);
}

TEST_F(TableCache, TableInUseIsNotEvicted) {
    get();
    const Result used = get();
    const Environment limit("HDSTF_CACHE_MAX_MB", "1");
    EXPECT_EQ(tableStore(folder_.path().string())->clear().entries, 0u);
    EXPECT_EQ(entries().size(), 1u);
}

TEST_F(TableCache, LimitByTheEnvironment) {
    const Environment off("HDSTF_CACHE_MAX_MB", "0");
    EXPECT_TRUE(get().walked);
    EXPECT_TRUE(get().walked);
    EXPECT_TRUE(files().empty());
    const Environment nonsense("HDSTF_CACHE_MAX_MB", "nonsense");
    const Result r = get();
    EXPECT_TRUE(r.walked);
    ASSERT_EQ(r.messages.size(), 1u);
    EXPECT_EQ(r.messages[0].find("warning: HDSTF_CACHE_MAX_MB"), 0u) << r.messages[0];
    EXPECT_EQ(entries().size(), 1u);
}

} // namespace
