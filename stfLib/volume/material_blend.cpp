// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/material_blend.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {

// Fractions of a voxel may exceed 1 by rounding of what made them.
constexpr double kRounding = 1e-4;

} // namespace

void blendMaterials(BaseVolume& v, const std::vector<Material>& materials, const std::vector<float>& fractions) {
    const std::size_t voxels = v.voxelCount(), kinds = materials.size();
    if (kinds == 0 || fractions.size() != voxels * kinds) {
        throw Error("the volume fractions of " + std::to_string(kinds) + " materials in " + std::to_string(voxels) +
                    " voxels are " + std::to_string(fractions.size()) + " numbers");
    }
    v.extinction.assign(voxels, Rgb(0.0f));
    v.albedo.assign(voxels, Rgb(0.0f));
    v.g.assign(voxels, 0.0f);
    v.ior.assign(voxels, 1.0f);
    bool anyG = false, anyIor = false;
    for (std::size_t i = 0; i < voxels; ++i) {
        const float* const f = fractions.data() + i * kinds;
        double sum = 0;
        for (std::size_t m = 0; m < kinds; ++m) {
            if (!(f[m] >= 0) || !std::isfinite(f[m])) {
                throw Error("the volume fraction of " + materials[m].name + " in voxel " + std::to_string(i) + " is " +
                            std::to_string(f[m]));
            }
            sum += double(f[m]);
        }
        if (sum > 1 + kRounding) {
            throw Error("the volume fractions of voxel " + std::to_string(i) + " add up to " + std::to_string(sum));
        }
        if (sum == 0) {
            continue;
        }
        // A voxel whose corners lie on one side is not cut: what it lacks inside are pores.
        const bool cut = !v.surface.empty() && std::abs(double(v.surface[i])) <= 0.5 * length(v.voxelMm);
        const double share = cut || sum > 1 ? 1 / sum : 1.0;
        Vec3d sigmaA(0.0), sigmaS(0.0);
        double forward = 0, scattering = 0, ior = 0;
        for (std::size_t m = 0; m < kinds; ++m) {
            const double part = double(f[m]) * share;
            sigmaA += materials[m].sigmaA * part;
            sigmaS += materials[m].sigmaS * part;
            const double grey = average(materials[m].sigmaS) * part;
            scattering += grey;
            forward += grey * materials[m].g;
            ior += double(f[m]) * materials[m].ior;
        }
        const Vec3d total = sigmaA + sigmaS;
        for (int c = 0; c < 3; ++c) {
            v.extinction[i][c] = float(total[c]);
            v.albedo[i][c] = total[c] > 0 ? float(std::min(1.0, sigmaS[c] / total[c])) : 0.0f;
        }
        v.g[i] = scattering > 0 ? float(forward / scattering) : 0.0f;
        v.ior[i] = float(ior / sum);
        anyG = anyG || v.g[i] != 0;
        anyIor = anyIor || v.ior[i] != 1;
    }
    if (!anyG) {
        v.g.clear();
    }
    if (!anyIor) {
        v.ior.clear();
    }
}

} // namespace stf
