// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/cache_settings.h"
#include "stfLib/cache/map_cache.h"
#include "stfLib/cache/table_cache.h"
#include "tools/stf/commands.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

struct Arguments {
    std::string cache;
    bool clear = false, json = false;
};

std::string describe(const StoreSummary& s, const StoreKind& kind) {
    char text[64];
    std::snprintf(text, sizeof text, "%zu %s, %.1f MB", s.entries, s.entries == 1 ? kind.one : kind.many,
                  double(s.bytes) / 1e6);
    return text;
}

void run(const Arguments& a) {
    if (const std::string complaint = cacheLimit().complaint; !complaint.empty()) {
        std::fprintf(stderr, "%s\n", complaint.c_str());
    }
    nlohmann::json stores = nlohmann::json::object();
    for (const auto& store : {tableStore(a.cache), mapStore(a.cache)}) {
        const StoreSummary removed = a.clear ? store->clear() : StoreSummary();
        const StoreSummary left = store->summary();
        nlohmann::json j{
            {"folder", store->folder()}, {"entries", left.entries}, {"bytes", left.bytes}, {"limit", left.limit}};
        if (a.clear) {
            j["removed"] = {{"entries", removed.entries}, {"bytes", removed.bytes}};
        }
        stores[store->kind().many] = j;
        if (a.json) {
            continue;
        }
        if (a.clear) {
            std::printf("removed: %s\n", describe(removed, store->kind()).c_str());
        }
        std::printf("%s: %s; limit %.0f MB%s\n", store->folder().c_str(), describe(left, store->kind()).c_str(),
                    double(left.limit) / 1e6, left.limit == 0 ? ", that is off" : "");
    }
    if (a.json) {
        std::printf("%s\n", stores.dump().c_str());
    }
}

} // namespace

void addCacheCommand(CLI::App& app) {
    auto* command =
        app.add_subcommand("cache", "Tell what the cache of transport tables and synthesised maps holds, or clear it");
    auto a = std::make_shared<Arguments>();
    command->add_option("--cache", a->cache, "Folder of the stores (default: the one the renderer reads)");
    command->add_flag("--clear", a->clear, "Remove all that is not in use");
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] { run(*a); });
}

} // namespace stf
