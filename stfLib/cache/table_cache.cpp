// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/table_cache.h"

#include "stfLib/cache/cache_settings.h"
#include "stfLib/transport/precompute.h"

#include <atomic>
#include <filesystem>

namespace stf {

std::unique_ptr<ContentStore> tableStore(const std::string& folder) {
    const std::filesystem::path parent = folder.empty() ? cacheFolder() : folder;
    return std::make_unique<ContentStore>((parent / "tables").string(), cacheLimit().bytes);
}

namespace {
std::string keyOf(const BaseVolume& volume, const TransportOptions& options) {
    return volume.contentHash() + ";" + options.key();
}
} // namespace

TableKept tablesKept(const std::string& folder) {
    const std::shared_ptr<const ContentStore> store = tableStore(folder);
    return [store](const BaseVolume& volume, const TransportOptions& options) {
        return std::filesystem::exists(store->pathOf(keyOf(volume, options)));
    };
}

TableProvider cachedTables(std::string folder) {
    struct State {
        std::unique_ptr<ContentStore> store;
        std::string complaint;
        std::atomic<bool> complained{false};
    };
    const auto state = std::make_shared<State>();
    state->store = tableStore(folder);
    state->complaint = cacheLimit().complaint;
    return [state](const std::shared_ptr<const BaseVolume>& volume, const TransportOptions& options, Progress& progress,
                   const MessageSink& messages) -> std::shared_ptr<const StfTable> {
        if (!state->complaint.empty() && !state->complained.exchange(true)) {
            report(messages, Severity::Warning, state->complaint);
        }
        const std::string key = keyOf(*volume, options);
        std::shared_ptr<const StfTable> table;
        StoreRecipe recipe;
        bool made = false;
        recipe.read = [&](const std::shared_ptr<const StoreEntry>& entry) {
            auto read = std::make_unique<StfTable>(readTable(entry->path(), key));
            read->madeNow = made;
            // The table keeps its entry: it may read parts of the file later.
            table = {read.release(), [entry](const StfTable* t) { delete t; }};
        };
        recipe.make = [&] {
            made = true;
            table = std::make_shared<const StfTable>(precompute(*volume, options, progress, messages));
        };
        recipe.write = [&](const std::string& path) { writeTable(*table, key, path); };
        state->store->fetch(key, recipe, progress, messages);
        // What is stored is rounded: a frame must not differ from the next run's, which will read it.
        if (const auto entry = made ? state->store->find(key) : nullptr) {
            recipe.read(entry);
        }
        return table;
    };
}

} // namespace stf
