// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/renderer.h"

namespace stf {

/// A table provider over a folder: an entry's name is the hash of the volume's content, the transport options and the
/// version of the algorithm. Written to a temporary file and renamed, so that a reader never sees half an entry; an
/// entry that cannot be read is rebuilt. An empty folder means `$HDSTF_CACHE_DIR`, `$XDG_CACHE_HOME/hdstf` or
/// `~/.cache/hdstf`. A folder that cannot be written is reported once; tables are then computed and not kept.
TableProvider cachedTables(std::string folder = {});

} // namespace stf
