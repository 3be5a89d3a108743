// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/cache_settings.h"

#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <limits>

namespace stf {

namespace {

std::string environment(const char* name) {
    const char* const value = std::getenv(name);
    return value ? value : "";
}

} // namespace

std::string cacheFolder() {
    namespace fs = std::filesystem;
    if (const std::string own = environment("HDSTF_CACHE_DIR"); !own.empty()) {
        return own;
    }
    if (const std::string xdg = environment("XDG_CACHE_HOME"); !xdg.empty()) {
        return (fs::path(xdg) / "hdstf").string();
    }
    const std::string home = environment("HOME");
    return (fs::path(home.empty() ? "/tmp" : home) / ".cache" / "hdstf").string();
}

CacheLimit cacheLimit() {
    constexpr std::uint64_t kMegabyte = 1'000'000, kDefault = 4096;
    const std::string text = environment("HDSTF_CACHE_MAX_MB");
    if (text.empty()) {
        return {kDefault * kMegabyte, {}};
    }
    std::uint64_t megabytes = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), megabytes);
    const std::uint64_t most = std::numeric_limits<std::uint64_t>::max() / kMegabyte;
    if (end != text.data() + text.size() || error == std::errc::invalid_argument) {
        return {kDefault * kMegabyte, "HDSTF_CACHE_MAX_MB is '" + text + "', not a whole number of megabytes; " +
                                          std::to_string(kDefault) + " is used"};
    }
    return {(error == std::errc() && megabytes < most ? megabytes : most) * kMegabyte, {}};
}

} // namespace stf
