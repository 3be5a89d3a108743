// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/tile_blend.h"

#include "stfLib/acquire/tile_overlap.h"
#include "stfLib/base/parallel.h"

#include <algorithm>

namespace stf {

namespace {

TileField blendAxis(const TileField& f, int axis, int overlap) {
    return joinSides(f, axis, overlap, [&](int i, int, int) {
        return float((i + 0.5) / overlap); // share of the tile's own voxel
    });
}

} // namespace

double fitMeans(TileField& field, const std::vector<double>& means) {
    const std::size_t kinds = std::size_t(field.materials), voxels = field.voxelCount();
    constexpr std::size_t kGrain = 1 << 16;
    constexpr int kMostRounds = 50;
    double voidMean = 1;
    for (double m : means) {
        voidMean -= m;
    }
    double worst = 0;
    for (int round = 0; round < kMostRounds; ++round) {
        const std::vector<double> now = meanFractions(field);
        std::vector<double> scale(kinds + 1, 1.0);
        double voidNow = 1;
        worst = 0;
        for (std::size_t m = 0; m < kinds; ++m) {
            voidNow -= now[m];
            worst = std::max(worst, std::abs(now[m] - means[m]));
            scale[m] = now[m] > 0 ? means[m] / now[m] : 1;
        }
        worst = std::max(worst, std::abs(voidNow - voidMean));
        scale[kinds] = voidNow > 1e-12 ? std::max(0.0, voidMean) / voidNow : 1;
        if (worst < 1e-6) {
            break;
        }
        parallelFor(voxels, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                float* const f = field.fractions.data() + i * kinds;
                double sum = 0, total = 0;
                for (std::size_t m = 0; m < kinds; ++m) {
                    sum += double(f[m]);
                    total += double(f[m]) * scale[m];
                }
                total += std::max(0.0, 1 - sum) * scale[kinds];
                for (std::size_t m = 0; total > 0 && m < kinds; ++m) {
                    f[m] = float(double(f[m]) * scale[m] / total);
                }
            }
        });
    }
    return worst;
}

TileField blendSides(const TileField& field, const Vec3i& overlap) {
    TileField tile = blendAxis(blendAxis(field, 0, overlap.x), 1, overlap.y);
    fitMeans(tile, meanFractions(field));
    return tile;
}

} // namespace stf
