// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/shell_object.h"
#include "stfLib/render/shell_place.h"

#include <functional>

namespace stf {

/// Where a camera path leaves a shell.
struct ShellExit {
    Rgb weight{0.0f};     ///< by which what is seen there counts; zero: nothing leaves
    Vec3f point;          ///< object space
    Vec3f outward;        ///< unit, away from the shell
    Vec3f direction;      ///< unit, object space
    float travelled = 0;  ///< object units, inside the shell
    bool stopped = false; ///< the path is still in the shell: something else is met there
};

/// What a camera ray sees in a shell whose relief refracts, outside radiance: Fresnel's factors and n^2 are in it.
struct ReliefRadiance {
    Rgb single{0.0f}, multiple{0.0f}, core{0.0f};
    Rgb reflection{0.0f}; ///< what the relief mirrors of itself
    ShellExit through;    ///< the way on of what was refracted, or of what passed by the relief
    ShellExit mirror;     ///< that of what the first interface mirrors
};

/// How far a way of object space, from an origin along a unit direction, goes until something else is met in the shell.
using ReliefObstacle = std::function<float(const Vec3f& origin, const Vec3f& direction)>;

/// Where a camera ray enters, object space.
struct ReliefEntry {
    Vec3f point;         ///< on the limit surface
    Vec3f direction;     ///< unit, inward
    Vec3f normal, facet; ///< outward, of the smooth surface (unit) and of its triangle (any length)
    std::uint32_t triangle = 0;
    bool within = false;               ///< it starts inside the shell; radiance over n^2 counts where that is material
    ReliefObstacle obstacle = nullptr; ///< null: there is nothing else in the shell
};

/// What a straight way through a shell meets first: the relief, the limit surface where the relief reaches it, or the
/// inner boundary.
struct ReliefSight {
    Vec3f point, normal; ///< object space; unit, outward
    ShellPlace place;    ///< there
    float atMm = 0;      ///< depth in the sample from which on there is material
    float travelled = 0; ///< object units from the entry; where nothing is met, to where the shell is left
};

/// Follows one camera ray through a shell with a refracting relief: straight to the relief's surface, where it is
/// split by Fresnel's equations; inside, with radiance divided by n^2, it is refracted out or reflected by chance
/// wherever it meets the relief or the top again, until it leaves or reaches the core. The mirrored part is followed
/// the same way within the shell. Unbiased: long paths end by roulette. Where the relief reaches the top, that is the
/// interface; elsewhere the limit surface does nothing.
class ReliefMarch {
public:
    /// `tile` has begun; `core`: radiance leaving the core per sample of the grid, or null; `level` of the grid.
    ReliefMarch(const ShellObject& object, ShellProbe& probe, TileMarch& tile, const Rgb* core, int level,
                const ShellLight* lights, int lightCount, PixelSampler& sampler);
    ReliefRadiance march(const ReliefEntry& entry);
    /// Without light. False where the way leads out again.
    bool firstSight(const ReliefEntry& entry, ReliefSight& out);

private:
    /// A path at some point of the shell, from where it goes on.
    struct Path {
        Vec3f origin, direction; ///< object space, unit
        float travelled = 0;     ///< up to the origin, object units
        bool inside = false;     ///< the material
        bool onTop = false;      ///< the origin lies on a surface of the shell: the limit surface
        bool onCore = false;     ///< or the inner boundary
        bool bent = false;       ///< `place` holds at the origin
        bool faint = false;      ///< roulette decides whether it meets another interface
        int meetings = 0;
        ShellPlace place;
    };
    enum class Leg { Met, Bounded, Ended };

    bool start(const ReliefEntry& entry, Path& path);
    void startWithin(const ReliefEntry& entry, Path& path);
    ShellExit follow(Path path, const ReliefObstacle& obstacle, Rgb& core);
    Leg walkStraight(Path& path, float tEnd, ReliefMeeting& met);
    bool meet(Path& path, const Vec3f& normal, const Vec3f& facet, float ior);
    bool survives(Path& path);

    const ShellObject& object_;
    ShellProbe& probe_;
    TileMarch& tile_;
    const Rgb* core_;
    const int level_;
    const float step_;
    const Vec3f perMm_;
    TileLights lights_;
    PixelSampler& sampler_;
    bool splits_ = true; ///< the next interface from outside is the first
    bool mirrors_ = false;
    Path mirror_; ///< of the first interface
    Rgb mirrorWeight_{0.0f};
};

} // namespace stf
