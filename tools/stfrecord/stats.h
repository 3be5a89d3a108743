// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/stfrecord/console.h"
#include "tools/stfrecord/image.h"

#include "pxr/base/vt/dictionary.h"

#include <string>
#include <vector>

namespace stfrecord {

/// One rendered frame, as the delegate and the recorder saw it.
struct FrameStats {
    std::string scene;
    std::string product; ///< of render settings; empty: the command line's
    double frame = 0;
    int width = 0, height = 0;
    double seconds = 0; ///< from the first execute to convergence
    PXR_NS::VtDictionary delegate;
};

/// Puts the delegate's own messages on the console's list; errors among them mean that
/// something is missing in the image.
void collectMessages(const PXR_NS::VtDictionary& delegateStats, Console& console);

/// Writes --stats: an object, or a list of them for several frames. Throws std::runtime_error.
void writeStats(const std::vector<FrameStats>& frames, const std::vector<Message>& messages, const std::string& path);

/// What an image says of how it was made, beside the settings: the plan, times and the error estimate as the statistics
/// have them, and the standard entries of a cryptomatte among its layers.
std::vector<std::pair<std::string, std::string>> imageMetadata(const FrameStats& frame, const Image& image);

/// The plan of a frame as a table.
std::string planTable(const PXR_NS::VtDictionary& delegateStats);

} // namespace stfrecord
