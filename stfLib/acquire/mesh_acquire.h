// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_reader.h"
#include "stfLib/acquire/mesh_recipe.h"
#include "stfLib/acquire/mesh_repair.h"
#include "stfLib/base/progress.h"
#include "stfLib/volume/base_volume.h"

namespace stf {

/// What became of one mesh of a recipe; a file whose parts have materials of their own gives one of each.
struct AcquiredMesh {
    std::string label, material;
    MeshRepair repair;
    std::size_t copies = 1;
    double volumeMm3 = 0; ///< of all copies, by the divergence theorem; overlaps and what lies outside counted
};

struct AcquiredShare {
    std::string material;
    double share = 0; ///< of the tile's volume
};

struct MeshAcquisition {
    BaseVolume volume;
    std::vector<AcquiredMesh> meshes;
    std::vector<AcquiredShare> shares; ///< what is missing to 1 is outside
};

/// Scan-converts the meshes of a recipe into a base volume. Voids without a surface are voxels of less extinction; with
/// one, and below a relief or in a body, `surface` says where material is and voxels that it cuts hold the coefficients
/// of what is inside. `messages` hears of what was repaired and of what an artist may not have meant. Throws Error with
/// the mesh or key that is to blame, also where more than `maxBytes` of memory would be needed.
MeshAcquisition acquireMesh(const MeshRecipe& recipe, const MeshReader& reader, double maxBytes, Progress& progress,
                            const MessageSink& messages);

} // namespace stf
