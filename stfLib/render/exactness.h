// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace stf {

/// Approximations of the renderer that are replaced by finer ones of the same kind, to measure what they cost: a run
/// with one of them is the limit that the usual picture is compared with (docs/report.md). All off: the usual picture.
struct Exactness {
    bool levels = false;     ///< the grid and the sample are read at their finest, whatever a pixel sees
    bool step = false;       ///< the march takes a quarter of its step
    bool coreTree = false;   ///< sums over samples of the core to a tenth of their error bound
    bool voxels = false;     ///< light is kept for voxels of half the edge; the medium stays as it is
    bool directions = false; ///< tables have directions enough for a quarter of the error that they may make

    /// Of names separated by commas: those of the members above. Throws Error on another one.
    static Exactness parse(const std::string& names);

    bool operator==(const Exactness& e) const {
        return levels == e.levels && step == e.step && coreTree == e.coreTree && voxels == e.voxels &&
               directions == e.directions;
    }
    bool operator!=(const Exactness& e) const { return !(*this == e); }
};

} // namespace stf
