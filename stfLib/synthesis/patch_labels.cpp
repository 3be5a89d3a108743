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

} // namespace stf
