// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/core/core_response.h"
#include "stfLib/render/exactness.h"
#include "stfLib/render/tile_pyramid.h"
#include "stfLib/shell/posed_shell.h"
#include "stfLib/surface/ray_scene.h"
#include "stfLib/synthesis/blend_map.h"
#include "stfLib/transport/histogram_blend.h"
#include "stfLib/transport/stf_table.h"
#include "stfLib/transport/tile_medium.h"
#include "stfLib/volume/base_volume.h"

#include <memory>
#include <vector>

namespace stf {

/// A mesh with a bound base volume, ready to be marched. Immutable once made; shells of equal meshes share their parts.
struct ShellObject {
    std::shared_ptr<const BaseVolume> source; ///< as read from its file
    std::shared_ptr<const BaseVolume> volume; ///< cropped to the shell's depth; `source` where that is all of it
    std::shared_ptr<const BaseVolume> lit;    ///< what `table` and `medium` are made of: `volume`, perhaps subdivided
    std::shared_ptr<const StfTable> table;
    std::shared_ptr<const TileMedium> medium;                  ///< of the table's form
    std::shared_ptr<const RefinedSurface> surface;             ///< as it is seen
    std::shared_ptr<const ShellBoundary> boundary;             ///< as it is seen
    std::shared_ptr<const ExemplarMap> map;                    ///< of the rest pose, where there is one
    std::shared_ptr<const BlendMap> blend;                     ///< which places points show besides; null: none
    std::shared_ptr<const TilePyramid> pyramid;                ///< medium and table for pixels of any footprint
    std::vector<std::shared_ptr<const HistogramBlend>> mixers; ///< of each of its levels, where there is a blend
    std::shared_ptr<const ShellGrid> grid;                     ///< of the rest pose, where there is one
    std::shared_ptr<const PosedShell> pose; ///< from what is seen to the rest pose; null: that is what is seen
    std::shared_ptr<const RayMesh> rayMesh;
    std::vector<std::shared_ptr<const void>> stages; ///< what else it was made from: kept in memory with it
    CoreMaterial core;
    CoreModel coreModel = CoreModel::Auto;
    bool coreBlack = true;
    Exactness exact;
    float mmPerUnit = 1; ///< tile millimetres per object unit
    float thicknessMm = 0;
    float blurRadiusMm = 0; ///< over which visibility is averaged for multiple scattering (DESIGN 3.12)

    /// By which a pixel of this width chooses the levels of grid and sample that it reads.
    float levelFootprint(float footprintMm) const { return exact.levels ? 0.0f : footprintMm; }
    /// Of a march at a level of the grid, object units.
    float marchStep(int level) const { return grid->voxelSize(level) * (exact.step ? 0.25f : 1.0f); }
};

} // namespace stf
