// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/random.h"
#include "stfLib/core/dipole.h"
#include "stfLib/surface/ray_scene.h"

#include <memory>
#include <vector>

namespace stf {

/// Lower bounds of the distance to the inner boundary of a mesh: exact distances at the middles of coarse cells, less
/// the way there.
class DistanceCells {
public:
    explicit DistanceCells(const RayMesh& mesh);
    /// At most the true distance; may be negative. Points outside the boundary's box: negative.
    float atLeast(const Vec3f& point) const;
    float cell() const { return cell_; }
    const Box3f& box() const { return box_; }

private:
    Box3f box_;
    float cell_ = 1;
    Vec3i size_{0, 0, 0};
    std::vector<float> distances_;
};

/// Walks of light through the core that the inner boundary of a mesh holds: isotropic scattering in the reduced medium,
/// no change of index. Scattering is drawn, absorption is a weight, so that a walk serves all channels that scatter
/// about alike, black media and albedo 1.
/// Far from the boundary a walk jumps to the surface of the largest ball that surely holds nothing but medium: by
/// symmetry it arrives there evenly; what survives is the solution of the diffusion equation with the exact decay of
/// transport theory, and the direction that of Milne's problem. Bias below 0.5 % (tests/unit/core).
/// Immutable; any number of threads.
class CoreWalk {
public:
    /// Coefficients of `material` are in 1/mm, the mesh in units of which one has `mmPerUnit` mm.
    CoreWalk(const CoreMaterial& material, const RayMesh& mesh, double mmPerUnit);

    /// Channels that walk together.
    struct Group {
        bool channel[3] = {false, false, false};
        double scattering = 0; ///< 1 / unit, that walks are drawn with
        float jumpFrom = 0;    ///< least radius of a jump, units
        bool any() const { return channel[0] || channel[1] || channel[2]; }
    };
    const std::vector<Group>& groups() const { return groups_; }

    struct Exit {
        bool left = false;   ///< false: absorbed, or lost through a hole of the boundary
        Vec3f point, normal; ///< normal: outward, of the triangle, not normalised
        Rgb weight{0.0f};    ///< of the channels of the group
    };
    /// Diffuse light that enters at a point (units) of a triangle of the boundary, whose unit normal inward is given.
    Exit walk(const Group& group, const Vec3f& from, const Vec3f& inward, std::uint32_t triangle,
              CounterRng& rng) const;

    /// What diffuse light does in an infinite medium. Any unit of length.
    struct Diffusion {
        double decay = 0; ///< 1 / length, exact in transport theory: albedo artanh(k) = k, k relative to the extinction
        double beyond = 0; ///< length by which it extrapolates to zero beyond a boundary
        Diffusion() = default;
        Diffusion(double sigmaA, double sigmaSPrime);
        /// Share of the light of a ball's middle that leaves the ball.
        double survival(double radius) const;
    };
    /// Cosine to the normal of light that leaves a half-space from deep within, by a number in [0, 1).
    static float milneCosine(float u);

private:
    const RayMesh& mesh_;
    Vec3d sigmaA_, sigmaS_; ///< 1 / unit
    Diffusion diffusion_[3];
    std::vector<Group> groups_;
    std::shared_ptr<const DistanceCells> distances_;
    float rounding_ = 0;
};

} // namespace stf
