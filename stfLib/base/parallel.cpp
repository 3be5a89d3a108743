// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/base/tbb_guard.h"
#include "stfLib/base/thread_sanitizer.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <thread>
#include <vector>

namespace stf {

namespace {
std::atomic<int> requestedThreads{0};

using Chunk = std::function<void(std::size_t)>;

#ifdef STF_THREAD_SANITIZER
// ThreadSanitizer does not see how TBB, which it has not compiled, hands work from thread to thread; it sees all of
// this.
void forEachChunk(std::size_t chunks, int threadCount, const Chunk& body) {
    std::atomic<std::size_t> next{0};
    std::exception_ptr failure;
    std::mutex failing;
    const auto work = [&] {
        try {
            for (std::size_t c = next++; c < chunks; c = next++) {
                body(c);
            }
        } catch (...) {
            next = chunks;
            const std::lock_guard<std::mutex> lock(failing);
            failure = failure ? failure : std::current_exception();
        }
    };
    std::vector<std::thread> others;
    for (std::size_t t = 1; t < std::min(chunks, std::size_t(threadCount)); ++t) {
        others.emplace_back(work);
    }
    work();
    for (std::thread& thread : others) {
        thread.join();
    }
    if (failure) {
        std::rethrow_exception(failure);
    }
}
#else
void forEachChunk(std::size_t chunks, int threadCount, const Chunk& body) {
    const auto loop = [&] {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, chunks, 1),
            [&](const tbb::blocked_range<std::size_t>& r) {
                for (std::size_t c = r.begin(); c != r.end(); ++c) {
                    body(c);
                }
            },
            tbb::simple_partitioner());
    };
    if (requestedThreads > 0) {
        tbb::task_arena(threadCount).execute(loop);
    } else {
        loop();
    }
}
#endif
} // namespace

void setThreadCount(int threads) {
    requestedThreads = std::max(0, threads);
}

int threadCount() {
    const int n = requestedThreads;
    return n > 0 ? n : tbb::this_task_arena::max_concurrency();
}

void parallelFor(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
    if (count == 0) {
        return;
    }
    grain = std::max<std::size_t>(1, grain);
    const std::size_t chunks = (count + grain - 1) / grain;
    forEachChunk(chunks, threadCount(), [&](std::size_t c) { body(c * grain, std::min(count, (c + 1) * grain)); });
}

} // namespace stf
