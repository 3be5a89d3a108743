// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/read_noise.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"

namespace stf {

namespace {
constexpr int kPairs = 5;
}

ReadGroups readGroups(const TileMedium& medium, const std::vector<GroupResult>& groups, int components,
                      const LateralFilter& filter) {
    const Vec3i& size = medium.size();
    const std::size_t layer = std::size_t(size.x) * std::size_t(size.y);
    std::vector<int> pairs;
    const int last = std::max(0, size.z - 2);
    const int count = layer == 1 ? last + 1 : std::min(kPairs, last + 1);
    for (int i = 0; i < count; ++i) {
        pairs.push_back(count > 1 ? int(std::lround(double(i) / (count - 1) * last)) : 0);
    }
    ReadGroups out;
    out.read.resize(groups.size());
    out.voxels.resize(groups.size());
    parallelFor(groups.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            std::vector<float>& values = out.read[g];
            for (std::size_t p = 0; p < pairs.size(); ++p) {
                std::vector<float> pair[2], fill[2];
                for (int k = 0; k < 2; ++k) {
                    const std::size_t z = std::size_t(std::min(pairs[p] + k, size.z - 1));
                    for (std::size_t i = 0; i < layer; ++i) {
                        const float* const v = groups[g].field.data() + (z * layer + i) * std::size_t(components);
                        pair[k].insert(pair[k].end(), v, v + 3);
                        fill[k].push_back(medium.fill(z * layer + i));
                    }
                    filter.applyLayer(pair[k].data(), 3, medium.hasSurface() ? fill[k].data() : nullptr);
                }
                out.voxels[g].insert(out.voxels[g].end(), pair[0].begin(), pair[0].end());
                CounterRng rng(0x72656164, p);
                for (int y = 0; y < size.y; ++y) {
                    for (int x = 0; x < size.x; ++x) {
                        const float u = rng.uniform(), v = rng.uniform(), w = rng.uniform();
                        const int x1 = (x + 1) % size.x, y1 = (y + 1) % size.y;
                        for (int c = 0; c < 3; ++c) {
                            const auto at = [&](int k, int ix, int iy) {
                                return pair[k][std::size_t(ix + size.x * iy) * 3 + std::size_t(c)];
                            };
                            const auto flat = [&](int k) {
                                return (1 - v) * ((1 - u) * at(k, x, y) + u * at(k, x1, y)) +
                                       v * ((1 - u) * at(k, x, y1) + u * at(k, x1, y1));
                            };
                            values.push_back((1 - w) * flat(0) + w * flat(1));
                        }
                    }
                }
            }
        }
    });
    return out;
}

} // namespace stf
