// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/shell_mapping.h"

namespace stf {

/// The last stages of a shell: inner boundary and grid at rest, and the pose in which it is seen with its ray mesh.
class ShellGeometries {
public:
    /// Fills surface, boundary, map, grid, pose and ray mesh of a shell that has its volumes, scale and thickness.
    /// Throws Error, Cancelled.
    void prepare(const MappedSurface& mapped, const ShellStage& stage, ShellObject& shell);
    void dropUnused();

private:
    struct Gridded {
        std::shared_ptr<const RefinedSurface> surface;
        std::shared_ptr<const ShellBoundary> boundary;
        std::shared_ptr<const ShellGrid> grid;
    };
    struct Seen {
        std::shared_ptr<const ShellBoundary> boundary;
        std::shared_ptr<const PosedShell> pose;
        std::shared_ptr<const RayMesh> rayMesh;
    };
    std::shared_ptr<const Gridded> makeGrid(const MappedSurface& mapped, const ShellObject& shell,
                                            const ShellStage& stage) const;
    Seen makeSeen(const MappedSurface& mapped, const Gridded& gridded, float thickness);

    StageCache<Gridded> gridded_;
    StageCache<Seen> seen_;
    StageCache<PosedShell::Neighbours> neighbours_;
};

} // namespace stf
