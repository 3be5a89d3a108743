// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

namespace stf {

/// An affine map in double precision: p -> linear * p + translation, columns of `linear` in x, y, z.
struct Transform {
    Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, translation{0, 0, 0};

    Vec3d vector(const Vec3d& v) const { return x * v.x + y * v.y + z * v.z; }
    Vec3d point(const Vec3d& p) const { return vector(p) + translation; }
    double determinant() const { return dot(x, cross(y, z)); }
    /// False for a singular or non-finite map: such an object has no volume and cannot be rendered.
    bool invertible() const;
    /// The inverse map. Undefined unless `invertible()`.
    Transform inverse() const;
    /// A normal (covector) goes by the inverse transpose; not normalised.
    Vec3d normal(const Vec3d& n) const;
    /// The transpose: a normal goes back by it, from where the map leads to. Not normalised.
    Vec3d transposed(const Vec3d& n) const { return {dot(x, n), dot(y, n), dot(z, n)}; }
    bool operator==(const Transform& t) const {
        return x == t.x && y == t.y && z == t.z && translation == t.translation;
    }
    /// Row-major 4x4 with row vectors (p' = p M), as OpenUSD stores it.
    static Transform fromRowMajor(const double m[16]);
};

/// First a, then b.
Transform compose(const Transform& b, const Transform& a);

} // namespace stf
