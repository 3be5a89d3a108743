// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/cache/store_fixture.h"
#include "tests/unit/support/file_size_limit.h"

using namespace stf;
using namespace stf::test;

namespace {

using std::chrono::hours;

class ContentStoreTest : public StoreTest {
protected:
    ContentStore store_{folder(), kNoLimit};

    // After `damage`, the next fetch says so once, makes the content again, and keeps it.
    void expectMadeAgain(const std::function<void()>& damage, const std::string& reason) {
        ASSERT_EQ(get(store_, "key").text, textOf("key"));
        damage();
        std::string fault;
        EXPECT_FALSE(store_.find("key", &fault));
        EXPECT_NE(fault.find(reason), std::string::npos) << fault;
        const Result r = get(store_, "key");
        EXPECT_TRUE(r.made) << reason;
        EXPECT_EQ(r.text, textOf("key"));
        ASSERT_EQ(r.messages.size(), 1u) << reason;
        EXPECT_EQ(r.messages[0].find("info: "), 0u);
        EXPECT_NE(r.messages[0].find("made again"), std::string::npos) << r.messages[0];
        EXPECT_NE(r.messages[0].find(store_.pathOf("key")), std::string::npos) << r.messages[0];
        const Result again = get(store_, "key");
        EXPECT_FALSE(again.made) << reason;
        EXPECT_TRUE(again.messages.empty());
        EXPECT_EQ(names().size(), 2u) << "entry and seal";
    }
};

TEST_F(ContentStoreTest, SecondFetchReadsWhatTheFirstMade) {
    EXPECT_FALSE(store_.find("key"));
    const Result first = get(store_, "key"), second = get(store_, "key"), other = get(store_, "other");
    EXPECT_TRUE(first.made);
    EXPECT_FALSE(second.made);
    EXPECT_EQ(second.text, first.text);
    EXPECT_TRUE(other.made);
    for (const Result& r : {first, second, other}) {
        EXPECT_TRUE(r.messages.empty());
    }
    ASSERT_TRUE(store_.find("key"));
    EXPECT_EQ(store_.find("key")->path(), store_.pathOf("key"));
    EXPECT_EQ(names().size(), 4u) << "no lock and no temporary file stays";
    EXPECT_FALSE(get(*std::make_unique<ContentStore>(folder(), kNoLimit), "key").made) << "another store there";
}

TEST_F(ContentStoreTest, WhatMakeThrowsLeavesNothing) {
    StoreRecipe recipe;
    recipe.make = [] { throw Error("no such thing"); };
    Progress progress;
    EXPECT_EQ(messageOf<Error>([&] { store_.fetch("key", recipe, progress, {}); }), "no such thing");
    EXPECT_TRUE(names().empty());
    EXPECT_TRUE(get(store_, "key").made);
}

TEST_F(ContentStoreTest, FlippedBitIsFound) {
    for (std::size_t place : {0u, 137u, 299u}) {
        expectMadeAgain(
            [&] {
                std::string bytes = contentOf(store_.pathOf("key"));
                ASSERT_EQ(bytes.size(), 300u);
                bytes[place] = char(bytes[place] ^ 1);
                std::ofstream(store_.pathOf("key")) << bytes;
            },
            "has changed");
    }
}

TEST_F(ContentStoreTest, OtherLengthIsFound) {
    for (int size : {0, 1, 299, 301}) {
        expectMadeAgain([&] { fs::resize_file(store_.pathOf("key"), std::uintmax_t(size)); },
                        "it has " + std::to_string(size) + " bytes");
    }
}

TEST_F(ContentStoreTest, MissingOrDamagedSealIsFound) {
    const std::string seal = beside(store_, "key", ".seal");
    expectMadeAgain([&] { fs::remove(seal); }, "checksum is missing");
    expectMadeAgain([&] { fs::resize_file(seal, 0); }, "checksum is missing");
    expectMadeAgain([&] { fs::resize_file(seal, 20); }, "checksum is missing");
    expectMadeAgain([&] { std::ofstream(seal) << "something else\n1 2\nkey"; }, "checksum is missing");
}

TEST_F(ContentStoreTest, EntryOfAnotherKeyIsFound) {
    get(store_, "other");
    expectMadeAgain(
        [&] {
            for (const char* extension : {".vdb", ".seal"}) {
                fs::copy_file(beside(store_, "other", extension), beside(store_, "key", extension),
                              fs::copy_options::overwrite_existing);
            }
            fs::remove(store_.pathOf("other"));
            fs::remove(beside(store_, "other", ".seal"));
        },
        "something else");
}

TEST_F(ContentStoreTest, ContentThatIsNotUnderstoodIsMadeAgain) {
    get(store_, "key");
    int reads = 0;
    bool made = false;
    StoreRecipe recipe;
    recipe.read = [&](const std::shared_ptr<const StoreEntry>& entry) {
        ++reads;
        throw Error(entry->path() + ": of another version");
    };
    recipe.make = [&] { made = true; };
    recipe.write = [](const std::string& path) { std::ofstream(path) << "new"; };
    Progress progress;
    std::vector<std::string> messages;
    store_.fetch("key", recipe, progress, [&](Severity, const std::string& text) { messages.push_back(text); });
    EXPECT_TRUE(made);
    EXPECT_EQ(reads, 2) << "and once more under the lock";
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_NE(messages[0].find("of another version"), std::string::npos);
    EXPECT_EQ(contentOf(store_.pathOf("key")), "new");
}

TEST_F(ContentStoreTest, LeastRecentlyUsedGoFirst) {
    for (const char* key : {"a", "b", "c"}) {
        get(store_, key, 1000);
    }
    const std::uint64_t one = store_.summary().bytes / 3;
    setAge(store_.pathOf("a"), hours(3));
    setAge(store_.pathOf("b"), hours(2));
    setAge(store_.pathOf("c"), hours(1));
    ContentStore limited(folder(), 3 * one);
    EXPECT_FALSE(get(limited, "a").made) << "a use, which makes b the oldest";
    EXPECT_TRUE(get(limited, "d", 1000).made);
    EXPECT_TRUE(has(limited, "a") && !has(limited, "b") && has(limited, "c") && has(limited, "d"));
    EXPECT_FALSE(fs::exists(beside(limited, "b", ".seal")));
    EXPECT_EQ(limited.summary().entries, 3u);
    EXPECT_EQ(limited.summary().bytes, 3 * one);
    // One that takes the place of two.
    EXPECT_TRUE(get(limited, "e", 2000).made);
    EXPECT_TRUE(!has(limited, "a") && !has(limited, "c") && has(limited, "d") && has(limited, "e"));
    EXPECT_LE(limited.summary().bytes, limited.summary().limit);
}

TEST_F(ContentStoreTest, NothingGoesBelowTheLimit) {
    get(store_, "a", 1000);
    const std::uint64_t one = store_.summary().bytes;
    ContentStore limited(folder(), 2 * one);
    get(limited, "b", 1000);
    EXPECT_TRUE(has(limited, "a") && has(limited, "b"));
}

TEST_F(ContentStoreTest, NewestStaysWhateverItsSize) {
    ContentStore small(folder(), 10);
    for (const char* key : {"a", "b", "c"}) {
        EXPECT_TRUE(get(small, key).made);
        EXPECT_FALSE(get(small, key).made);
    }
    EXPECT_EQ(small.summary().entries, 1u);
    // Also where the clock of another machine has put the others into the future.
    setAge(small.pathOf("c"), hours(-5));
    get(small, "d");
    EXPECT_TRUE(has(small, "d") && !has(small, "c"));
}

TEST_F(ContentStoreTest, EntriesInUseStay) {
    ContentStore small(folder(), 10);
    get(small, "a");
    auto held = small.find("a");
    ASSERT_TRUE(held);
    get(small, "b");
    get(small, "c");
    EXPECT_TRUE(has(small, "a") && !has(small, "b") && has(small, "c"));
    EXPECT_EQ(small.clear().entries, 1u);
    EXPECT_EQ(contentOf(held->path()), textOf("a"));
    held.reset();
    get(small, "d");
    EXPECT_FALSE(has(small, "a"));
}

TEST_F(ContentStoreTest, EntriesBeingMadeStay) {
    ContentStore small(folder(), 10);
    get(small, "a");
    {
        const FileLock lock = FileLock::tryTake(beside(small, "a", ".lock"));
        ASSERT_EQ(lock.state(), LockState::Held);
        get(small, "b");
        EXPECT_TRUE(has(small, "a"));
        EXPECT_TRUE(fs::exists(beside(small, "a", ".lock")));
    }
    get(small, "c");
    EXPECT_FALSE(has(small, "a"));
}

TEST_F(ContentStoreTest, OpenFileMayBeReadAfterItsEviction) {
    ContentStore small(folder(), 10);
    get(small, "a");
    std::ifstream in(small.pathOf("a"));
    get(small, "b");
    EXPECT_FALSE(has(small, "a"));
    std::string text;
    in >> text;
    EXPECT_EQ(text, textOf("a"));
}

TEST_F(ContentStoreTest, LeftoversAreRemoved) {
    const std::string other = textOf("0", 32);
    const std::string oldFile = folder_.file(other + ".vdb.1-1.tmp"),
                      oldNested = folder_.file(other + ".vdb.1-2.tmp.1.tmp"),
                      youngFile = folder_.file(other + ".vdb.1-3.tmp"), orphan = folder_.file(other + ".seal"),
                      lock = folder_.file(other + ".lock"), foreign = folder_.file("notes.tmp");
    for (const std::string& path : {oldFile, oldNested, youngFile, orphan, lock, foreign}) {
        std::ofstream{path} << "x";
        setAge(path, hours(path == youngFile ? 23 : 25));
    }
    get(store_, "key");
    EXPECT_FALSE(fs::exists(oldFile) || fs::exists(oldNested) || fs::exists(orphan) || fs::exists(lock));
    EXPECT_TRUE(fs::exists(youngFile)) << "somebody may be writing it";
    EXPECT_TRUE(fs::exists(foreign)) << "not a file of the store";
    EXPECT_EQ(names().size(), 4u);
    store_.clear();
    EXPECT_FALSE(fs::exists(youngFile)) << "nobody holds its lock";
    EXPECT_TRUE(fs::exists(foreign));
}

TEST_F(ContentStoreTest, SummaryAndClear) {
    EXPECT_EQ(store_.summary().entries, 0u);
    EXPECT_EQ(store_.summary().bytes, 0u);
    EXPECT_EQ(store_.summary().limit, kNoLimit);
    get(store_, "a");
    get(store_, "bb");
    const StoreSummary s = store_.summary();
    EXPECT_EQ(s.entries, 2u);
    std::uint64_t bytes = 0;
    for (const std::string& name : names()) {
        bytes += fs::file_size(folder_.path() / name);
    }
    EXPECT_EQ(s.bytes, bytes);
    const StoreSummary removed = store_.clear();
    EXPECT_EQ(removed.entries, 2u);
    EXPECT_EQ(removed.bytes, bytes);
    EXPECT_TRUE(names().empty());
    EXPECT_EQ(store_.clear().entries, 0u);
    EXPECT_EQ(ContentStore(folder_.file("nowhere"), 1).clear().entries, 0u);
}

TEST_F(ContentStoreTest, LimitOfZeroIsOff) {
    get(store_, "key");
    ContentStore off(folder(), 0);
    EXPECT_TRUE(get(off, "key").made);
    EXPECT_TRUE(get(off, "other").made);
    EXPECT_FALSE(off.find("key"));
    EXPECT_EQ(off.summary().entries, 1u) << "what is there stays";
    EXPECT_FALSE(has(off, "other"));
    EXPECT_EQ(off.clear().entries, 1u);
}

TEST_F(ContentStoreTest, FolderThatCannotBeMadeIsReportedOnce) {
    std::ofstream(folder_.file("plain")) << "a file"; // no folder can be made there, not even by root
    ContentStore nowhere(folder_.file("plain/store"), kNoLimit);
    const Result first = get(nowhere, "a"), second = get(nowhere, "a"), third = get(nowhere, "b");
    ASSERT_EQ(first.messages.size(), 1u);
    EXPECT_EQ(first.messages[0].find("warning: "), 0u);
    EXPECT_NE(first.messages[0].find("not kept"), std::string::npos);
    EXPECT_NE(first.messages[0].find(folder_.file("plain")), std::string::npos) << first.messages[0];
    EXPECT_TRUE(second.made && second.messages.empty() && third.made && third.messages.empty());
    EXPECT_EQ(second.text, textOf("a"));
}

TEST_F(ContentStoreTest, FullDiskKeepsNothing) {
    get(store_, "small");
    Result r;
    StoreRecipe recipe;
    recipe.make = [&] { r.made = true; };
    recipe.write = [&](const std::string& path) {
        std::ofstream out;
        out.exceptions(std::ios::badbit | std::ios::failbit);
        out.open(path);
        out << textOf("large", 10000);
        out.close();
    };
    Progress progress;
    {
        const FileSizeLimit full(4096);
        store_.fetch("large", recipe, progress, [&](Severity, const std::string& m) { r.messages.push_back(m); });
    }
    EXPECT_TRUE(r.made);
    ASSERT_EQ(r.messages.size(), 1u);
    EXPECT_NE(r.messages[0].find("not kept"), std::string::npos);
    EXPECT_EQ(names().size(), 2u) << "the other entry stays, nothing half is left";
    EXPECT_FALSE(get(store_, "small").made);
}

TEST_F(ContentStoreTest, ForeignFilesAreLeftAlone) {
    std::ofstream(folder_.file("README.vdb")) << textOf("x", 1000);
    ContentStore small(folder(), 10);
    get(small, "a");
    get(small, "b");
    EXPECT_EQ(small.summary().entries, 1u);
    small.clear();
    EXPECT_EQ(names().size(), 1u);
}

} // namespace
