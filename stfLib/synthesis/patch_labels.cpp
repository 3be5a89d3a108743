// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/patch_labels.h"

#include <cmath>

namespace stf {

Vec2f nearestImage(const Vec2f& d, const Vec2d& tileMm) {
    const float tx = float(tileMm.x), ty = float(tileMm.y);
    return {d.x - tx * std::nearbyint(d.x / tx), d.y - ty * std::nearbyint(d.y / ty)};
}

Vec2f continued(const ChartCover& cover, const PatchLabels& labels, std::size_t u, std::size_t v, const Vec2f& step) {
    const int e = cover.entryAt(int(v), cover.chart[std::size_t(labels.entry[u])]);
    return e >= 0 ? cover.coord[std::size_t(e)] + labels.offset[u] : labels.coord(cover, u) + step;
}

float breakAcross(const ChartCover& cover, const PatchLabels& labels, const Vec2d& tileMm, std::size_t u, std::size_t v,
                  const Vec2f& step) {
    if (cover.chart[std::size_t(labels.entry[u])] == cover.chart[std::size_t(labels.entry[v])] &&
        labels.offset[u] == labels.offset[v]) {
        return 0;
    }
    const Vec2f there = nearestImage(continued(cover, labels, u, v, step) - labels.coord(cover, v), tileMm);
    const Vec2f back =
        nearestImage(continued(cover, labels, v, u, step * -1.0f) - labels.coord(cover, u), tileMm);
    return std::sqrt(std::min(there.x * there.x + there.y * there.y, back.x * back.x + back.y * back.y));
}

} // namespace stf
