// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/table_cache.h"

#include "stfLib/transport/precompute.h"

#include <atomic>
#include <cstdlib>
#include <filesystem>

namespace stf {

namespace {

namespace fs = std::filesystem;

fs::path defaultFolder() {
    if (const char* dir = std::getenv("HDSTF_CACHE_DIR"); dir && *dir) {
        return dir;
    }
    if (const char* dir = std::getenv("XDG_CACHE_HOME"); dir && *dir) {
        return fs::path(dir) / "hdstf";
    }
    const char* home = std::getenv("HOME");
    return fs::path(home && *home ? home : "/tmp") / ".cache" / "hdstf";
}

} // namespace

TableProvider cachedTables(std::string folder) {
    const fs::path tables = (folder.empty() ? defaultFolder() : fs::path(folder)) / "tables";
    const auto reported = std::make_shared<std::atomic<bool>>(false);
    return [tables, reported](const std::shared_ptr<const BaseVolume>& volume, const TransportOptions& options,
                              Progress& progress, const MessageSink& messages) -> std::shared_ptr<const StfTable> {
        const std::string key = volume->contentHash() + ";" + options.key();
        // The key's own text is in the file; its hash only names it.
        const fs::path file = tables / (contentHashOf(key) + ".vdb");
        std::error_code error;
        if (fs::exists(file, error)) {
            try {
                return std::make_shared<const StfTable>(readTable(file.string(), key));
            } catch (const std::exception& e) {
                report(messages, Severity::Info, std::string("a cached table is made again: ") + e.what());
            }
        }
        auto table = std::make_shared<const StfTable>(precompute(*volume, options, progress, messages));
        try {
            writeTable(*table, key, file.string());
        } catch (const std::exception& e) {
            if (!reported->exchange(true)) {
                report(messages, Severity::Warning, std::string("tables are not kept: ") + e.what());
            }
        }
        return table;
    };
}

} // namespace stf
