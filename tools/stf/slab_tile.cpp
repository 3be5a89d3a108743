// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/slab_tile.h"

#include <algorithm>

namespace stf {

namespace {

/// So wide that flights hardly ever leave the column to the side.
constexpr double kWideMm = 1000;

// Depths between voxels of a layer of this optical depth, from 0 to 1; symmetric, graded towards both faces.
std::vector<double> gradedEdges(double depth) {
    const double half = 0.5 * depth;
    std::vector<double> upper{0};
    while (upper.back() < half) {
        const double d = upper.back();
        upper.push_back(d + std::max(std::min(0.04 + 0.1 * d, 0.4), 0.05 * d));
    }
    if (upper.size() < 3) {
        upper = {0, 0.5, 1}; // thinnest layers: four voxels
    }
    const double scale = 0.5 / upper.back();
    std::vector<double> edges;
    for (double d : upper) {
        edges.push_back(d * scale);
    }
    for (std::size_t i = upper.size() - 1; i-- > 0;) {
        edges.push_back(1 - upper[i] * scale);
    }
    return edges;
}

} // namespace

SlabTile makeSlabTile(const SlabOptions& o) {
    SlabTile tile;
    BaseVolume& v = tile.volume;
    v.name = "slab";
    tile.edges.push_back(0);
    double top = 0;
    for (const SlabLayer& l : o.layers) {
        const Rgb albedo{float(l.albedo)};
        const double scaled = double(scaledExtinction(Rgb(float(l.tau)), albedo, deltaScale(o.form, float(l.g))).x);
        const std::vector<double> edges = scaled > 0 ? gradedEdges(scaled) : std::vector<double>{0, 1};
        for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
            v.extinction.push_back(Rgb(float(l.tau * (edges[i + 1] - edges[i]))));
            v.albedo.push_back(albedo);
            v.g.push_back(float(l.g));
            tile.edges.push_back(top + l.tau * edges[i + 1]);
        }
        top += l.tau;
    }
    v.size = {1, 1, int(v.extinction.size())};
    v.voxelMm = {kWideMm, kWideMm, 1};
    if (o.ior != 1) {
        v.ior.assign(v.voxelCount(), float(o.ior));
    }
    return tile;
}

} // namespace stf
