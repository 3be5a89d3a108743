// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/triangulate_face.h"

#include <utility>

namespace stf {

namespace {

double turn(Vec2d a, Vec2d b, Vec2d c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

void fan(int count, std::vector<Vec3i>& out) {
    for (int i = 1; i + 1 < count; ++i) {
        out.push_back({0, i, i + 1});
    }
}

/// Corners in the plane of the polygon's mean (Newell) normal; false where that is zero.
bool project(const std::vector<Vec3d>& corners, std::vector<Vec2d>& flat) {
    Vec3d normal, centre;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        normal += cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
    }
    if (!(length(normal) > 0)) {
        return false;
    }
    Vec3d t, b;
    orthonormalBasis(normalize(normal), t, b);
    flat.clear();
    flat.reserve(corners.size());
    for (const Vec3d& p : corners) {
        flat.push_back({dot(p - corners[0], t), dot(p - corners[0], b)});
    }
    return true;
}

bool inside(Vec2d a, Vec2d b, Vec2d c, Vec2d p) {
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

void clipEars(const std::vector<Vec2d>& p, std::vector<Vec3i>& out) {
    std::vector<int> ring(p.size());
    for (std::size_t i = 0; i < ring.size(); ++i) {
        ring[i] = int(i);
    }
    const auto at = [&](std::size_t i) { return p[std::size_t(ring[i % ring.size()])]; };
    std::size_t i = 0, failed = 0;
    while (ring.size() > 3) {
        const std::size_t n = ring.size();
        const Vec2d a = at(i + n - 1), b = at(i), c = at(i + 1);
        bool ear = turn(a, b, c) > 0;
        for (std::size_t k = i + 2; ear && k < i + n - 1; ++k) {
            // Only reflex corners can lie inside; corners that coincide with one of the ear's do not count.
            const Vec2d q = at(k);
            ear = turn(at(k - 1), q, at(k + 1)) > 0 || q == a || q == b || q == c || !inside(a, b, c, q);
        }
        // After a full round without an ear the polygon crosses itself: cut anything, to come to an end.
        if (ear || failed >= n) {
            out.push_back({ring[(i + n - 1) % n], ring[i % n], ring[(i + 1) % n]});
            ring.erase(ring.begin() + std::ptrdiff_t(i % n));
            failed = 0;
            i = i % ring.size();
        } else {
            ++failed;
            i = (i + 1) % n;
        }
    }
    out.push_back({ring[0], ring[1], ring[2]});
}

} // namespace

void triangulateFace(const std::vector<Vec3d>& corners, std::vector<Vec3i>& out) {
    const int count = int(corners.size());
    std::vector<Vec2d> p;
    if (count == 3 || !project(corners, p)) {
        return fan(count, out);
    }
    if (count == 4) {
        const bool first = turn(p[0], p[1], p[2]) > 0 && turn(p[0], p[2], p[3]) > 0;
        const bool second = turn(p[0], p[1], p[3]) > 0 && turn(p[1], p[2], p[3]) > 0;
        const double d02 = length(corners[2] - corners[0]), d13 = length(corners[3] - corners[1]);
        // A little in favour of the first, so that rounding does not mix diagonals over a regular grid.
        if (second && (!first || d13 < d02 * (1 - 1e-5))) {
            out.push_back({0, 1, 3});
            out.push_back({1, 2, 3});
        } else {
            fan(4, out);
        }
        return;
    }
    bool convex = true;
    for (std::size_t i = 0; i < p.size(); ++i) {
        convex = convex && turn(p[i], p[(i + 1) % p.size()], p[(i + 2) % p.size()]) >= 0;
    }
    // Ear clipping is quadratic; polygons beyond this size are data errors rather than shapes.
    if (convex || count > 5000) {
        return fan(count, out);
    }
    clipEars(p, out);
}

} // namespace stf
