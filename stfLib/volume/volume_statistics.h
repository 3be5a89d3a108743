// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"

#include <optional>
#include <vector>

namespace stf {

/// The homogeneous medium that a volume is on average: means over the voxels that hold material, 1/mm per channel.
struct MeanCoefficients {
    Vec3d sigmaA{0, 0, 0}, sigmaSPrime{0, 0, 0};
    double ior = 1;
    std::size_t filled = 0; ///< voxels that hold material
};
MeanCoefficients meanCoefficients(const BaseVolume& volume);

/// Where material begins below the tile's top in each column (x fastest), mm, interpolated between the middles of
/// voxels; negative where a column holds none. The top itself, 0, where there is no `surface` and no void above.
std::vector<float> surfaceDepths(const BaseVolume& volume);

struct SurfaceStatistics {
    double lowestMm = 0, highestMm = 0, meanMm = 0, rmsMm = 0; ///< depth below the tile's top
    double steepest = 0;                                       ///< degrees
    double emptyShare = 0;                                     ///< of columns without material
    double overhangShare = 0;                                  ///< of columns with a void below material
};

/// What `stf inspect` tells of a volume.
struct VolumeStatistics {
    Vec3d extinctionMin{0, 0, 0}, extinctionMax{0, 0, 0};                                ///< 1/mm, of all voxels
    Vec3d opticalDepthMin{0, 0, 0}, opticalDepthMean{0, 0, 0}, opticalDepthMax{0, 0, 0}; ///< of columns
    Vec3d albedoMean{0, 0, 0};                                                           ///< of filled voxels
    double gMin = 0, gMax = 0, iorMin = 1, iorMax = 1;
    double filledShare = 0;
    MeanCoefficients mean;
    double thicknessMm = 0;             ///< mean depth of material below the surface
    Vec3d diffusionLengthMm{0, 0, 0};   ///< of the mean coefficients; infinite without absorption
    Vec3d reflectanceFromCore{0, 0, 0}; ///< shareFromBelow() of the mean coefficients
    double periodicity[2] = {1, 1};     ///< along x and y, see periodicityError()
    std::size_t bytes = 0;              ///< in memory
    std::optional<SurfaceStatistics> surface;
};
VolumeStatistics statisticsOf(const BaseVolume& volume);

/// Share of a deep medium's diffuse reflectance that a shell of `thicknessMm` over a black core lacks: what the core
/// has to give. (1 - R^2) e / (1 - R^2 e) with e = exp(-2 T / l_d), R the reflectance of the deep medium under its
/// interface: the law C exp(-2 T / l_d) of diffusion with C from two-flux theory (Kubelka 1948). Within a third of
/// exact slabs for albedo' .95 to .999 and T of .3 to 3 diffusion lengths (tests/unit/volume). 1 / mm coefficients; 0
/// to 1.
double shareFromBelow(double sigmaA, double sigmaSPrime, double ior, double thicknessMm);
/// The thickness at which that share is `share`, mm; infinite without absorption.
double thicknessForShare(double sigmaA, double sigmaSPrime, double ior, double share);

/// Root mean square difference of voxels that meet at the wrap along an axis (0: x, 1: y), over that of neighbours
/// inside; the worst of scattering, absorption and surface. About 1 for a tile without a seam; 1 where all are the
/// same.
double periodicityError(const BaseVolume& volume, int axis);

} // namespace stf
