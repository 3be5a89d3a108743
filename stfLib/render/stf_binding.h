// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <optional>
#include <string>

namespace stf {

/// How a base volume is bound to a mesh: the properties of StfShellAPI with the schema's defaults.
struct StfBinding {
    std::string baseVolume;   ///< resolved path of the .vdb
    std::string authoredPath; ///< as the scene names it, for messages
    float thickness = 0;      ///< object units; 0: the sample's own depth times scale
    float scale = 1;
    std::string mapping = "auto";
    std::string coreMaterial;           ///< a name in the table of materials (optics/property_table.h); empty: none
    std::optional<Rgb> coreSigmaA;      ///< 1/mm
    std::optional<Rgb> coreSigmaSPrime; ///< 1/mm
    std::string coreModel = "auto";
    std::string transport; ///< form of the tables: dE1, classic; empty: the render setting says
    float quality = 0;     ///< target relative error of the tables; 0: the render setting says
    int seed = 0;

    bool operator==(const StfBinding& b) const {
        return baseVolume == b.baseVolume && authoredPath == b.authoredPath && thickness == b.thickness &&
               scale == b.scale && mapping == b.mapping && coreMaterial == b.coreMaterial &&
               coreSigmaA == b.coreSigmaA && coreSigmaSPrime == b.coreSigmaSPrime && coreModel == b.coreModel &&
               transport == b.transport && quality == b.quality && seed == b.seed;
    }
    bool operator!=(const StfBinding& b) const { return !(*this == b); }
};

} // namespace stf
