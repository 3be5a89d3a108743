// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"

#include <cstdint>
#include <string>
#include <vector>

namespace stf {

struct SampleOptions {
    Vec3i size{0, 0, 0}; ///< voxels; 0: the sample's own default
    double voxelMm = 0;  ///< edge of a voxel; 0: the sample's own default
    std::uint32_t seed = 0;
    Rgb extinction{1.0f}; ///< of "uniform"
    Rgb albedo{0.9f};     ///< of "uniform" and "random"
    float g = 0;          ///< of both
    double ior = 0;       ///< of all material, relative to outside; 0: the sample's own
    double ratio = 100;   ///< of "random": largest extinction over smallest
    double tau = 10;      ///< of "random": mean optical depth from top to bottom
};

/// Names that `makeSample` knows, with a line of description each.
struct SampleInfo {
    std::string name, description;
};
const std::vector<SampleInfo>& sampleNames();

/// Makes a modelled base volume: one of sampleNames(), each described in volume/samples.h. All are periodic in x and y.
/// Deterministic by seed. Throws Error for an unknown name or an absurd size.
BaseVolume makeSample(const std::string& name, const SampleOptions& options);

} // namespace stf
