// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shell_geometry.h"

#include <cstdio>

namespace stf {

namespace {
constexpr double kSeamTexels = 0.3; ///< wanted mean displacement of seams by the shell grid
}

std::shared_ptr<const ShellGeometries::Gridded>
ShellGeometries::makeGrid(const MappedSurface& mapped, const ShellObject& o, const ShellStage& stage) const {
    const float thickness = o.thicknessMm / o.mmPerUnit;
    auto made = std::make_shared<Gridded>();
    made->surface = mapped.surface;
    auto boundary = std::make_shared<const ShellBoundary>(offsetInward(*mapped.surface, thickness, stage.messages));
    ShellGridOptions options;
    options.mmPerUnit = double(o.mmPerUnit);
    options.texelMm = std::min(o.volume->voxelMm.x, o.volume->voxelMm.y);
    if (mapped.choice->mapping == Mapping::Synthesize) {
        // Seams run where they are least seen, to a texel: the grid must not move them by more.
        options.seamTexels = kSeamTexels;
    } else if (mapped.choice->mapping == Mapping::Anywhere) {
        options.voxelSize = 0.25f * thickness; // coordinates do not matter, only the depth
    }
    made->grid = std::make_shared<const ShellGrid>(
        ShellGrid::build(*mapped.surface, *boundary, *mapped.map, options, stage.progress, stage.messages));
    made->boundary = std::move(boundary);
    ++stage.stats.grids;
    return made;
}

ShellGeometries::Seen ShellGeometries::makeSeen(const MappedSurface& mapped, const Gridded& gridded, float thickness) {
    Seen seen;
    const RefinedSurface& surface = mapped.posed ? *mapped.posed : *mapped.surface;
    seen.boundary = gridded.boundary;
    if (mapped.posed) {
        seen.boundary = std::make_shared<const ShellBoundary>(offsetPosed(surface, thickness, *gridded.boundary));
        auto neighbours = neighbours_.find(mapped.key);
        if (!neighbours) {
            neighbours = neighbours_.keep(mapped.key, PosedShell::neighboursOf(*mapped.surface));
        }
        seen.pose = std::make_shared<const PosedShell>(PosedShell::Shape{gridded.surface, gridded.boundary},
                                                       PosedShell::Shape{mapped.posed, seen.boundary}, neighbours);
    }
    seen.rayMesh = std::make_shared<const RayMesh>(surface.points, surface.triangles, seen.boundary->inner);
    return seen;
}

void ShellGeometries::prepare(const MappedSurface& mapped, const ShellStage& stage, ShellObject& o) {
    const StageTimer timer;
    const float thickness = o.thicknessMm / o.mmPerUnit;
    char text[40];
    std::snprintf(text, sizeof text, ";thickness=%.9g", double(thickness));
    const std::string gridKey = mapped.key + text;
    std::shared_ptr<const Gridded> gridded = gridded_.find(gridKey);
    const bool kept = gridded != nullptr;
    if (!kept) {
        // The one before goes first, rather than both being in memory at once.
        seen_.dropUnused();
        gridded_.dropUnused();
        gridded = gridded_.keep(gridKey, makeGrid(mapped, o, stage));
    }
    const std::string seenKey = gridKey + ";" + mapped.poseKey;
    std::shared_ptr<const Seen> seen = seen_.find(seenKey);
    if (!seen) {
        seen_.dropUnused();
        seen = seen_.keep(seenKey, makeSeen(mapped, *gridded, thickness));
    }
    o.surface = mapped.posed ? mapped.posed : mapped.surface;
    o.boundary = seen->boundary;
    o.map = mapped.map;
    o.blend = mapped.blend;
    o.grid = gridded->grid;
    o.pose = seen->pose;
    o.rayMesh = seen->rayMesh;
    o.stages = {mapped.choice, mapped.surface, gridded, seen};
    stage.stats.shellSeconds += timer.seconds();
    stage.noteKept("shell", kept,
                   std::to_string(o.grid->sampleCount()) + " samples in " + std::to_string(o.grid->levelCount()) +
                       " levels",
                   timer.seconds());
}

void ShellGeometries::dropUnused() {
    seen_.dropUnused();
    gridded_.dropUnused();
    neighbours_.dropUnused();
}

} // namespace stf
