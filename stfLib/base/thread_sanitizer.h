// SPDX-License-Identifier: Apache-2.0
#pragma once

// ThreadSanitizer follows what it has compiled: TBB, which it has not, hands work from thread to thread unseen. These
// tell it of such a handover; without it they are nothing.
#if defined(__SANITIZE_THREAD__)
#define STF_THREAD_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define STF_THREAD_SANITIZER 1
#endif
#endif

#ifdef STF_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace stf {

/// All that this thread has done so far is seen by whoever then takes the same address.
inline void sanitizerGive([[maybe_unused]] void* address) {
#ifdef STF_THREAD_SANITIZER
    __tsan_release(address);
#endif
}

/// Sees all that was done before the address was given.
inline void sanitizerTake([[maybe_unused]] void* address) {
#ifdef STF_THREAD_SANITIZER
    __tsan_acquire(address);
#endif
}

} // namespace stf
