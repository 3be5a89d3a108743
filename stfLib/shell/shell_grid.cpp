// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_grid_impl.h"

#include "stfLib/base/parallel.h"

#include <cstdio>

namespace stf {

namespace {

/// Samples of a shell at a voxel size: area times thickness and margins, curvature left aside.
double estimatedSamples(const RefinedSurface& surface, const ShellBoundary& boundary, double voxel) {
    double volume = 0;
    for (const Vec3i& t : surface.triangles) {
        const Vec3d p(surface.points[std::size_t(t.x)]);
        const double area = 0.5 * length(cross(Vec3d(surface.points[std::size_t(t.y)]) - p,
                                               Vec3d(surface.points[std::size_t(t.z)]) - p));
        double thickness = 0;
        for (int c = 0; c < 3; ++c) {
            thickness += double(boundary.thickness[std::size_t(t[c])]) / 3;
        }
        const double cell = area * (thickness + 3.6 * voxel);
        volume += std::isfinite(cell) ? cell : 0.0;
    }
    return volume / (voxel * voxel * voxel);
}

double chooseVoxel(const RefinedSurface& surface, const ShellBoundary& boundary, const ShellGridOptions& options,
                   const MessageSink& messages) {
    double thickest = 0;
    for (float t : boundary.thickness) {
        thickest = std::max(thickest, std::isfinite(t) ? double(t) : 0.0);
    }
    if (!(thickest > 0)) {
        throw Error("the shell has no thickness");
    }
    const double wanted =
        options.voxelSize > 0 && std::isfinite(options.voxelSize) ? double(options.voxelSize) : thickest / 8;
    double voxel = wanted;
    while (estimatedSamples(surface, boundary, voxel) > double(std::max<std::size_t>(options.maxSamples, 1))) {
        voxel *= 1.05;
    }
    if (voxel > wanted) {
        char text[160];
        std::snprintf(text, sizeof text,
                      "the shell grid's voxels are %.3g units instead of %.3g to stay below %zu samples", voxel, wanted,
                      options.maxSamples);
        report(messages, Severity::Warning, text);
    }
    return voxel;
}

void check(const RefinedSurface& surface, const ShellBoundary& boundary, const ExemplarMap& map) {
    const std::size_t corners = 3 * surface.triangles.size();
    if (surface.triangles.empty() || surface.bounds.empty()) {
        throw Error("the surface has no triangles");
    }
    if (surface.normals.size() != surface.points.size() || boundary.inner.size() != surface.points.size() ||
        boundary.thickness.size() != surface.points.size()) {
        throw Error("the shell's boundary does not belong to its surface");
    }
    if (map.cornerCoords.size() != corners || map.gradientX.size() != corners || map.gradientY.size() != corners ||
        !(map.tileMm.x > 0 && map.tileMm.y > 0)) {
        throw Error("the exemplar coordinates do not belong to the surface");
    }
}

} // namespace

ShellGrid::ShellGrid() : impl_(std::make_unique<Impl>()) {}
ShellGrid::~ShellGrid() = default;
ShellGrid::ShellGrid(ShellGrid&&) noexcept = default;
ShellGrid& ShellGrid::operator=(ShellGrid&&) noexcept = default;

ShellGrid ShellGrid::build(const RefinedSurface& surface, const ShellBoundary& boundary, const ExemplarMap& map,
                           const ShellGridOptions& options, Progress& progress, const MessageSink& messages) {
    check(surface, boundary, map);
    ShellGrid grid;
    Impl& impl = *grid.impl_;
    impl.voxel = chooseVoxel(surface, boundary, options, messages);
    impl.mmPerUnit = options.mmPerUnit;
    impl.tileMm = map.tileMm;
    impl.origin = Vec3d(surface.bounds.lo);
    impl.triangles = surface.triangles;
    impl.points = surface.points.size();
    scanShell(surface, boundary, map, impl, progress, messages);
    return grid;
}

std::vector<Rgb> ShellGrid::spreadCoreRadiance(const std::vector<Rgb>& perPoint) const {
    if (perPoint.size() != impl_->points) {
        throw Error("core radiance is not given per point of the surface");
    }
    std::vector<Rgb> spread(impl_->samples.size());
    parallelFor(spread.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const ShellSample& s = impl_->samples[i];
            const Vec3i& t = impl_->triangles[s.triangle];
            const float b1 = float(s.b1) / 65535.0f, b2 = float(s.b2) / 65535.0f;
            spread[i] = perPoint[std::size_t(t.x)] * (1 - b1 - b2) + perPoint[std::size_t(t.y)] * b1 +
                        perPoint[std::size_t(t.z)] * b2;
        }
    });
    return spread;
}

float ShellGrid::voxelSize() const {
    return float(impl_->voxel);
}

std::size_t ShellGrid::sampleCount() const {
    return impl_->samples.size();
}

std::size_t ShellGrid::memoryBytes() const {
    return impl_->samples.capacity() * sizeof(ShellSample) + impl_->triangles.capacity() * sizeof(Vec3i) +
           std::size_t(impl_->tree.memUsage());
}

void ShellGrid::write(const std::string& path) const {
    openvdb::initialize();
    const auto transform = openvdb::math::Transform::createLinearTransform(impl_->voxel);
    transform->postTranslate(openvdb::Vec3d(impl_->origin.x, impl_->origin.y, impl_->origin.z));
    const char* names[3] = {"exemplar_x", "exemplar_y", "depth"};
    openvdb::GridPtrVec grids;
    for (int g = 0; g < 3; ++g) {
        auto tree = std::make_shared<openvdb::FloatTree>(impl_->tree, 0.0f, openvdb::TopologyCopy());
        openvdb::tree::ValueAccessor<const openvdb::Int32Tree> index(impl_->tree);
        for (auto it = tree->beginValueOn(); it; ++it) {
            const ShellSample& s = impl_->samples[std::size_t(index.getValue(it.getCoord()))];
            it.setValue(g == 0 ? s.exemplar.x : g == 1 ? s.exemplar.y : s.depth);
        }
        const auto grid = openvdb::FloatGrid::create(tree);
        grid->setName(names[g]);
        grid->setTransform(transform);
        grids.push_back(grid);
    }
    try {
        openvdb::io::File(path).write(grids);
    } catch (const std::exception& e) {
        throw Error("cannot write " + path + ": " + e.what());
    }
}

} // namespace stf
