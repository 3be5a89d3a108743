// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

namespace stf {

/// UsdPreviewSurface at one point, inputs looked up and in range.
struct PreviewPoint {
    Rgb diffuse{0.18f}; ///< albedo; nothing of metals
    Rgb emission{0.0f}; ///< radiance
    Rgb f0{0.0f};       ///< specular reflectance facing the surface
    Rgb f90{0.0f};      ///< and grazing it
    float roughness = 0.5f;
    float clearcoat = 0, clearcoatRoughness = 0.01f;
    float opacity = 1;
    bool presence = false; ///< (1 - opacity) of the surface is not there at all, rather than clear

    bool isLambert() const { return !(maxComponent(f0) > 0) && !(clearcoat > 0); }
};

/// Reflection of UsdPreviewSurface: Lambert, a GGX lobe and one of a white clear coat of index 1.5 on top (Walter et
/// al. 2007 with Smith's height-correlated masking, Heitz 2014; alpha = roughness^2, at least 0.001; Schlick's
/// Fresnel). Each layer gets what those above it let pass on the way in and on the way out, so that the whole is
/// reciprocal and never sends back more than it gets. Single scattering: rough metals darken (white ones send back 1 -
/// ln 2 = 0.31 of light along the normal at roughness 1, 0.92 at 0.5).
///
/// Directions are unit, away from the surface, in a frame whose z is the shading normal; those with z <= 0 get nothing.
class PreviewBsdf {
public:
    explicit PreviewBsdf(const PreviewPoint& point);

    /// 1/sr.
    Rgb evaluate(const Vec3f& out, const Vec3f& in) const;
    /// Per solid angle, with which `sample` chooses `in`.
    float density(const Vec3f& out, const Vec3f& in) const;

    struct Sample {
        Vec3f in{0, 0, 1};
        Rgb weight{0.0f}; ///< value times cosine over density; zero: the path ends
        float density = 0;
        float spread = 0; ///< how wide the chosen lobe is, radians, roughly
    };
    /// Visible normals of the lobes (Dupuy & Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps") and the
    /// cosine. `pick` and `u` in [0, 1).
    Sample sample(const Vec3f& out, float pick, Vec2f u) const;

    /// What goes straight through where the surface is not opaque.
    Rgb through(const Vec3f& direction) const;

private:
    struct Chances {
        float diffuse, specular, coat;
    };
    Chances chances(const Vec3f& out) const;

    PreviewPoint p_;
    float alpha_, coatAlpha_;
};

} // namespace stf
