// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to stfLib's sources: names TBB.
#include "stfLib/base/tbb_guard.h"
#include "stfLib/base/thread_sanitizer.h"

#include <algorithm>
#include <tbb/parallel_sort.h>

namespace stf {

/// Sorts on all threads; what compares equal comes in any order. Under ThreadSanitizer, which does not see how TBB's
/// sort hands parts on, on one.
template<class Iterator>
void parallelSort(Iterator begin, Iterator end) {
#ifdef STF_THREAD_SANITIZER
    std::sort(begin, end);
#else
    tbb::parallel_sort(begin, end);
#endif
}

} // namespace stf
