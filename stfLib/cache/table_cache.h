// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/cache/content_store.h"
#include "stfLib/render/forecast.h"
#include "stfLib/render/renderer.h"

namespace stf {

/// The store of transport tables in the folder `tables` of `folder` (empty: cacheFolder()), of the size cacheLimit().
std::unique_ptr<ContentStore> tableStore(const std::string& folder = {});

/// A table provider over that store: an entry's key is the hash of the volume's content, the transport options and the
/// version of the algorithm. What can go wrong with files is reported and costs time, never the table.
TableProvider cachedTables(std::string folder = {});

/// Whether that store has a table. What is there is looked at, not read.
TableKept tablesKept(const std::string& folder = {});

} // namespace stf
