// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/transform.h"

namespace stf {

bool Transform::invertible() const {
    if (!isFinite(x) || !isFinite(y) || !isFinite(z) || !isFinite(translation)) {
        return false;
    }
    // Relative to the lengths of the columns, so that a scene scale of 1e-6 is no singularity.
    const double scale = length(x) * length(y) * length(z);
    return scale > 0 && std::abs(determinant()) > 1e-12 * scale;
}

Transform Transform::inverse() const {
    const double d = 1.0 / determinant();
    const Vec3d r0 = cross(y, z) * d, r1 = cross(z, x) * d, r2 = cross(x, y) * d;
    Transform t;
    t.x = {r0.x, r1.x, r2.x};
    t.y = {r0.y, r1.y, r2.y};
    t.z = {r0.z, r1.z, r2.z};
    t.translation = -t.vector(translation);
    return t;
}

Vec3d Transform::normal(const Vec3d& n) const {
    const double s = determinant() < 0 ? -1.0 : 1.0;
    return (cross(y, z) * n.x + cross(z, x) * n.y + cross(x, y) * n.z) * s;
}

Transform Transform::fromRowMajor(const double m[16]) {
    Transform t;
    t.x = {m[0], m[1], m[2]};
    t.y = {m[4], m[5], m[6]};
    t.z = {m[8], m[9], m[10]};
    t.translation = {m[12], m[13], m[14]};
    return t;
}

Transform compose(const Transform& b, const Transform& a) {
    Transform t;
    t.x = b.vector(a.x);
    t.y = b.vector(a.y);
    t.z = b.vector(a.z);
    t.translation = b.point(a.translation);
    return t;
}

} // namespace stf
