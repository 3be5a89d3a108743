// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_measure.h"

namespace stf {

namespace {

constexpr double kWrongTexels = 1;        ///< off by more near a seam: the wrong patch
constexpr double kOtherSheetCosine = 0.5; ///< between normals: another part of the surface

double unwrapped(double d, double tile) {
    return d - tile * std::round(d / tile);
}

} // namespace

void measureLevel(const ShellGridData& grid, int level, const std::vector<ProbedPoint>& probes, double texelMm,
                  ShellLevelReport& report) {
    ShellReader reader(grid);
    const double voxelMm = report.voxel * grid.mmPerUnit;
    double exemplar = 0, depth = 0, angle = 0;
    std::size_t far = 0, near = 0, wrong = 0, other = 0, missing = 0;
    for (const ProbedPoint& p : probes) {
        ShellLookup found;
        if (!reader.lookup(Vec3f(p.point), level, found, nullptr)) {
            ++missing;
            continue;
        }
        const double dx = unwrapped(double(found.exemplar.x) - p.exact.exemplar.x, grid.tileMm.x) / texelMm;
        const double dy = unwrapped(double(found.exemplar.y) - p.exact.exemplar.y, grid.tileMm.y) / texelMm;
        const double dz = double(found.depth) - p.exact.depth;
        const double cosine = dot(Vec3d(found.normal), p.exact.normal);
        const bool otherSheet = cosine < kOtherSheetCosine || std::abs(dz) > voxelMm;
        if (p.seamDistance < report.voxel) {
            ++near;
            wrong += otherSheet || std::max(std::abs(dx), std::abs(dy)) > kWrongTexels;
            continue;
        }
        ++far;
        if (otherSheet) {
            ++other;
            continue;
        }
        exemplar += dx * dx + dy * dy;
        depth += dz * dz;
        const double a = std::atan2(length(cross(Vec3d(found.normal), p.exact.normal)), cosine);
        angle += a * a;
    }
    const auto share = [](std::size_t part, std::size_t all) { return all ? double(part) / double(all) : 0.0; };
    const double counted = double(std::max<std::size_t>(far - other, 1));
    report.exemplarTexels = std::sqrt(exemplar / counted);
    report.depthTexels = std::sqrt(depth / counted) / texelMm;
    report.depthVoxels = std::sqrt(depth / counted) / voxelMm;
    report.normalDegrees = std::sqrt(angle / counted) * 180 / 3.14159265358979;
    report.otherSheetShare = share(other, far);
    report.seamWrongShare = share(wrong, near);
    // A seam has a band of two voxels' width; what is wrong of it is as wide as the seam is displaced.
    report.seamTexels = report.seamWrongShare * 2 * voxelMm / texelMm;
    report.missingShare = share(missing, probes.size());
}

} // namespace stf
