// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/base/tbb_guard.h"
#include "stfLib/base/thread_sanitizer.h"

#include <algorithm>
#include <atomic>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace stf {

namespace {
std::atomic<int> requestedThreads{0};
// Given and taken by all loops: what a loop captures is read only after it was taken. Loops that run at the same time
// are then ordered where they are not, so a sanitizer finds less between two of them, and the same within one.
char begun, done;
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
    sanitizerGive(&begun);
    const auto loop = [&] {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, chunks, 1),
            [&](const tbb::blocked_range<std::size_t>& r) {
                sanitizerTake(&begun);
                for (std::size_t c = r.begin(); c != r.end(); ++c) {
                    body(c * grain, std::min(count, (c + 1) * grain));
                }
                sanitizerGive(&done);
            },
            tbb::simple_partitioner());
    };
    const int threads = requestedThreads;
    if (threads > 0) {
        tbb::task_arena(threads).execute(loop);
    } else {
        loop();
    }
    sanitizerTake(&done);
}

} // namespace stf
