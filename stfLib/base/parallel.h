// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

namespace stf {

/// Calls body(begin, end) over disjoint ranges that cover [0, count), on all threads; returns when all are done.
/// Ranges hold at most `grain` items and always start at multiples of it, so that a body which accumulates per range
/// does not depend on the number of threads. An exception of a body is rethrown here.
void parallelFor(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body);

/// Number of threads of later parallelFor calls in this process; 0 = all cores.
void setThreadCount(int threads);
int threadCount();

} // namespace stf
