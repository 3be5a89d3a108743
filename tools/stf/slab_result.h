// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/stf/slab_options.h"

#include <cstdint>
#include <string>
#include <vector>

namespace stf {

/// Fluence at a depth, each with its standard error. Per unit of perpendicular irradiance outside, or of irradiance on
/// the top where the light is diffuse; I_b per unit of radiance that enters through an index-matched bottom, over 2 pi.
struct SlabProfileRow {
    double depth = 0;                                        ///< optical depth of the true medium
    double single = 0, multiple = 0, backlight = 0;          ///< I_s, I_m, I_b / (2 pi)
    double singleError = 0, sumError = 0, multipleError = 0; ///< of I_s, I_s + I_m, I_m
    double backlightError = 0;
};

/// What a slab does to light, as fractions of the incident flux.
struct SlabResult {
    double r = 0, specular = 0, rError = 0;
    double t = 0, unscattered = 0, tError = 0;
    double a = 0, aError = 0;
    std::uint64_t photons = 0, collisions = 0, lost = 0;
    double seconds = 0;
    double coreDepth = 0;           ///< optical depth that stood for a half-infinite core; 0 without or where not cut
    std::vector<std::string> notes; ///< what the reader should know of how it was computed
    std::vector<SlabProfileRow> profile;
    struct View {
        double mu = 0, factor = 0, error = 0; ///< pi radiance over incident flux; no mirror image of parallel light
    };
    // Of --method stf.
    std::vector<View> view;
    int layers = 0;        ///< of the tile
    double tableError = 0; ///< estimated, relative
};

/// One line of JSON with the fields of the project's contract, and a few more.
std::string slabJson(const SlabOptions& options, const SlabResult& result);
/// A small table to read.
std::string slabText(const SlabOptions& options, const SlabResult& result);

} // namespace stf
