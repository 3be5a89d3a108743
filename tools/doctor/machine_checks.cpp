// SPDX-License-Identifier: Apache-2.0
#include "tools/doctor/machine_checks.h"

#include "stfLib/cache/cache_settings.h"
#include "stfLib/cache/map_cache.h"
#include "stfLib/cache/table_cache.h"
#include "stfLib/render/denoiser.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <thread>
#include <unistd.h>
#if defined(__linux__)
#include <sched.h>
#endif

namespace stf::doctor {

namespace {

namespace fs = std::filesystem;

constexpr double kLittleMemory = 1e9, kLittleDisk = 5e8; // bytes

bool isSet(const char* name) {
    const char* const value = std::getenv(name);
    return value && *value;
}

std::string amount(double bytes) {
    char text[32];
    std::snprintf(text, sizeof text, bytes < 1e9 ? "%.1f MB" : "%.1f GB", bytes / (bytes < 1e9 ? 1e6 : 1e9));
    return text;
}

/// The folder itself or, where it is not there yet, the nearest one above it that is.
fs::path nearestThere(fs::path folder) {
    std::error_code error;
    while (!fs::exists(folder, error) && folder.has_parent_path() && folder != folder.parent_path()) {
        folder = folder.parent_path();
    }
    return folder;
}

/// Why no file can be made in that folder; empty where one can. A file is made to see, and removed.
std::string whyNotWritable(const fs::path& folder) {
    std::string name = (folder / "stf_doctor_XXXXXX").string();
    const int file = ::mkstemp(name.data());
    if (file < 0) {
        return std::strerror(errno);
    }
    const bool isWritten = ::write(file, "hdStf", 5) == 5;
    const std::string why = isWritten ? "" : std::strerror(errno);
    ::close(file);
    ::unlink(name.c_str());
    return why;
}

/// Bytes that the system would give, within the limit of a container; nothing where it does not say.
std::optional<double> freeMemory() {
    std::optional<double> bytes;
    std::ifstream file("/proc/meminfo");
    for (std::string word; file >> word;) {
        if (word == "MemAvailable:") {
            double kibibytes = 0;
            file >> kibibytes;
            bytes = kibibytes * 1024;
        }
    }
    double most = 0, used = 0;
    std::ifstream limit("/sys/fs/cgroup/memory.max"), current("/sys/fs/cgroup/memory.current");
    if (limit >> most && current >> used) {
        bytes = std::min(bytes.value_or(most), std::max(0.0, most - used));
    }
    return bytes;
}

unsigned usableCores() {
#if defined(__linux__)
    cpu_set_t set;
    if (::sched_getaffinity(0, sizeof set, &set) == 0) {
        return unsigned(CPU_COUNT(&set));
    }
#endif
    return std::thread::hardware_concurrency();
}

} // namespace

Findings checkDenoiser() {
    std::string why;
    if (Denoiser::available(&why)) {
        return {ok("denoiser", "Open Image Denoise is there")};
    }
    if (isSet("HDSTF_OIDN_LIBRARY") || isSet("HDSTF_DENOISE")) {
        return {warning("denoiser", why, "install Open Image Denoise, or let HDSTF_OIDN_LIBRARY name its library")};
    }
    return {ok("denoiser", why + "; only `stf:denoise` needs it")};
}

Findings checkCache() {
    Findings findings;
    const CacheLimit limit = cacheLimit();
    if (!limit.complaint.empty()) {
        findings.push_back(warning("cache", limit.complaint, "give a whole number of megabytes, or unset it"));
    }
    const std::string folder = cacheFolder();
    if (limit.bytes == 0) {
        findings.push_back(
            warning("cache", "HDSTF_CACHE_MAX_MB is 0: nothing is kept, tables are computed for each run", "unset it"));
        return findings;
    }
    const fs::path there = nearestThere(folder);
    if (const std::string why = whyNotWritable(there); !why.empty()) {
        findings.push_back(warning(
            "cache", folder + " cannot be written (" + why + "): what it does not hold is computed for each run",
            "let HDSTF_CACHE_DIR name a folder of yours"));
    } else {
        std::string text = folder + ": ";
        for (const auto& store : {tableStore(), mapStore()}) {
            const StoreSummary held = store->summary();
            text += std::to_string(held.entries) + " " + (held.entries == 1 ? store->kind().one : store->kind().many) +
                    " (" + amount(double(held.bytes)) + "), ";
        }
        findings.push_back(ok("cache", text + "limit " + amount(double(limit.bytes)) + " each"));
    }
    std::error_code error;
    const fs::space_info space = fs::space(there, error);
    if (!error) {
        const std::string text = amount(double(space.available)) + " free on the disk of the cache";
        findings.push_back(
            double(space.available) < kLittleDisk
                ? warning("disk", text, "make room: `stf cache --clear` removes what can be computed again")
                : ok("disk", text));
    }
    return findings;
}

Findings checkMachine() {
    Findings findings;
    if (const std::optional<double> memory = freeMemory()) {
        const std::string text = amount(*memory) + " free";
        findings.push_back(*memory < kLittleMemory
                               ? warning("memory", text, "end other programs: a shell of a large mesh takes a gigabyte")
                               : ok("memory", text));
    }
    const unsigned all = std::thread::hardware_concurrency(), usable = usableCores();
    findings.push_back(ok("threads", std::to_string(usable) + (usable == 1 ? " core" : " cores") +
                                         (usable < all ? " of " + std::to_string(all) : "")));
    return findings;
}

} // namespace stf::doctor
