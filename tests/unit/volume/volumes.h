// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/random.h"
#include "stfLib/volume/base_volume.h"

namespace stf::test {

/// The same coefficients everywhere.
inline BaseVolume homogeneous(const Vec3i& size, const Vec3d& voxelMm, const Rgb& extinction, const Rgb& albedo,
                              float g = 0) {
    BaseVolume v;
    v.name = "test";
    v.size = size;
    v.voxelMm = voxelMm;
    v.extinction.assign(v.voxelCount(), extinction);
    v.albedo.assign(v.voxelCount(), albedo);
    if (g != 0) {
        v.g.assign(v.voxelCount(), g);
    }
    return v;
}

/// The same with an index of refraction.
inline BaseVolume withIndex(BaseVolume v, double n) {
    v.ior.assign(v.voxelCount(), float(n));
    return v;
}

/// Every grid present and every value another; the outermost voxels of the tile are zero where that is legal.
inline BaseVolume varied(const Vec3i& size, std::uint64_t seed = 1) {
    BaseVolume v = homogeneous(size, {0.5, 0.25, 0.125}, Rgb(1.0f), Rgb(0.5f));
    CounterRng rng(seed, 0);
    const auto rgb = [&] { return Rgb(rng.uniform(), rng.uniform(), rng.uniform()); };
    v.g.resize(v.voxelCount());
    v.ior.resize(v.voxelCount());
    v.surface.resize(v.voxelCount());
    v.emission.resize(v.voxelCount());
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                const std::size_t i = v.index(x, y, z);
                const bool border = x == 0 || y == 0 || z == 0 || x == size.x - 1 || y == size.y - 1 || z == size.z - 1;
                v.extinction[i] = border ? Rgb(0.0f) : rgb() * 10.0f;
                v.albedo[i] = border ? Rgb(0.0f) : rgb();
                v.g[i] = border ? 0.0f : 1.8f * rng.uniform() - 0.9f;
                v.ior[i] = 1 + rng.uniform();
                v.surface[i] = border ? 0.0f : -rng.uniform();
                v.emission[i] = border ? Rgb(0.0f) : rgb();
            }
        }
    }
    v.coreSigmaA = {0.1, 0.2, 0.3};
    v.coreSigmaSPrime = {1, 2, 3};
    return v;
}

} // namespace stf::test
