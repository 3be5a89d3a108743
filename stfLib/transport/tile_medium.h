// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/optics/delta_eddington.h"
#include "stfLib/transport/surface_field.h"
#include "stfLib/transport/tile_tracer.h"
#include "stfLib/volume/base_volume.h"

#include <cstdint>
#include <vector>

namespace stf {

/// Light of a parallel source at a point inside a tile before its first collision.
struct UncollidedLight {
    Rgb fraction{0.0f};     ///< fluence per outside perpendicular irradiance
    Vec3f towards{0, 0, 1}; ///< towards where it comes from inside the medium (refracted), tile frame, z outward
    Rgb reflected{0.0f};    ///< the same by an open bottom: comes from (towards.x, towards.y, -towards.z)
};

/// A base volume as light sees it: coefficients per voxel in the medium of a form (scaled for dE1, true for classic),
/// the surface of its relief and its index of refraction. Shared by the walks, the camera march and exact single
/// scattering. Positions are in voxel units (x, y of any value, z in 0..size.z growing inward). Immutable, thread-safe.
///
/// Outside of a `surface` there is nothing, whatever the coefficients say. Where the material reaches z = 0 the
/// top itself is the interface. The bottom is index-matched to what lies below unless `openBottom`.
class TileMedium {
public:
    struct Voxel {
        Rgb extinction; ///< kappa' of the form, 1/mm: attenuates
        Rgb scattering; ///< true kappa a, 1/mm: times the exact phase function for the first collision
        float g;        ///< true mean cosine
        float gScaled;  ///< g' of the form: of the linear phase function for the multiple part; 0 for classic
        float keep;     ///< 1 - f: kappa' a' = scattering * keep
    };

    TileMedium(const BaseVolume& volume, TransportForm form, bool openBottom = false);

    const Vec3i& size() const { return size_; }
    const Vec3d& voxelMm() const { return voxelMm_; }
    TransportForm form() const { return form_; }
    const Voxel& voxel(std::size_t i) const { return voxels_[i]; }
    std::size_t voxelCount() const { return voxels_.size(); }
    /// kappa' the same in all channels and voxels' albedo any: one walk carries rgb.
    bool greyExtinction() const { return grey_; }
    /// The first channel with the same coefficients everywhere; equal channels are walked once.
    int channelLike(int channel) const { return like_[channel]; }
    bool scatters() const { return scatters_; }
    /// Whether some g' is not 0: only then flux matters.
    bool wantsFlux() const { return flux_; }
    bool emits() const { return !emission_.empty(); }
    const Rgb& emission(std::size_t i) const { return emission_[i]; }

    bool hasSurface() const { return !surface_.empty(); }
    const SurfaceField& surface() const { return surface_; }
    /// Share of a voxel that lies in the material: 1 where there is no surface.
    float fill(std::size_t i) const { return fill_.empty() ? 1.0f : fill_[i]; }
    /// Whether some interface refracts, and which is the index where light crosses it at a point.
    bool refracts() const { return refracts_; }
    bool openBottom() const { return openBottom_; }
    float ior(const Vec3f& position) const;
    /// Mean index of a flat top; 1 under a relief, and where it is less than that.
    float topIor() const;

    /// Visits the pieces of a straight line that lie in the material: visit(voxel, t0, t1), in order, until it returns
    /// false; t in the unit of the caller, `direction` in voxels per that unit. Surfaces are passed straight.
    template<class Visit>
    float traverse(const Vec3f& position, const Vec3f& direction, float tMax, Visit&& visit) const;

