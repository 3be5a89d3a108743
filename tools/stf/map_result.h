// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"
#include "tools/stf/map_options.h"

#include <cstdint>
#include <string>
#include <vector>

namespace stf {

/// A number with its standard error, for each channel.
struct Measured {
    Vec3d value{0, 0, 0}, error{0, 0, 0};
};

/// The radiance that leaves a tile under a distant light of unit perpendicular irradiance.
struct MapResult {
    int width = 0, height = 0;     ///< columns along x and y; row 0 is y = 0
    std::vector<Measured> columns; ///< mean over each column's top; empty where only the reflectance was asked for
    Measured mean;                 ///< of all columns
    Measured reflectance;          ///< share of the incident flux; zero error and value with Method::Stf
    std::uint64_t photons = 0, collisions = 0, lost = 0;
    double seconds = 0, precomputeSeconds = 0, marchSeconds = 0;
    double tableError = 0; ///< of Method::Stf: estimated, relative; not part of the errors above
};

/// One line of JSON: means, errors, counts and times.
std::string mapJson(const MapOptions& options, const MapResult& result);
/// A few lines to read.
std::string mapText(const MapOptions& options, const MapResult& result);
/// Writes the layers `radiance` and `stderr` as a float EXR. Throws std::runtime_error.
void writeMap(const MapResult& result, const std::string& path);

} // namespace stf
