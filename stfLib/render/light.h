// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/transform.h"

#include <string>

namespace stf {

/// A light as UsdLux describes it. `emission` = color * colour temperature * intensity * 2^exposure.
struct Light {
    enum class Type { Distant, Dome };

    Type type = Type::Distant;
    /// Light space to world: a distant light shines along -z; a dome's texture has its poles on y.
    Transform lightToWorld;
    Rgb emission{0.0f};
    /// Distant: full angle of the disc in degrees. With angle 0 or `normalize` the perpendicular irradiance is
    /// `emission`; else `emission` is the radiance of the disc.
    float angle = 0;
    bool normalize = false;
    /// Dome: latitude-longitude image (EXR or what stb_image reads); empty: uniform radiance `emission`.
    std::string textureFile;
    bool visible = true;

    bool operator==(const Light& l) const {
        return type == l.type && lightToWorld == l.lightToWorld && emission == l.emission && angle == l.angle &&
               normalize == l.normalize && textureFile == l.textureFile && visible == l.visible;
    }
};

} // namespace stf
