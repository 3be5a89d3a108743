// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/random.h"
#include "stfLib/reference/shell_space.h"
#include "stfLib/render/shell_object.h"

namespace stf {

/// A point where a path scatters inside an object.
struct WalkVertex {
    Vec3f point;     ///< object space
    Vec3f direction; ///< of travel before, unit
    Vec3f normal;    ///< of the limit surface, unit, outward, at or last before the point
    float g = 0;
    float ior = 1;
    bool inCore = false;
};

/// What the owner of a walk does at its vertices.
class WalkVisitor {
public:
    virtual ~WalkVisitor() = default;
    /// Light that reaches a vertex without scattering again; `throughput` of the path there.
    virtual void visit(const WalkVertex& vertex, const Rgb& throughput) = 0;
    /// The direction in which the path goes on, unit.
    virtual void turned(const WalkVertex& vertex, const Vec3f& direction) = 0;
};

/// A path inside one object: its shell, whose medium is that of the base volume point by point, and its core, which is
/// homogeneous and scatters isotropically.
///
/// Free flights are sampled by null collisions (Woodcock et al. 1965): tentative collisions at the rate of a majorant
/// of all voxels and channels, so that their places have the same density in every channel. What happens there, that
/// light is absorbed, scattered or neither, is chosen by the channels' mean, weighted by what the path carries of each;
/// the path is divided by that chance. All channels use every path, the sum of what it carries never changes, and
/// absorption ends it by chance: no weight grows (single-sample balance over wavelengths: Wilkie et al. 2014, "Hero
/// Wavelength Spectral Sampling"; with null collisions: Miller et al. 2019, "A null-scattering path integral
/// formulation of light transport").
///
/// What a path carries is radiance over n^2, so that interfaces leave it as it is but for Fresnel's equations, of which
/// chance takes one side.
class ShellWalk {
public:
    enum class Region { Void, Material, Core };
    /// A point on a path. `onSurface`: the origin lies on a triangle of the object, which the way on must not meet.
    struct State {
        Vec3f origin, direction; ///< object space, unit
        Region region = Region::Material;
        bool onSurface = false;
        int interfaces = 0; ///< refracted by or reflected at since the last vertex
        int scatterings = 0;
        bool metCore = false;
    };
    struct Outcome {
        bool left = false;  ///< else it was absorbed
        int interfaces = 0; ///< refracted by since the last vertex; 2 and more: reflected, or more than one
        Vec3f point, direction, outward; ///< object space; outward: of the facet, or along the direction at a rim
    };

    ShellWalk(const ShellObject& object, std::shared_ptr<const ReferenceMedium> medium);
    ShellWalk(const ShellWalk&) = delete;
    ShellWalk& operator=(const ShellWalk&) = delete;

    /// A ray meets the limit surface from outside. False where it is mirrored there: `state.direction` is then the
    /// mirrored direction, outside. `normal`: smooth, unit, outward; `facet`: of the triangle.
    bool enter(const Vec3f& point, const Vec3f& direction, const Vec3f& normal, const Vec3f& facet,
               std::uint32_t triangle, CounterRng& rng, State& state);
    /// Follows it until it leaves or is absorbed; `shone`: what shines in the medium along the way.
    Outcome follow(State& state, Rgb& throughput, WalkVisitor& visitor, CounterRng& rng, Rgb& shone);
    /// The straight way out from a point: the share of light that passes unscattered, refracted by at most one
    /// interface; estimated by ratio tracking (Novak et al. 2014), which ends by roulette. Zero where the way ends.
    Rgb wayOut(const State& state, CounterRng& rng, Outcome& out);
    /// The same for a ray that crosses the whole object from a point of its surface, where nothing refracts.
    Rgb passThrough(const Vec3f& point, const Vec3f& direction, std::uint32_t triangle, CounterRng& rng, Outcome& out);

    const ReferenceMedium& medium() const { return *medium_; }
    /// Index of refraction of the shell where the path last was in it.
    float iorAbove() const { return iorAbove_; }
    /// Object units over which the walk steps off triangles.
    float lift() const { return lift_; }
    std::uint64_t rays() const { return rays_; }

private:
    enum class Event { Goes, Absorbed, Left };
    bool nearest(const State& state, RayHit& hit, float& tEnd);
    bool interface(State& state, const Vec3f& normal, const Vec3f& facet, float ior, CounterRng& rng);
    /// The same for light on its straight way: the share that is refracted.
    static float transmit(State& state, const Vec3f& normal, const Vec3f& facet, float ior);
    float crossing(const State& state, float from, float to, bool& lost);
    void surfaceNormals(const State& state, Vec3f& normal, Vec3f& facet, float& ior);
    bool belongsToShell(const State& state);
    Rgb straightOut(State state, CounterRng& rng, Outcome& out);
    Rgb estimateStraight(State state, CounterRng& rng, Outcome& out);
    /// Whether the shell's medium is at a point, and where that is in the tile (mm).
    bool hasMedium(const Vec3f& point, Vec3f& mm);
    bool collide(State& state, Rgb& throughput, WalkVisitor& visitor, CounterRng& rng, Rgb& shone);
    bool scatter(State& state, const WalkVertex& vertex, const Rgb& extinction, const Rgb& scattering, float majorant,
                 Rgb& throughput, WalkVisitor& visitor, CounterRng& rng);
    bool bareCore(const State& state, const Vec3f& mm) const;
    Region regionAbove(const Vec3f& point, Vec3f& mm);
    Vec3f coreNormal(const State& state, const RayHit& hit) const;
    template<class Crosses>
    Event bound(State& state, bool bounded, const RayHit& hit, float tEnd, Outcome& out, Crosses&& crosses);

    const ShellObject& object_;
    std::shared_ptr<const ReferenceMedium> medium_;
    ShellSpace walkSpace_, straightSpace_;
    ShellSpace* space_ = &walkSpace_;                 ///< of what is being followed
    Rgb coreExtinction_{0.0f}, coreScattering_{0.0f}; ///< per object unit
    float coreMajorant_ = 0, majorant_;               ///< per object unit
    float lift_, rim_, reach_;
    float iorAbove_ = 1;
    Vec3f middle_;
    float rounding_;
    bool refractingRelief_;
    std::uint64_t rays_ = 0;
};

} // namespace stf
