// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/shell/shell_surface.h"
#include "stfLib/synthesis/exemplar_map.h"

#include <memory>
#include <vector>

namespace stf {

/// What a point inside the shell sees of the exemplar. First-order: at p + d the exemplar coordinate is
/// exemplar + (gradX.d, gradY.d), the depth is depth - normal.d * mmPerUnit. Valid over about one grid voxel.
struct ShellLookup {
    Vec2f exemplar; ///< tile mm, any representative modulo the tile
    float depth;    ///< mm below the limit surface (negative just outside)
    Vec3f gradX;    ///< mm per object unit
    Vec3f gradY;
    Vec3f normal;     ///< unit, outward, of the smooth limit surface
    Rgb coreRadiance; ///< radiance leaving the core below this point (B / pi); zero where none is given
};

struct ShellGridOptions {
    float voxelSize = 0;                 ///< object units; 0: an eighth of the thickness, bounded by maxSamples
    double mmPerUnit = 1;                ///< tile millimetres per object unit
    std::size_t maxSamples = 40'000'000; ///< the voxel size grows until it fits, with a message
};

/// Sparse grid over the shell: voxel -> exemplar coordinate, depth, frame, in an OpenVDB tree of indices into packed
/// samples. Built by scan-converting the prisms between limit surface and inner boundary, one voxel beyond both so
/// that interpolation has all its corners. Immutable after build; lookups from any number of threads, one Accessor
/// each.
class ShellGrid {
public:
    ShellGrid();
    ~ShellGrid();
    ShellGrid(ShellGrid&&) noexcept;
    ShellGrid& operator=(ShellGrid&&) noexcept;

    static ShellGrid build(const RefinedSurface& surface, const ShellBoundary& boundary, const ExemplarMap& map,
                           const ShellGridOptions& options, Progress& progress, const MessageSink& messages);

    class Accessor {
    public:
        explicit Accessor(const ShellGrid& grid);
        ~Accessor();
        Accessor(Accessor&&) noexcept;
        /// Trilinear over the corners that belong to the same patch as the nearest one (coordinates are unwrapped
        /// modulo the tile; corners across a seam are left out). False outside the band. `core`: radiance leaving the
        /// core per sample (spreadCoreRadiance), or null for none.
        bool lookup(const Vec3f& objectPoint, ShellLookup& out, const Rgb* core = nullptr);

    private:
        struct Impl;
        std::unique_ptr<Impl> impl_;
    };

    /// Radiance leaving the core, per point of the surface (inner boundary), spread to the samples: what `lookup`
    /// takes. Each instance of a mesh has its own, since lights reach it from other sides.
    std::vector<Rgb> spreadCoreRadiance(const std::vector<Rgb>& perPoint) const;

    float voxelSize() const;
    std::size_t sampleCount() const;
    std::size_t memoryBytes() const;
    /// Writes exemplar coordinate and depth as OpenVDB grids, for inspection in other tools.
    void write(const std::string& path) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace stf
