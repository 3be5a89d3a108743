// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/synthesis/exemplar_map.h"
#include "stfLib/volume/base_volume.h"

namespace stf {

enum class Mapping {
    Uv,         ///< plain tiling by texture coordinates
    Synthesize, ///< by-example synthesis
    Blend,      ///< overlapping places of a random sample, blended (blend_map.h)
    Anywhere    ///< the sample is the same everywhere: any coordinates do
};

struct MappingChoice {
    Mapping mapping;
    std::string why; ///< half a sentence, for the plan
};

/// What `primvars:stf:mapping` (auto, uv, synthesize, blend) means for a surface and a sample. `auto` takes texture
/// coordinates where they are usable: given, of an area, and neither collapsed nor stretched beyond use on more than a
/// twentieth of the surface; else a sample that is random is blended, and any other synthesised. A sample that cannot
/// be blended (a relief, emission) is synthesised although `blend` asks. Texture coordinates that were asked for by
/// `uv` are taken as they are.
MappingChoice chooseMapping(const std::string& mapping, const RefinedSurface& surface, const BaseVolume& volume);

/// Coordinates for a sample that is the same everywhere: each triangle has its own, isometric.
ExemplarMap mapAnywhere(const RefinedSurface& surface, const Vec2d& tileMm, double unitsPerMm);

} // namespace stf
