// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/shell/shell_grid.h"

#include <memory>

namespace stf {

/// The inner boundary of a surface in a pose: `offsetInward` there, but nowhere deeper than `rest`, the boundary in the
/// rest pose, since the grid holds no more.
ShellBoundary offsetPosed(const RefinedSurface& posed, float thickness, const ShellBoundary& rest);

/// A shell that is gridded in its rest pose and seen in another. A point belongs to the prism between a triangle and
/// its inner boundary that holds it; the same place of the same prism at rest is where the grid is asked: what a point
/// of the body shows does not depend on the pose, and nothing but points moves from frame to frame. Prisms are found by
/// walking from triangle to triangle, from the one where a ray entered. Immutable; any number of threads.
class PosedShell {
public:
    /// A surface with its boundary; both stay as they are.
    struct Shape {
        std::shared_ptr<const RefinedSurface> surface;
        std::shared_ptr<const ShellBoundary> boundary;
    };
    /// Per triangle: the triangle beyond the edge from corner c to the next; -1: none, or several.
    using Neighbours = std::vector<Vec3i>;
    static Neighbours neighboursOf(const RefinedSurface& surface);

    /// Shapes with the same triangles. Throws Error if they have not.
    PosedShell(Shape rest, Shape posed, std::shared_ptr<const Neighbours> neighbours);

    /// A place within the shell: barycentric coordinates of a triangle and the depth (object units).
    struct Place {
        std::uint32_t triangle = 0;
        double b1 = 1.0 / 3, b2 = 1.0 / 3, depth = 0;
    };
    /// Finds a point of the posed shell, `place` being one nearby. False outside, where the shell folds over itself, or
    /// where no way leads there; `place` is then as it was.
    bool locate(const Vec3f& posedPoint, Place& place) const;
    /// The surface at rest.
    const RefinedSurface& atRest() const { return *rest_.surface; }
    /// The point at rest.
    Vec3f atRest(const Place& place) const;
    /// Turns what a lookup at rest gave into that of the pose: gradients are carried with the material, the normal is
    /// that of the posed surface. The rest stays.
    void carry(const Place& place, ShellLookup& lookup) const;

private:
    Shape rest_, posed_;
    std::shared_ptr<const Neighbours> neighbours_;
};

/// What a shell shows at points in it, in whatever pose it is. One per thread.
class ShellProbe {
public:
    /// `pose` null: the grid is in the pose that is seen, that of `surface`.
    ShellProbe(const ShellGrid& grid, const RefinedSurface& surface, const PosedShell* pose)
        : accessor_(grid), surface_(pose ? pose->atRest() : surface), pose_(pose) {}
    /// The points asked for next begin near that triangle of the surface; beside hard edges they stay on its side.
    void enter(std::uint32_t triangle);
    /// See ShellGrid::Accessor::lookup.
    bool lookup(const Vec3f& objectPoint, ShellLookup& out, const Rgb* core = nullptr, int level = 0);
    /// Asks for the memory of a lookup that comes soon; nothing in a pose, where it is not known yet where.
    void prefetch(const Vec3f& objectPoint, int level) {
        if (!pose_) {
            accessor_.prefetch(objectPoint, level);
        }
    }

private:
    ShellGrid::Accessor accessor_;
    const RefinedSurface& surface_; ///< in the grid's pose
    const PosedShell* pose_;
    PosedShell::Place place_;
};

} // namespace stf
