// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"
#include "stfLib/render/camera.h"
#include "stfLib/render/light.h"

#include <algorithm>

namespace stf {

struct PreparedInstance;

/// What is focused by something narrow onto a wide lobe is found too rarely to be other than speckle: it is blurred,
/// not lost (Kaplanyan & Dachsbacher 2013, "Path Space Regularization for Holistic and Robust Light Transport"). Least
/// alpha of a lobe that a path meets after lobes of this spread (radians).
inline float regularizedAlpha(float spread) {
    return 0.5f * std::min(spread, 0.5f); // the spread of Lambert's lobe and of light in a shell
}
/// And the least half angle, radians, of a distant light that it meets where samples of it do not get.
inline float regularizedDisc(float spread) {
    return std::min(spread, 0.5f);
}

/// A path from the camera on its way through a scene, and how its present ray came to be.
struct LightPath {
    Ray ray;
    Rgb throughput{1.0f};
    float travelled = 0;   ///< before the ray's origin
    bool mirrored = false; ///< by a shell's surface: the rest of the path is what is seen in it
    bool bounced = false;  ///< off a plain surface: the rest is light that the surface gets from others
    int bounces = 0;
    float spread = 0; ///< radians, of what lobes chose from: shells need not be read finer

    /// What the ray takes with it of lights that samples of them find as well.
    enum class Lights { None, Shared, All };
    Lights lights = Lights::None;
    bool lightsOnly = false;         ///< the path ends here: the ray only looks for lights
    float density = 0;               ///< shared: per solid angle, of the ray's direction
    int domeSamples = 1;             ///< and how often a dome was asked
    bool glowShared = false;         ///< samples of what leaves shells were taken as well
    Vec3f normal;                    ///< and where: of the surface that the ray leaves
    std::uint64_t links = kAllLinks; ///< of who gets the lights that the ray meets
    bool shadowless = false; ///< and whether lights without shadows, found wherever they are, are still to be met

    /// Shells that the ray's origin may lie in, those entered last at the end: what is met inside of a shell ends the
    /// march there, and the rest of the shell comes after it.
    static constexpr int kMostWithin = 4;
    const PreparedInstance* within[kMostWithin];
    int withinCount = 0;
    float index = 1;  ///< of refraction around the ray's origin
    bool met = false; ///< the ray only goes on to what it was stopped by
    bool isWithin(const PreparedInstance& instance) const {
        return std::find(within, within + withinCount, &instance) != within + withinCount;
    }
    void enter(const PreparedInstance& instance) {
        if (withinCount < kMostWithin) {
            within[withinCount++] = &instance;
        }
    }

    /// Whether it still is the camera's own ray, bent at most.
    bool seen() const { return !mirrored && !bounced; }
    /// From here on it is a mirror image.
    void mirror() {
        mirrored = true;
        glowShared = false;
        lights = Lights::All;
    }
    /// It went through a shell. Samples of lights see through those that do not bend rays, and nothing behind others.
    void passShell(bool straight) {
        if (!straight) {
            lights = seen() ? Lights::None : Lights::All;
            glowShared = false;
        }
    }
    /// Something in a shell, which hides lights from samples, is what it meets next.
    void stopWithin() { lights = seen() ? Lights::None : Lights::All; }
};

} // namespace stf
