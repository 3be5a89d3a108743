// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan.h"

namespace stf {

/// Axes of a scan as those of a tile: the scan's values in another order, in place.
struct ScanView {
    const float* origin = nullptr; ///< voxel (0, 0, 0) of the tile
    Vec3i size{0, 0, 0};
    Vec3<std::ptrdiff_t> stride{0, 0, 0};
    Vec3d spacingMm{1, 1, 1};

    float operator()(int x, int y, int z) const { return origin[x * stride.x + y * stride.y + z * stride.z]; }
};

/// A scan seen with one of its axes going into the material: "+z", "-z", "+x" and so on (z of the tile). x and y of the
/// tile are the two axes that follow it in the order x, y, z, x; for a negative axis y is turned round as well, so that
/// the view is the scan turned, never mirrored. Throws Error for another name. The scan must outlive the view.
ScanView viewAlong(const Scan& scan, const std::string& depth);

/// The axis of the scan (0, 1, 2) that is each axis of the tile.
Vec3i axesAlong(const std::string& depth);

/// A part of a scan as text: "x0:x1,y0:y1,z0:z1", first voxel included, last not; "a:bmm" in mm from the scan's first
/// face, to the nearest voxel; nothing between commas is all of that axis, nothing beside a colon its end. Throws Error
/// where that is not understood, empty or outside.
VoxelBox parseCrop(const std::string& text, const Vec3i& size, const Vec3d& spacingMm);

} // namespace stf
