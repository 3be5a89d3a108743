// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/periodicity.h"

#include "stfLib/base/parallel.h"

namespace stf {

namespace {

// Mean content difference of the pairs (i, i + 1) for i in [first, last) along an axis, wrapped.
double meanDifference(const TileField& f, int axis, int first, int last) {
    std::vector<double> layers(std::size_t(f.size.z), 0.0);
    parallelFor(layers.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t z = begin; z < end; ++z) {
            Vec3i lo(0, 0, int(z)), hi(f.size.x, f.size.y, int(z) + 1);
            lo[axis] = first;
            hi[axis] = last;
            for (int y = lo.y; y < hi.y; ++y) {
                for (int x = lo.x; x < hi.x; ++x) {
                    Vec3i next(x, y, int(z));
                    next[axis] = (next[axis] + 1) % f.size[axis];
                    layers[z] += double(contentDifference(f.at(f.index(x, y, int(z))),
                                                          f.at(f.index(next.x, next.y, next.z)), f.materials));
                }
            }
        }
    });
    double sum = 0;
    for (double s : layers) {
        sum += s;
    }
    const double pairs = double(last - first) * f.size[1 - axis] * f.size.z;
    return pairs > 0 ? sum / pairs : 0;
}

double ratio(const TileField& f, int axis) {
    const double wrap = meanDifference(f, axis, f.size[axis] - 1, f.size[axis]);
    const double inside = neighbourDifference(f, axis);
    return wrap > 0 ? wrap / std::max(inside, 1e-12) : 0;
}

} // namespace

double neighbourDifference(const TileField& field, int axis) {
    return meanDifference(field, axis, 0, field.size[axis] - 1);
}

PeriodicityError periodicityError(const TileField& field) {
    return {ratio(field, 0), ratio(field, 1)};
}

} // namespace stf
