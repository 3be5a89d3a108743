// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/coarse_tile.h"

namespace stf {

namespace {

/// Calls each(block, voxel) for every voxel of every block of columns.
template<class Each>
void forBlocks(const Vec3i& size, int factor, Each&& each) {
    const std::size_t nx = std::size_t(size.x / factor), ny = std::size_t(size.y / factor);
    std::size_t voxel = 0;
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x, ++voxel) {
                each(std::size_t(x / factor) + nx * (std::size_t(y / factor) + ny * std::size_t(z)), voxel);
            }
        }
    }
}

BaseVolume coarseVolume(const BaseVolume& v, int factor) {
    BaseVolume c;
    c.name = v.name;
    c.size = {v.size.x / factor, v.size.y / factor, v.size.z};
    c.voxelMm = {v.voxelMm.x * factor, v.voxelMm.y * factor, v.voxelMm.z};
    c.coreSigmaA = v.coreSigmaA;
    c.coreSigmaSPrime = v.coreSigmaSPrime;
    const std::size_t n = c.voxelCount();
    const float share = 1.0f / float(factor * factor);
    std::vector<float> weight(n, 0.0f);
    c.extinction.assign(n, Rgb(0.0f));
    c.albedo.assign(n, Rgb(0.0f));
    c.g.assign(v.g.empty() ? 0 : n, 0.0f);
    c.ior.assign(v.ior.empty() ? 0 : n, 0.0f);
    c.emission.assign(v.emission.empty() ? 0 : n, Rgb(0.0f));
    forBlocks(v.size, factor, [&](std::size_t block, std::size_t i) {
        const Rgb scattering = v.extinction[i] * v.albedo[i];
        c.extinction[block] += v.extinction[i] * share;
        c.albedo[block] += scattering * share; // divided by extinction below
        weight[block] += average(scattering);
        if (!v.g.empty()) {
            c.g[block] += v.g[i] * average(scattering);
        }
        if (!v.ior.empty()) {
            c.ior[block] += v.ior[i] * share;
        }
        if (!v.emission.empty()) {
            c.emission[block] += v.emission[i] * share;
        }
    });
    for (std::size_t b = 0; b < n; ++b) {
        for (int k = 0; k < 3; ++k) {
            const float extinction = c.extinction[b][k];
            c.albedo[b][k] = extinction > 0 ? std::min(c.albedo[b][k] / extinction, 1.0f) : 0.0f;
        }
        if (!v.g.empty()) {
            c.g[b] = weight[b] > 0 ? c.g[b] / weight[b] : 0.0f;
        }
    }
    return c;
}

FactoredField coarseField(const FactoredField& field, const TileMedium& medium, int factor) {
    FactoredField c;
    if (field.empty()) {
        return c;
    }
    if (field.items() != medium.voxelCount()) {
        throw Error("the table does not belong to the volume");
    }
    c.rank = field.rank;
    c.components = field.components;
    c.directions = field.directions;
    c.basis = field.basis;
    const std::size_t n = medium.voxelCount() / std::size_t(factor * factor);
    const std::size_t width = std::size_t(field.rank) * std::size_t(field.components);
    std::vector<double> sums(n * width, 0.0);
    std::vector<Vec3d> weights(n, Vec3d(0.0));
    // Blocks without scattering keep their plain mean, by a weight that vanishes beside any other.
    constexpr double kLeast = 1e-12;
    forBlocks(medium.size(), factor, [&](std::size_t block, std::size_t i) {
        const TileMedium::Voxel& m = medium.voxel(i);
        const Vec3d w = Vec3d(m.scattering) * double(m.keep) + Vec3d(kLeast);
        weights[block] += w;
        const float* from = field.factors.data() + i * width;
        double* to = sums.data() + block * width;
        for (std::size_t k = 0; k < width; ++k) {
            to[k] += w[int(k % 3)] * double(from[k]); // components are rgb, rgb along x, y, z
        }
    });
    c.factors.resize(n * width);
    for (std::size_t b = 0; b < n; ++b) {
        for (std::size_t k = 0; k < width; ++k) {
            c.factors[b * width + k] = float(sums[b * width + k] / weights[b][int(k % 3)]);
        }
    }
    return c;
}

} // namespace

bool canCoarsen(const BaseVolume& v, const TileMedium& medium, int factor) {
    return factor > 1 && !medium.hasSurface() && !v.laterallyUniform() && v.size.x % factor == 0 &&
           v.size.y % factor == 0 && v.size.x / factor >= 2 && v.size.y / factor >= 2;
}

CoarseTile coarsenTile(const BaseVolume& volume, const TileMedium& medium, const StfTable& table, int factor,
                       bool backlight) {
    if (!canCoarsen(volume, medium, factor)) {
        throw Error("the columns of this tile cannot be made fewer by " + std::to_string(factor));
    }
    CoarseTile out;
    out.factor = factor;
    const BaseVolume coarse = coarseVolume(volume, factor);
    out.medium = std::make_shared<const TileMedium>(coarse, medium.form(), medium.openBottom());
    auto t = std::make_shared<StfTable>();
    t->size = coarse.size;
    t->voxelMm = coarse.voxelMm;
    t->directions = table.directions;
    t->form = table.form;
    if (medium.scatters()) {
        t->multiple = coarseField(table.multiple.get(), medium, factor);
        if (backlight) {
            t->backlight = coarseField(table.backlight.get(), medium, factor);
        }
        if (medium.emits()) {
            t->emitted = coarseField(table.emitted.get(), medium, factor);
        }
    }
    out.table = t;
    return out;
}

} // namespace stf
