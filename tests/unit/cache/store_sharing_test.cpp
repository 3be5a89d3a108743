// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/cache/store_fixture.h"

#include <array>
#include <csignal>
#include <future>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

using namespace stf;
using namespace stf::test;

namespace {

// A pipe as a gate between processes: `pass` returns when everybody who holds the other end has let go of it.
class Gate {
public:
    Gate() {
        if (::pipe(ends_.data()) != 0) {
            throw std::runtime_error("no pipe");
        }
    }
    ~Gate() {
        open();
        ::close(ends_[0]);
    }
    void open() {
        if (ends_[1] >= 0) {
            ::close(ends_[1]);
            ends_[1] = -1;
        }
    }
    void pass() {
        open();
        char nothing;
        while (::read(ends_[0], &nothing, 1) > 0) {
        }
    }

private:
    std::array<int, 2> ends_{-1, -1};
};

// The child runs `body` and nothing else: no test framework, no threads.
template<class Body>
pid_t inChild(Body body) {
    const pid_t child = ::fork();
    if (child == 0) {
        int code = 1;
        try {
            code = body() ? 0 : 1;
        } catch (...) {
            code = 2;
        }
        ::_exit(code);
    }
    return child;
}

int statusOf(pid_t child) {
    int status = -1;
    ::waitpid(child, &status, 0);
    return status;
}

class StoreSharing : public StoreTest {
protected:
    // Fetches many entries of a store that holds one. Whoever evicts what meanwhile, each is right and none looks
    // damaged.
    bool fetchesAreRight(int stride) const {
        ContentStore small(folder(), 10);
        bool right = true;
        for (int k = 0; k < 100; ++k) {
            const std::string key = "key" + std::to_string(k * (stride + 1) % 5);
            const Result r = get(small, key);
            right = right && r.text == textOf(key);
            for (const std::string& m : r.messages) {
                right = right && m.find("waiting") != std::string::npos;
            }
        }
        return right;
    }
    // Lines that processes have written to a common file.
    int linesOf(const std::string& path) const {
        const std::string text = contentOf(path);
        return int(std::count(text.begin(), text.end(), '\n'));
    }
};

TEST_F(StoreSharing, ThreadsMakeAnEntryOnce) {
    std::atomic<int> made{0}, wrong{0};
    std::vector<std::thread> threads;
    ContentStore shared(folder(), kNoLimit);
    for (int i = 0; i < 8; ++i) {
        threads.emplace_back([&, i] {
            // Half of them by a store of their own.
            ContentStore own(folder(), kNoLimit);
            const Result r = get(i % 2 ? shared : own, "key");
            made += r.made;
            wrong += r.text != textOf("key");
        });
    }
    for (std::thread& t : threads) {
        t.join();
    }
    EXPECT_EQ(made, 1);
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(names().size(), 2u);
}

TEST_F(StoreSharing, ThreadsBearEviction) {
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
        threads.emplace_back([&, i] { wrong += !fetchesAreRight(i); });
    }
    for (std::thread& t : threads) {
        t.join();
    }
    EXPECT_EQ(wrong, 0);
}

TEST_F(StoreSharing, ProcessesBearEviction) {
    std::vector<pid_t> children;
    for (int i = 0; i < 4; ++i) {
        children.push_back(inChild([&, i] { return fetchesAreRight(i); }));
    }
    for (pid_t child : children) {
        EXPECT_EQ(statusOf(child), 0);
    }
}

TEST_F(StoreSharing, ProcessesMakeAnEntryOnce) {
    const std::string log = folder_.file("log");
    Gate start;
    std::vector<pid_t> children;
    for (int i = 0; i < 4; ++i) {
        children.push_back(inChild([&] {
            start.pass();
            ContentStore store(folder(), kNoLimit);
            const Result r = get(store, "key", 100000);
            if (r.made) {
                std::ofstream(log, std::ios::app) << "made" << std::endl;
            }
            return r.text == textOf("key", 100000);
        }));
    }
    start.open();
    for (pid_t child : children) {
        EXPECT_EQ(statusOf(child), 0);
    }
    EXPECT_EQ(linesOf(log), 1);
    EXPECT_EQ(names().size(), 3u) << "entry, seal, log";
}

