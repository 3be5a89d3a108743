// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/map_cache.h"

#include "stfLib/cache/cache_settings.h"
#include "stfLib/cache/map_io.h"

#include <filesystem>

namespace stf {

std::unique_ptr<ContentStore> mapStore(const std::string& folder) {
    const std::filesystem::path parent = folder.empty() ? cacheFolder() : folder;
    return std::make_unique<ContentStore>((parent / "maps").string(), cacheLimit().bytes,
                                          StoreKind{"map", "maps", ".map"});
}

MapProvider cachedMaps(std::string folder) {
    const std::shared_ptr<ContentStore> store = mapStore(folder);
    return [store](const std::string& key, const std::function<ExemplarMap()>& make, Progress& progress,
                   const MessageSink& messages) -> std::shared_ptr<const ExemplarMap> {
        std::shared_ptr<const ExemplarMap> map;
        StoreRecipe recipe;
        recipe.read = [&](const std::shared_ptr<const StoreEntry>& entry) {
            map = std::make_shared<const ExemplarMap>(readExemplarMap(entry->path()));
        };
        recipe.make = [&] { map = std::make_shared<const ExemplarMap>(make()); };
        recipe.write = [&](const std::string& path) { writeExemplarMap(*map, path); };
        store->fetch(key, recipe, progress, messages);
        return map;
    };
}

} // namespace stf
