// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/shell/shell_surface.h"
#include "stfLib/synthesis/exemplar_map.h"

#include <cstdint>
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
    Vec3f normal;           ///< unit, outward, of the smooth limit surface
    Rgb coreRadiance;       ///< radiance leaving the core below this point (B / pi); zero where none is given
    std::uint32_t triangle; ///< of the surface, above the nearest voxel's middle
    float b1, b2;           ///< barycentric there: (1 - b1 - b2), b1, b2
};

struct ShellGridOptions {
    float voxelSize = 0; ///< object units, of the finest level; 0: by the two errors below
    int levels = 0;      ///< at most so many; 0: until a voxel is as large as the shell is thick
    double mmPerUnit = 1;
    double texelMm = 0;                          ///< what errors are measured in; 0: a 64th of the tile
    double errorTexels = 0.1;                    ///< wanted rms error of coordinates and of the depth, away from seams
    double seamTexels = 0;                       ///< wanted mean displacement of seams; 0: any
    std::size_t maxBytes = std::size_t(2) << 30; ///< of all levels; voxels grow until they fit, with a message
};

/// What a level costs and how wrong it is, measured at random points of the shell against exact inversion of prisms.
struct ShellLevelReport {
    double voxel = 0; ///< object units
    std::size_t samples = 0, bytes = 0;
    double seconds = 0;           ///< of scan conversion
    double exemplarTexels = 0;    ///< rms, of points more than a voxel from seams
    double depthTexels = 0;       ///< rms
    double depthVoxels = 0;       ///< rms
    double normalDegrees = 0;     ///< rms
    double otherSheetShare = 0;   ///< of those points: they see another part of the surface
    double seamWrongShare = 0;    ///< of points within a voxel of a seam: they see the wrong patch
    double seamTexels = 0;        ///< mean displacement of seams that follows
    double missingShare = 0;      ///< of all points: the grid has nothing there
    std::size_t foldedVoxels = 0; ///< inside the shell, and inside out
    double errorTexels() const { return std::max(exemplarTexels, depthTexels); }
};

/// Of the grid as a whole.
struct ShellGridReport {
    std::size_t probes = 0;               ///< random points that errors were measured at
    double seamLength = 0, rimLength = 0; ///< object units
    std::size_t rimEdges = 0;             ///< edges of one triangle: an open surface's shell ends there in a wall
    std::size_t crowdedEdges = 0;         ///< of more than two triangles: where shells overlap the nearer surface wins
    std::size_t turnedEdges = 0;          ///< between triangles of opposite orientation
    std::size_t unusableTriangles = 0;    ///< without area
    bool insideOut = false;               ///< a closed surface whose triangles face inward
    bool errorMet = true;                 ///< false: the memory limit or the finest sensible voxel came first
};

struct ShellGridData;

/// Sparse grid over the shell: voxel -> exemplar coordinate, depth, frame, in leaves of 8^3 voxels over packed samples.
/// Levels of voxel sizes h, 2h, 4h ... are made by one build, so that no camera asks for another. Built by
/// scan-converting the prisms between limit surface and inner boundary, nearly two voxels beyond both so that
/// interpolation has all its corners. Immutable after build; lookups from any number of threads, one Accessor each.
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
        /// core per sample (spreadCoreRadiance), or null for none. `level` is clamped to those there are.
        bool lookup(const Vec3f& objectPoint, ShellLookup& out, const Rgb* core = nullptr, int level = 0);
        /// Beside hard edges, lookups from now on stay on the side that faces along a normal, as far as the grid holds
        /// it; (0, 0, 0): they take the side that they are nearer to.
        void prefer(const Vec3f& normal);
        /// Asks for the memory of a lookup that comes soon.
        void prefetch(const Vec3f& objectPoint, int level = 0);

    private:
        struct Impl;
        std::unique_ptr<Impl> impl_;
    };

    /// Radiance leaving the core, per point of the surface (inner boundary), spread to the samples of all levels: what
    /// `lookup` takes. Each instance of a mesh has its own, since lights reach it from other sides.
    std::vector<Rgb> spreadCoreRadiance(const std::vector<Rgb>& perPoint) const;

    int levelCount() const;
    /// The coarsest level whose errors are small against a footprint (tile mm, the width of what a pixel sees).
    int levelFor(float footprintMm) const;
    float voxelSize(int level = 0) const;
    const std::vector<ShellLevelReport>& levels() const; ///< finest first
    const ShellGridReport& report() const;

    std::size_t sampleCount() const; ///< of all levels
    std::size_t memoryBytes() const;
    /// Writes exemplar coordinate, depth and normal of the finest level as OpenVDB grids, for other tools: to a
    /// temporary beside `path`, which is renamed.
    void write(const std::string& path) const;

    /// For the shell layer's own tests and benchmarks (shell_grid_impl.h).
    const ShellGridData& data() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace stf