TEST_F(StoreSharing, ProcessesMakeDifferentEntries) {
    Gate start;
    std::vector<pid_t> children;
    for (int i = 0; i < 4; ++i) {
        children.push_back(inChild([&, i] {
            start.pass();
            ContentStore store(folder(), kNoLimit);
            bool right = true;
            for (int k = 0; k < 10; ++k) {
                const std::string key = std::to_string(10 * i + k);
                right = right && get(store, key).text == textOf(key);
            }
            return right;
        }));
    }
    start.open();
    for (pid_t child : children) {
        EXPECT_EQ(statusOf(child), 0);
    }
    ContentStore store(folder(), kNoLimit);
    EXPECT_EQ(store.summary().entries, 40u);
    for (int k = 0; k < 40; ++k) {
        EXPECT_FALSE(get(store, std::to_string(k)).made) << k;
    }
}

TEST_F(StoreSharing, ProcessKilledWhileItWritesLeavesNoEntry) {
    const pid_t child = inChild([&] {
        ContentStore store(folder(), kNoLimit);
        StoreRecipe recipe;
        recipe.make = [] {};
        recipe.write = [&](const std::string& path) {
            std::ofstream(path) << "half of" << std::flush;
            ::kill(::getpid(), SIGKILL);
        };
        Progress progress;
        store.fetch("key", recipe, progress, {});
        return true;
    });
    const int status = statusOf(child);
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    ContentStore store(folder(), kNoLimit);
    EXPECT_TRUE(fs::exists(beside(store, "key", ".lock")));
    EXPECT_EQ(store.summary().entries, 0u);
    const Result r = get(store, "key");
    EXPECT_TRUE(r.made) << "the lock died with its holder";
    EXPECT_TRUE(r.messages.empty());
    EXPECT_EQ(r.text, textOf("key"));
    EXPECT_FALSE(fs::exists(beside(store, "key", ".lock")));
    store.clear();
    EXPECT_TRUE(names().empty()) << "half a file";
}

TEST_F(StoreSharing, ProcessKilledBetweenItsRenamesLeavesNoEntry) {
    // The seal is there already, the entry not yet.
    ContentStore store(folder(), kNoLimit);
    get(store, "key");
    fs::remove(store.pathOf("key"));
    const Result r = get(store, "key");
    EXPECT_TRUE(r.made);
    EXPECT_TRUE(r.messages.empty());
    EXPECT_FALSE(get(store, "key").made);
}

TEST_F(StoreSharing, FolderThatCannotBeWrittenServesWhatItHas) {
    ContentStore store(folder(), kNoLimit);
    get(store, "a");
    for (const char* extension : {".vdb", ".seal"}) {
        fs::permissions(beside(store, "a", extension), fs::perms(0444));
    }
    fs::permissions(folder(), fs::perms(0555));
    const pid_t child = inChild([&] {
        constexpr uid_t kNobody = 65534;
        if (::geteuid() == 0 && ::setuid(kNobody) != 0) { // nothing is forbidden to root
            return false;
        }
        ContentStore mine(folder(), kNoLimit);
        const Result a = get(mine, "a"), b = get(mine, "b"), c = get(mine, "c");
        return !a.made && a.text == textOf("a") && a.messages.empty() && b.made && c.made && b.messages.size() == 1 &&
               b.messages[0].find("warning: ") == 0 && c.messages.empty();
    });
    EXPECT_EQ(statusOf(child), 0);
    fs::permissions(folder(), fs::perms(0700));
    EXPECT_EQ(names().size(), 2u);
}

TEST_F(StoreSharing, EntryInUseByAnotherProcessStays) {
    ContentStore small(folder(), 10);
    get(small, "a");
    Gate holds, done;
    const pid_t child = inChild([&] {
        const auto held = ContentStore(folder(), 10).find("a");
        holds.open();
        done.pass();
        return held != nullptr;
    });
    holds.pass();
    get(small, "b");
    EXPECT_TRUE(has(small, "a"));
    EXPECT_EQ(small.clear().entries, 1u);
    EXPECT_TRUE(has(small, "a"));
    done.open();
    EXPECT_EQ(statusOf(child), 0);
    get(small, "c");
    EXPECT_FALSE(has(small, "a"));
}