    /// Optical depth (kappa') from a point straight to the top along a direction inside the medium.
    Rgb opticalDepth(const Vec3f& position, const Vec3f& towards) const;
    /// What arrives at a point of the light from outside direction `towardsLight` without a collision: refracted by the
    /// flat top, (1 - F) cos_i / cos_t exp(-depth). Straight through reliefs (index 1 there, or StfTable::single). An
    /// open bottom reflects it up and the top down again, for ever: exact where all columns are alike.
    UncollidedLight uncollided(const Vec3f& position, const Vec3f& towardsLight) const {
        return uncollided(position, towardsLight,
                          [this](const Vec3f& p, const Vec3f& towards) { return opticalDepth(p, towards); });
    }
    /// The same through coefficients that are not the tile's own: depth(position, towards) as `opticalDepth`.
    template<class Depth>
    UncollidedLight uncollided(const Vec3f& position, const Vec3f& towardsLight, Depth&& depth) const;

private:
    friend class Walker;
    friend class LaneWalker;
    struct FlatEntry {
        float cosT, reflectance;
        Vec3f towards; ///< inside
    };
    /// How light comes through a refracting flat top to a point; cosT = 0 where none does.
    FlatEntry enterFlat(const Vec3f& position, const Vec3f& towardsLight) const;
    Vec3i size_;
    Vec3d voxelMm_;
    TransportForm form_;
    bool grey_ = true, scatters_ = false, flux_ = false, refracts_ = false, openBottom_ = false;
    int like_[3] = {0, 1, 2};
    float uniformIor_ = 1; ///< where ior_ is empty
    std::vector<Voxel> voxels_;
    std::vector<float> extinction_[3]; ///< kappa' again, for walks; one array where grey
    /// What a collision reads, together in memory: 1 - a' and the mean cosine of the form.
    struct Collision {
        Rgb coalbedo;
        float g;
    };
    std::vector<Collision> collisions_;
    std::vector<float> ior_;    ///< empty: uniformIor_
    std::vector<float> fill_;   ///< empty: 1
    std::vector<Rgb> emission_; ///< empty: none
    SurfaceField surface_;
};

template<class Visit>
float TileMedium::traverse(const Vec3f& position, const Vec3f& direction, float tMax, Visit&& visit) const {
    const TileTracer tracer(size_);
    if (surface_.empty()) {
        return tracer.traverse(position, direction, tMax,
                               [&](int voxel, int, int, int, float t0, float t1) { return visit(voxel, t0, t1); });
    }
    return tracer.traverse(position, direction, tMax, [&](int voxel, int x, int y, int z, float t0, float t1) {
        if (!surface_.crossedBySurface(std::size_t(voxel))) {
            return surface_.insideVoxel(std::size_t(voxel)) ? visit(voxel, t0, t1) : true;
        }
        bool go = true;
        surface_.pieces({x, y, z}, position, direction, t0, t1,
                        [&](float a, float b, bool inside) { go = go && (!inside || visit(voxel, a, b)); });
        return go;
    });
}

template<class Depth>
UncollidedLight TileMedium::uncollided(const Vec3f& position, const Vec3f& towardsLight, Depth&& depth) const {
    UncollidedLight light;
    light.towards = towardsLight;
    if (!(towardsLight.z > 0)) {
        return light;
    }
    if (!refracts_ || hasSurface()) {
        light.fraction = exp(-depth(position, towardsLight));
        return light;
    }
    const FlatEntry in = enterFlat(position, towardsLight);
    light.towards = in.towards;
    if (!(in.cosT > 0)) {
        return light;
    }
    const float entering = (1 - in.reflectance) * towardsLight.z / in.cosT;
    const Rgb toTop = depth(position, light.towards);
    light.fraction = exp(-toTop) * entering;
    if (openBottom_) {
        // The same at both faces, from inside. The columns below are taken to be like the one above.
        const float f = in.reflectance;
        const Rgb whole = depth({position.x, position.y, float(size_.z)}, light.towards);
        for (int c = 0; c < 3; ++c) {
            const float series = 1 / (1 - f * f * std::exp(-2 * whole[c]));
            light.fraction[c] *= series;
            light.reflected[c] = entering * series * f * std::exp(toTop[c] - 2 * whole[c]);
        }
    }
    return light;
}

} // namespace stf
