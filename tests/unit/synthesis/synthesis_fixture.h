// SPDX-License-Identifier: Apache-2.0
#pragma once

// Samples and surfaces for the tests of synthesis.

#include "stfLib/synthesis/synthesize.h"
#include "tests/unit/surface/test_meshes.h"

#include <cmath>

namespace stf::test {

/// A periodic sample of `n` x `n` columns: waves of some directions, each with a phase of its own, in absorption.
inline BaseVolume waves(int n, double voxelMm = 0.5) {
    BaseVolume v;
    v.name = "waves";
    v.size = {n, n, 3};
    v.voxelMm = Vec3d(voxelMm);
    v.extinction.assign(v.voxelCount(), Rgb(2.0f));
    v.albedo.resize(v.voxelCount());
    const int k[5][2] = {{1, 2}, {3, -1}, {2, 3}, {-4, 1}, {5, 4}};
    for (int z = 0; z < 3; ++z) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) {
                double sum = 0;
                for (int i = 0; i < 5; ++i) {
                    sum += std::cos(2 * pi * (k[i][0] * (x + 0.5) + k[i][1] * (y + 0.5)) / n + 1.3 * i);
                }
                v.albedo[v.index(x, y, z)] = Rgb(float(1 - 0.02 * std::exp(0.8 * sum)));
            }
        }
    }
    v.coreSigmaA = Vec3d(0.05);
    v.coreSigmaSPrime = Vec3d(2);
    return v;
}

inline RefinedSurface refinedOf(ControlMesh mesh) {
    sanitize(mesh);
    return refine(mesh, {}, {});
}

/// A torus sampled once per texel.
inline RefinedSurface sampledTorus(double texelMm) {
    return sampleSurface(refinedOf(torus(20, 8, 96, 40)), texelMm, 1, 1000000, {});
}

inline Synthesis synthesized(const RefinedSurface& surface, const BaseVolume& volume, std::uint64_t seed = 0,
                             double mmPerUnit = 1) {
    SynthesisOptions options;
    options.seed = seed;
    Progress progress;
    return synthesize(surface, volume, mmPerUnit, options, progress);
}

} // namespace stf::test