TEST_F(StoreSharing, WaiterGetsWhatTheMakerMade) {
    // The maker is not done before the waiter has said that it waits.
    ContentStore store(folder(), kNoLimit);
    std::promise<void> making, waiting;
    std::thread maker([&] {
        StoreRecipe recipe;
        recipe.make = [&] {
            making.set_value();
            waiting.get_future().wait();
        };
        recipe.write = [](const std::string& path) { std::ofstream(path) << "by the maker"; };
        Progress progress;
        store.fetch("key", recipe, progress, {});
    });
    making.get_future().wait();
    std::string text;
    bool made = false;
    std::vector<std::string> messages, stages;
    StoreRecipe recipe;
    recipe.read = [&](const std::shared_ptr<const StoreEntry>& entry) { text = contentOf(entry->path()); };
    recipe.make = [&] { made = true; };
    recipe.write = [](const std::string&) {};
    Progress progress([&](const std::string& stage, double) { stages.push_back(stage); });
    store.fetch("key", recipe, progress, [&](Severity severity, const std::string& message) {
        EXPECT_EQ(severity, Severity::Info);
        messages.push_back(message);
        waiting.set_value();
    });
    maker.join();
    EXPECT_FALSE(made);
    EXPECT_EQ(text, "by the maker");
    ASSERT_EQ(messages.size(), 1u) << "once, however long it takes";
    EXPECT_NE(messages[0].find("waiting"), std::string::npos);
    EXPECT_NE(messages[0].find(store.pathOf("key")), std::string::npos);
    ASSERT_FALSE(stages.empty());
    EXPECT_EQ(stages[0], "waiting");
}

TEST_F(StoreSharing, WaiterMakesItWhereTheMakerFailed) {
    ContentStore store(folder(), kNoLimit);
    std::promise<void> making, waiting;
    std::thread maker([&] {
        StoreRecipe recipe;
        recipe.make = [&] {
            making.set_value();
            waiting.get_future().wait();
            throw Cancelled();
        };
        Progress progress;
        EXPECT_THROW(store.fetch("key", recipe, progress, {}), Cancelled);
    });
    making.get_future().wait();
    bool made = false;
    StoreRecipe recipe;
    recipe.make = [&] { made = true; };
    recipe.write = [](const std::string& path) { std::ofstream(path) << "by the waiter"; };
    Progress progress;
    store.fetch("key", recipe, progress, [&](Severity, const std::string&) { waiting.set_value(); });
    maker.join();
    EXPECT_TRUE(made);
    EXPECT_EQ(contentOf(store.pathOf("key")), "by the waiter");
}

TEST_F(StoreSharing, WaitingCanBeCancelled) {
    ContentStore store(folder(), kNoLimit);
    const FileLock lock = FileLock::tryTake(beside(store, "key", ".lock"));
    Progress progress;
    bool made = false;
    StoreRecipe recipe;
    recipe.make = [&] { made = true; };
    EXPECT_THROW(store.fetch("key", recipe, progress,
                             [&](Severity, const std::string& text) {
                                 EXPECT_NE(text.find("waiting"), std::string::npos);
                                 progress.cancel();
                             }),
                 Cancelled);
    EXPECT_FALSE(made);
    EXPECT_TRUE(fs::exists(beside(store, "key", ".lock"))) << "it is the other's";
}

TEST_F(StoreSharing, LockExcludesAndIsReleased) {
    const std::string path = folder_.file("lock");
    {
        const FileLock first = FileLock::tryTake(path);
        EXPECT_EQ(first.state(), LockState::Held);
        EXPECT_EQ(FileLock::tryTake(path).state(), LockState::Busy);
        EXPECT_EQ(statusOf(inChild([&] { return FileLock::tryTake(path).state() == LockState::Busy; })), 0);
        EXPECT_TRUE(fs::exists(path)) << "asking in vain does not remove it";
    }
    EXPECT_FALSE(fs::exists(path));
    EXPECT_EQ(FileLock::tryTake(path).state(), LockState::Held);
    EXPECT_EQ(FileLock::tryTake(folder_.file("no/such/folder")).state(), LockState::Unavailable);
}

TEST_F(StoreSharing, ForkedChildDoesNotKeepTheLock) {
    const std::string path = folder_.file("lock");
    Gate done;
    pid_t child = -1;
    {
        const FileLock lock = FileLock::tryTake(path);
        child = inChild([&] { return done.pass(), true; }); // has the same file open
    }
    EXPECT_EQ(FileLock::tryTake(path).state(), LockState::Held);
    done.open();
    EXPECT_EQ(statusOf(child), 0);
}

TEST_F(StoreSharing, LockIsOneAtATimeUnderContention) {
    // Each takes the lock, and so removes its file, again and again: never two at once.
    const std::string path = folder_.file("lock");
    std::atomic<int> inside{0}, overlaps{0}, taken{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
        threads.emplace_back([&] {
            for (int k = 0; k < 2000; ++k) {
                const FileLock lock = FileLock::tryTake(path);
                if (lock.state() == LockState::Held) {
                    ++taken;
                    overlaps += ++inside > 1;
                    --inside;
                }
            }
        });
    }
    for (std::thread& t : threads) {
        t.join();
    }
    EXPECT_EQ(overlaps, 0);
    EXPECT_GT(taken, 0);
    EXPECT_FALSE(fs::exists(path));
}

} // namespace
