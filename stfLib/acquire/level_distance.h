// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/base/vec.h"

#include <vector>

namespace stf {

/// A level field with noise and the steps of voxels taken off: a Gaussian of `sigma` voxels, applied as 2 G - G^2
/// ("twicing", Tukey 1977), which leaves curved surfaces where they are to second order where G alone would shrink
/// them. Periodic in x and y, constant beyond the first and last layer. sigma 0 changes nothing.
std::vector<float> smoothLevel(const Vec3i& size, const std::vector<float>& level, double sigma);

/// Signed distance in mm to the zero set of a level, negative where the level is; level between the middles of voxels
/// by Catmull-Rom splines, periodic in x and y, constant beyond the first and last layer. Voxels beside the surface get
/// the distance of their nearest point of it by Newton's method (Chopp 2001, "Some improvements of the fast marching
/// method"), the others follow by fast sweeping (Zhao 2005). Empty where all is inside; throws Error where nothing is;
/// Cancelled.
std::vector<float> signedDistance(const Vec3i& size, const Vec3d& voxelMm, const std::vector<float>& level,
                                  Progress& progress);

/// Share of the tile's volume inside, each voxel cut by a plane of its distance and gradient.
double insideShare(const Vec3i& size, const Vec3d& voxelMm, const std::vector<float>& distance);
/// The same of a level.
double insideShareOfLevel(const Vec3i& size, const Vec3d& voxelMm, const std::vector<float>& level);

/// Moves the surface outward or inward everywhere by as much, at most half a voxel, that this share is inside: what
/// smoothing took of a volume is given back. Returns how far in mm, outward positive.
double moveToShare(const Vec3i& size, const Vec3d& voxelMm, double share, std::vector<float>& distance);

} // namespace stf
