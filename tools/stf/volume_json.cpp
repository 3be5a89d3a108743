// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/volume_json.h"

#include "tools/stf/sheet.h"

#include <cmath>
#include <cstdio>

namespace stf {

namespace {

// A core of the same mean medium replaces what the shell lacks, but for its structure and its dipole's error.
constexpr double kLargestShare = 0.05;
// Noise of a tile with 32 voxels to a side stays below this.
constexpr double kLargestSeam = 2;

nlohmann::json number(double x) {
    return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json();
}
nlohmann::json triple(const Vec3d& v) {
    return {number(v.x), number(v.y), number(v.z)};
}

} // namespace

nlohmann::json describeVolume(const BaseVolume& v, const VolumeStatistics& s) {
    Vec3d lengths;
    for (int c = 0; c < 3; ++c) {
        lengths[c] = s.thicknessMm / s.diffusionLengthMm[c];
    }
    nlohmann::json j{{"kind", "base volume"},
                     {"name", v.name},
                     {"size", {v.size.x, v.size.y, v.size.z}},
                     {"voxelMm", triple(v.voxelMm)},
                     {"extentMm", triple(v.extentMm())},
                     {"extinctionMin", triple(s.extinctionMin)},
                     {"extinctionMax", triple(s.extinctionMax)},
                     {"meanOpticalDepth", triple(s.opticalDepthMean)},
                     {"opticalDepthMin", triple(s.opticalDepthMin)},
                     {"opticalDepthMax", triple(s.opticalDepthMax)},
                     {"meanAlbedo", triple(s.albedoMean)},
                     {"gRange", {s.gMin, s.gMax}},
                     {"iorRange", {s.iorMin, s.iorMax}},
                     {"filledShare", s.filledShare},
                     {"meanSigmaA", triple(s.mean.sigmaA)},
                     {"meanSigmaSPrime", triple(s.mean.sigmaSPrime)},
                     {"thicknessMm", s.thicknessMm},
                     {"diffusionLengthMm", triple(s.diffusionLengthMm)},
                     {"thicknessInDiffusionLengths", triple(lengths)},
                     {"reflectanceFromCore", triple(s.reflectanceFromCore)},
                     {"periodicityError", {number(s.periodicity[0]), number(s.periodicity[1])}},
                     {"memoryBytes", s.bytes},
                     {"coreSigmaA", triple(v.coreSigmaA)},
                     {"coreSigmaSPrime", triple(v.coreSigmaSPrime)},
                     {"laterallyUniform", v.laterallyUniform()},
                     {"relief", v.hasRelief()},
                     {"hash", v.contentHash()}};
    if (s.surface) {
        j["surface"] = {{"highestMm", s.surface->highestMm},
                        {"lowestMm", s.surface->lowestMm},
                        {"meanMm", s.surface->meanMm},
                        {"rmsMm", s.surface->rmsMm},
                        {"steepestDegrees", s.surface->steepest},
                        {"emptyShare", s.surface->emptyShare},
                        {"overhangShare", s.surface->overhangShare}};
    }
    const std::vector<std::string> warnings = volumeWarnings(v, s);
    j["warnings"] = warnings;
    return j;
}

std::vector<std::string> volumeWarnings(const BaseVolume& v, const VolumeStatistics& s) {
    std::vector<std::string> list;
    char text[400];
    int worst = 0;
    double needed = 0;
    for (int c = 0; c < 3; ++c) {
        worst = s.reflectanceFromCore[c] > s.reflectanceFromCore[worst] ? c : worst;
        needed =
            std::max(needed, thicknessForShare(s.mean.sigmaA[c], s.mean.sigmaSPrime[c], s.mean.ior, kLargestShare));
    }
    const double share = s.reflectanceFromCore[worst];
    if (share > kLargestShare) {
        const char* const names[] = {"red", "green", "blue"};
        const std::string least = std::isfinite(needed) ? ", at " + lengthText(needed) + " it were 5 %" : "";
        std::snprintf(text, sizeof text,
                      "the shell is thin: %s of material are %.2g diffusion lengths in %s, so %.0f %% of the "
                      "reflectance come from the homogeneous core and do not show the structure of what is below%s",
                      lengthText(s.thicknessMm).c_str(), s.thicknessMm / s.diffusionLengthMm[worst], names[worst],
                      100 * share, least.c_str());
        list.emplace_back(text);
    }
    for (int axis = 0; axis < 2; ++axis) {
        if (s.periodicity[axis] > kLargestSeam) {
            std::snprintf(text, sizeof text,
                          "a seam along %c: voxels that meet where tiles join differ %.1f times as much as neighbours "
                          "inside",
                          axis == 0 ? 'x' : 'y', s.periodicity[axis]);
            list.emplace_back(text);
        }
    }
    if (s.surface && s.surface->emptyShare > 0) {
        std::snprintf(text, sizeof text, "%.2g %% of the columns hold no material: light passes to the core there",
                      100 * s.surface->emptyShare);
        list.emplace_back(text);
    }
    if (!v.hasCore()) {
        list.emplace_back("no core is given: below the shell it is black, unless the scene binds one");
    }
    return list;
}

} // namespace stf
