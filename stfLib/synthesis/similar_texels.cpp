// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/similar_texels.h"

#include "stfLib/base/parallel.h"

#include <algorithm>
#include <cmath>
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#endif
#include <nanoflann.hpp>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace stf {

namespace {

/// The image as nanoflann asks for it.
struct Cloud {
    const AppearanceImage& image;
    std::size_t kdtree_get_point_count() const { return image.texels.size(); }
    float kdtree_get_pt(std::size_t i, std::size_t d) const { return image.texels[i][d]; }
    template<class Box>
    bool kdtree_get_bbox(Box&) const {
        return false;
    }
};
using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>, Cloud,
                                                 AppearanceImage::dims, std::size_t>;

int apart(int a, int b, int n) {
    const int d = std::abs(a - b);
    return std::min(d, n - d);
}

} // namespace

std::vector<int> similarTexels(const AppearanceImage& image, int k) {
    const std::size_t texels = image.texels.size();
    const int spacing = std::clamp(std::min(image.width, image.height) / 20, 4, 8);
    // Within the spacing lie about pi spacing^2 texels per place.
    const std::size_t asked = std::min(texels, std::size_t(12 * k + 3 * spacing * spacing));
    const Cloud cloud{image};
    const Tree tree(AppearanceImage::dims, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16));
    std::vector<int> similar(texels * std::size_t(k));
    parallelFor(texels, 256, [&](std::size_t begin, std::size_t end) {
        std::vector<std::size_t> index(asked);
        std::vector<float> distance(asked);
        std::vector<std::pair<float, std::size_t>> order;
        for (std::size_t t = begin; t < end; ++t) {
            const std::size_t found = tree.knnSearch(image.texels[t].data(), asked, index.data(), distance.data());
            order.clear();
            for (std::size_t i = 0; i < found; ++i) {
                order.push_back({distance[i], index[i]});
            }
            std::sort(order.begin(), order.end()); // ties by number
            int* out = &similar[t * std::size_t(k)];
            int taken = 0;
            for (const auto& [d, i] : order) {
                const auto near = [&](int other) {
                    const int w = image.width;
                    return apart(int(i) % w, other % w, w) < spacing &&
                           apart(int(i) / w, other / w, image.height) < spacing;
                };
                if (taken < k && !near(int(t)) && std::none_of(out, out + taken, near)) {
                    out[taken++] = int(i);
                }
            }
            std::fill(out + taken, out + k, int(t));
        }
    });
    return similar;
}

double ownNeighbourhoodError(const AppearanceImage& image, const std::vector<int>& similar, int k) {
    const int w = image.width;
    double sum = 0;
    for (std::size_t t = 0; t < image.texels.size(); ++t) {
        const int x = int(t) % w, y = int(t) / w;
        float best = 1e30f;
        for (int i = 0; i < k; ++i) {
            const int s = similar[t * std::size_t(k) + std::size_t(i)];
            if (s == int(t)) {
                continue;
            }
            float d = 0;
            for (int n = 0; n < 9; ++n) {
                const int dx = n % 3 - 1, dy = n / 3 - 1;
                d += squaredDistance(image.at(x + dx, y + dy), image.at(s % w + dx, s / w + dy)) / 9;
            }
            best = std::min(best, d);
        }
        sum += best < 1e30f ? double(best) : 0.0;
    }
    return image.texels.empty() ? 0 : std::sqrt(sum / double(image.texels.size()));
}

} // namespace stf
