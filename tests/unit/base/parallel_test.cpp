// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"

#include "stfLib/base/error.h"

#include <atomic>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

using namespace stf;

namespace {

class ParallelFor : public testing::Test {
protected:
    void TearDown() override { setThreadCount(0); }
};

TEST_F(ParallelFor, CoversEveryItemOnce) {
    for (int threads : {0, 1, 2}) {
        setThreadCount(threads);
        for (std::size_t count : {0, 1, 7, 64, 1000}) {
            for (std::size_t grain : {0, 1, 16, 5000}) {
                std::vector<std::atomic<int>> seen(count);
                parallelFor(count, grain, [&](std::size_t begin, std::size_t end) {
                    for (std::size_t i = begin; i < end; ++i) {
                        ++seen[i];
                    }
                });
                for (const auto& n : seen) {
                    ASSERT_EQ(n, 1) << count << " by " << grain << " on " << threads;
                }
            }
        }
    }
}

TEST_F(ParallelFor, RangesStartAtMultiplesOfTheGrain) {
    setThreadCount(2);
    parallelFor(1000, 16, [](std::size_t begin, std::size_t end) {
        EXPECT_EQ(begin % 16, 0u);
        EXPECT_EQ(end, std::min<std::size_t>(1000, begin + 16));
    });
}

TEST_F(ParallelFor, SumsPerRangeDoNotDependOnThreads) {
    std::vector<std::vector<float>> sums;
    for (int threads : {1, 2}) {
        setThreadCount(threads);
        std::vector<float> partial(100);
        parallelFor(9999, 100, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                partial[begin / 100] += 1.0f / float(i + 1);
            }
        });
        sums.push_back(partial);
    }
    EXPECT_EQ(sums[0], sums[1]);
}

TEST_F(ParallelFor, ExceptionsComeBack) {
    for (int threads : {1, 2}) {
        setThreadCount(threads);
        const auto failing = [](std::size_t begin, std::size_t) {
            if (begin == 40) {
                throw Error("forty");
            }
        };
        EXPECT_THROW(parallelFor(100, 1, failing), Error);
        EXPECT_THROW(parallelFor(100, 1, [](std::size_t, std::size_t) { throw Cancelled(); }), Cancelled);
    }
}

TEST_F(ParallelFor, HoldsToItsNumberOfThreads) {
    setThreadCount(2);
    EXPECT_EQ(threadCount(), 2);
    std::atomic<int> running{0}, most{0};
    parallelFor(64, 1, [&](std::size_t, std::size_t) {
        const int now = ++running;
        int seen = most;
        while (now > seen && !most.compare_exchange_weak(seen, now)) {
        }
        std::this_thread::yield();
        --running;
    });
    EXPECT_LE(most, 2);
    setThreadCount(-3);
    EXPECT_GE(threadCount(), 1);
}

TEST_F(ParallelFor, Nests) {
    std::atomic<int> total{0};
    parallelFor(8, 1, [&](std::size_t, std::size_t) {
        parallelFor(8, 2, [&](std::size_t begin, std::size_t end) { total += int(end - begin); });
    });
    EXPECT_EQ(total, 64);
}

} // namespace
