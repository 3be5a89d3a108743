// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/optics/delta_eddington.h"
#include "stfLib/transport/factored_field.h"
#include "stfLib/transport/lazy.h"

#include <cstdint>
#include <string>

namespace stf {

/// Where the error of a table comes from: each relative to the rms of I_m over voxels and directions (fluence and, with
/// dE1, the flux as the source weighs it).
struct TableError {
    double target = 0;     ///< what was asked for
    double noise = 0;      ///< of photons, as the table is read (trilinear), from the scatter of independent groups
    double directions = 0; ///< interpolation between light directions, measured at directions between them
    double truncation = 0; ///< of the low rank
    double filter = 0;     ///< bias of the lateral filter
    double storage = 0;    ///< rounding of the stored numbers
    /// All of them, independent of each other.
    double total() const;
};

/// Precomputed light transport of a base volume: the Shell Texture Function, in the medium of `form` (DESIGN 3.3).
/// All per unit outside perpendicular irradiance of the light, Fresnel included, no n^2 (DESIGN 3.5, 3.6). Immutable
/// once made; shared by threads. Parts that a scene does not ask for are not read from the file.
///
/// A laterally uniform volume has a table of one column; callers wrap x and y by `size`.
class StfTable {
public:
    Vec3i size{0, 0, 0};
    Vec3d voxelMm{1, 1, 1};
    DirectionSet directions;
    TransportForm form = TransportForm::DE1;

    Lazy<FactoredField> multiple;    ///< I_m (and F_m): collided fluence and net flux, items are voxels
    Lazy<FactoredField> single;      ///< I_s and its flux, only under a refracting relief; else empty (it is marched)
    Lazy<FactoredField> backlight;   ///< I_b and F_b for unit radiance entering from below, collided and not
    Lazy<FactoredField> emitted;     ///< fluence and flux of the volume's own emission; empty without
    Lazy<FactoredField> transmitted; ///< irradiance on the bottom, all of it, items are columns where light leaves
    Lazy<FactoredField> direct;      ///< the part of it that never collided
    std::vector<Rgb> reflectedBelow; ///< R_sd: share of diffuse light from below that comes back there, [column]
    std::vector<Rgb> emittedBelow;   ///< irradiance on the bottom by the volume's own emission, [column]; may be empty
    /// Radiance that diffuse light from below sends out through the top, per unit radiance below: T_sd, tile average.
    Rgb transmittedUp{0.0f};
    /// Share of the light of each direction (node) that leaves through the top without entering or after it: specular
    /// and diffuse reflection, tile average, per incident flux.
    std::vector<Rgb> reflectedAbove;

    // How it was made.
    std::string volumeHash;
    TableError error;
    std::uint64_t photons = 0, seed = 0, collisions = 0;
    int algorithm = 0;
    double seconds = 0;

    std::size_t voxelIndex(int x, int y, int z) const {
        return std::size_t(x) + std::size_t(size.x) * (std::size_t(y) + std::size_t(size.y) * std::size_t(z));
    }
    /// Of all parts, whether they were read or not; from the header of a table that was read.
    std::size_t bytes() const;
    std::size_t fileBytes = 0;   ///< on disk; 0 where it was not read from a file
    bool madeNow = false;        ///< read back right after this process had computed it
    std::size_t headerBytes = 0; ///< as `bytes` of a table read from a file (set by the reader)
};

/// Writes and reads a table as .vdb; `key` names what it was made from and must agree on reading (an empty key agrees
/// with all). Large parts are stored in half precision. Reading is lazy: the header, maps of columns and bases at once,
/// factors at their first use (which throws Error where the file is gone or damaged by then). Throw Error.
void writeTable(const StfTable& table, const std::string& key, const std::string& path);
StfTable readTable(const std::string& path, const std::string& key);

} // namespace stf
