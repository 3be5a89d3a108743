// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/optics/property_table.h"

#include <string>
#include <vector>

namespace stf {

/// What `stf materials` tells of a material.
struct MaterialRow {
    std::string name; ///< with its table
    Material material;
    Vec3d albedo{0, 0, 0};         ///< of the true coefficients
    Vec3d reflectance{0, 0, 0};    ///< optics/semi_infinite.h
    Vec3d meanFreePathMm{0, 0, 0}; ///< 1 / sigma_t'
    Vec3d diffusionLengthMm{0, 0, 0};
};
MaterialRow rowOf(const std::string& name, const Material& material);

/// A PNG of swatches: each material as a patch of its diffuse reflectance, and how far light spreads from an edge of
/// shadow, to one scale for all. Throws std::runtime_error.
void writeMaterialsSheet(const std::vector<MaterialRow>& rows, const std::string& path);

} // namespace stf
