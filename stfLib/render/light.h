// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/transform.h"

#include <cstdint>
#include <string>

namespace stf {

/// How a light's emission depends on its direction (UsdLuxShapingAPI). Angles from the light's -z axis.
struct LightShaping {
    float focus = 0;         ///< exponent of |cosine|; 0: none
    Rgb focusTint{0.0f};     ///< what is left off the axis
    float coneAngle = 180;   ///< degrees; nothing beyond (UsdLux's fallback is 90 where the schema is applied)
    float coneSoftness = 0;  ///< share of the cone, from its edge, over which light fades
    std::string iesFile;     ///< photometric profile (ANSI/IES LM-63); empty: none
    float iesAngleScale = 0; ///< of the profile's vertical angle; 0: none
    bool iesNormalize = false;
    bool operator==(const LightShaping& s) const {
        return focus == s.focus && focusTint == s.focusTint && coneAngle == s.coneAngle &&
               coneSoftness == s.coneSoftness && iesFile == s.iesFile && iesAngleScale == s.iesAngleScale &&
               iesNormalize == s.iesNormalize;
    }
};

/// Of who belongs to every link.
constexpr std::uint64_t kAllLinks = ~std::uint64_t(0);

/// A light as UsdLux describes it. `emission` = color * colour temperature * intensity * 2^exposure.
struct Light {
    enum class Type { Distant, Dome, Sphere, Disk, Rect, Cylinder };

    Type type = Type::Distant;
    /// Light space to world: a distant light, a disk and a rectangle shine along -z; a dome's texture has its poles on
    /// y; a cylinder lies along x.
    Transform lightToWorld;
    Rgb emission{0.0f};
    /// Distant: full angle of the disc in degrees. With angle 0 or `normalize` the perpendicular irradiance is
    /// `emission`; else `emission` is the radiance of the disc.
    float angle = 0;
    /// Lights with an area: radiance is divided by the area in world units.
    bool normalize = false;
    float radius = 0.5f;         ///< sphere, disk, cylinder; light space
    float width = 1, height = 1; ///< rectangle, along x and y
    float length = 1;            ///< cylinder
    /// Dome: latitude-longitude image (EXR or what stb_image reads). Rectangle: the image's top left is at
    /// (+x, +y), so that it reads right seen from in front. Empty: uniform.
    std::string textureFile;
    LightShaping shaping; ///< of lights with an area
    bool shadows = true;
    bool visible = true;
    /// Links: only prims that belong to the first are lit by it, only those that belong to the second throw its
    /// shadows. Empty: all.
    std::string lightLink, shadowLink;

    bool operator==(const Light& l) const {
        return type == l.type && lightToWorld == l.lightToWorld && emission == l.emission && angle == l.angle &&
               normalize == l.normalize && radius == l.radius && width == l.width && height == l.height &&
               length == l.length && textureFile == l.textureFile && shaping == l.shaping && shadows == l.shadows &&
               visible == l.visible && lightLink == l.lightLink && shadowLink == l.shadowLink;
    }
};

} // namespace stf
