// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/reference/reference_medium.h"
#include "stfLib/shell/posed_shell.h"

namespace stf {

/// Where points of a shell (object space) lie in its sample. One per thread and shell: it remembers the last point.
class ShellSpace {
public:
    /// `pose` null: the surface is the grid's own.
    ShellSpace(const ShellGrid& grid, const RefinedSurface& surface, const PosedShell* pose, float mmPerUnit)
        : probe_(grid, surface, pose), mmPerUnit_(mmPerUnit) {}

    /// The points to come begin near that triangle of the surface.
    void enter(std::uint32_t triangle) {
        probe_.enter(triangle);
        at_.triangle = triangle;
        known_ = false;
    }
    /// Tile millimetres of a point. Where the grid holds nothing, the last point's place is carried on to first order;
    /// false where there is none.
    bool locate(const Vec3f& point, Vec3f& mm);
    /// Whether `locate` has found anything since `enter`, and the limit surface's normal (unit) there.
    bool known() const { return known_; }
    const Vec3f& normal() const { return at_.normal; }
    /// The triangle of the surface above the last point.
    std::uint32_t triangle() const { return at_.triangle; }
    /// The normal (unit, object space, outward) of a surface of the tile at the last point, by the gradient of its
    /// distance along x, y and the depth.
    Vec3f normalOf(const Vec3f& gradient) const {
        return normalize(at_.gradX * gradient.x + at_.gradY * gradient.y - at_.normal * (gradient.z * mmPerUnit_));
    }
    /// Tile mm per object unit at the last point: the most by which the tile is squeezed there, at least mmPerUnit.
    float squeeze() const { return std::max(mmPerUnit_, std::max(length(at_.gradX), length(at_.gradY))); }

private:
    ShellProbe probe_;
    float mmPerUnit_;
    ShellLookup at_{};
    Vec3f point_;
    bool known_ = false;
};

} // namespace stf
