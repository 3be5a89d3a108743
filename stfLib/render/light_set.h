// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"
#include "stfLib/render/lat_long_image.h"
#include "stfLib/render/light.h"

#include <map>
#include <vector>

namespace stf {

/// A direction towards a light, world space, and what it brings: the estimate of the perpendicular irradiance of all
/// directions of that light (radiance over density). Zero where nothing comes from there.
struct LightSample {
    Vec3f towards{0, 0, 1};
    Rgb irradiance{0.0f};
};

/// All lights that give light, ready for sampling. Immutable after construction, shared by threads.
class LightSet {
public:
    LightSet() = default;
    /// Lights that are invisible or black are left out; an unreadable texture is reported and the light is uniform.
    LightSet(const std::map<std::string, Light>& lights, const MessageSink& messages);

    std::size_t count() const { return lights_.size(); }
    /// `normal`: the surface the light is wanted for; a dome is sampled by its cosine and, with a texture, by its
    /// brightness too (balance heuristic; Veach 1997).
    LightSample sample(std::size_t light, const Vec3f& normal, Vec2f u) const;
    /// Radiance of what lies behind everything, in a direction.
    Rgb background(const Vec3f& direction) const;
    bool hasDome() const;
    bool isDome(std::size_t light) const { return lights_[light].type == Light::Type::Dome; }

private:
    struct Prepared {
        Light::Type type = Light::Type::Distant;
        Vec3f axis{0, 0, 1};  ///< distant: towards the light
        float cosAngle = 1;   ///< distant: of half the angle
        Rgb irradiance{0.0f}; ///< distant
        Rgb tint{0.0f};       ///< dome: factor of the texture
        Transform lightToWorld, worldToLight;
        LatLongImage image;
        std::vector<float> rowCdf, columnCdf; ///< cumulative brightness, times the sine of the row's polar angle
        Rgb radiance(const Vec3f& lightDirection) const;
        float imageDensity(const Vec3f& lightDirection) const;
        Vec3f sampleImage(Vec2f u) const;
        void buildCdf();
    };
    std::vector<Prepared> lights_;
};

} // namespace stf
