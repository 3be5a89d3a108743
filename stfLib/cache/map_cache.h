// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/cache/content_store.h"
#include "stfLib/render/renderer.h"

namespace stf {

/// The store of synthesised exemplar coordinates in the folder `maps` of `folder` (empty: cacheFolder()), of the size
/// cacheLimit().
std::unique_ptr<ContentStore> mapStore(const std::string& folder = {});

/// A map provider over that store. What can go wrong with files is reported and costs time, never the map.
MapProvider cachedMaps(std::string folder = {});

} // namespace stf
