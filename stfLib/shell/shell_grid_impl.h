// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to the shell layer.

#include "stfLib/base/openvdb_headers.h"

#include "stfLib/shell/shell_grid.h"

#include <cstdint>
#include <vector>

namespace stf {

/// What a lookup reads, and where on the surface it comes from.
struct alignas(64) ShellSample {
    Vec2f exemplar;
    float depth;
    Vec3f gradX, gradY, normal;
    std::uint32_t triangle;
    std::uint16_t b1, b2; ///< barycentric, in 1/65535; only what is given per point of the surface needs them
};
static_assert(sizeof(ShellSample) == 64, "a lookup reads eight of these: one cache line each");

/// All of a built grid.
struct ShellGridData {
    openvdb::Int32Tree tree{-1}; ///< voxel -> number of its sample; -1: none
    std::vector<ShellSample> samples;
    std::vector<Vec3i> triangles; ///< points of the surface's triangles
    std::size_t points = 0;       ///< of the surface
    Vec3d origin;                 ///< position of voxel (0, 0, 0)'s centre, object space
    double voxel = 0;
    double mmPerUnit = 1;
    Vec2d tileMm;

    Vec3d centre(int x, int y, int z) const { return origin + Vec3d(x, y, z) * voxel; }
};

struct ShellGrid::Impl : ShellGridData {};

/// Fills tree and samples of a grid whose other members are set. Deterministic for any number of threads.
void scanShell(const RefinedSurface& surface, const ShellBoundary& boundary, const ExemplarMap& map,
               ShellGridData& grid, Progress& progress, const MessageSink& messages);

} // namespace stf
