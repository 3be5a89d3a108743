// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/mesh_shape.h"

#include <algorithm>
#include <cmath>

namespace stf {

MeshShape::MeshShape(std::shared_ptr<const RefinedSurface> surface, const Transform& toFrame)
    : surface_(std::move(surface)), toFrame_(toFrame) {
    cumulative_.reserve(surface_->triangles.size());
    for (const Vec3i& t : surface_->triangles) {
        const auto corner = [&](int i) { return Vec3d(surface_->points[std::size_t(i)]); };
        const Vec3d a = corner(t.x);
        const Vec3d across = cross(toFrame_.vector(corner(t.y) - a), toFrame_.vector(corner(t.z) - a));
        area_ += 0.5 * length(across);
        cumulative_.push_back(area_);
        for (int c = 0; c < 3; ++c) {
            bounds_.add(Vec3f(toFrame_.point(corner(t[c]))));
        }
    }
}

ShapeSample MeshShape::sample(const Vec3f& from, Vec2f u) const {
    ShapeSample s;
    if (!(area_ > 0)) {
        return s;
    }
    const double at = double(u.x) * area_;
    const auto it = std::min(std::upper_bound(cumulative_.begin(), cumulative_.end(), at), cumulative_.end() - 1);
    const double before = it == cumulative_.begin() ? 0.0 : *(it - 1), share = *it - before;
    if (!(share > 0)) {
        return s;
    }
    const Vec3i& t = surface_->triangles[std::size_t(it - cumulative_.begin())];
    // What is left of the number is as good as a new one.
    const double left = std::clamp((at - before) / share, 0.0, 1.0), r = std::sqrt(left), v = double(u.y);
    const auto corner = [&](int i) { return toFrame_.point(Vec3d(surface_->points[std::size_t(i)])); };
    const Vec3d a = corner(t.x), b = corner(t.y), c = corner(t.z);
    const Vec3d d = a * (1 - r) + b * (r * (1 - v)) + c * (r * v) - Vec3d(from);
    const double square = dot(d, d), across = length(cross(b - a, c - a));
    if (!(square > 0) || !(across > 0)) {
        return s;
    }
    const double distance = std::sqrt(square);
    const double cosine = dot(cross(b - a, c - a), d) / (across * distance);
    s.towards = Vec3f(d / distance);
    s.distance = float(distance);
    s.solidAngle = solidAngle(s.distance, float(cosine));
    return s;
}

} // namespace stf
