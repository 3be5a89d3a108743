// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace stf {

/// The folder for everything hdStf keeps: `$HDSTF_CACHE_DIR`, `$XDG_CACHE_HOME/hdstf` or `~/.cache/hdstf`.
std::string cacheFolder();

/// The limit of the tables' size.
struct CacheLimit {
    std::uint64_t bytes = 0;
    std::string complaint; ///< not empty where the environment's value was not understood and the default is used
};
/// `$HDSTF_CACHE_MAX_MB`, a whole number of megabytes (10^6 bytes), default 4096; 0 turns the cache off.
CacheLimit cacheLimit();

} // namespace stf
