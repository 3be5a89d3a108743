// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/lat_long_image.h"
#include "stfLib/render/light.h"

#include <vector>

namespace stf {

/// Light from all directions, uniform or from a latitude-longitude image. Immutable, shared by threads.
class DomeLight {
public:
    DomeLight() = default;
    /// A texture that cannot be read is reported as `id`'s; the dome is uniform then.
    DomeLight(const std::string& id, const Light& light, const MessageSink& messages);

    /// Radiance that comes from a direction (unit, world).
    Rgb radiance(const Vec3f& towards) const;
    /// A direction for a surface of this normal: by its cosine and, with a texture, by brightness too (balance
    /// heuristic; Veach 1997). Returns the estimate of the perpendicular irradiance, radiance over `density`.
    Rgb sample(const Vec3f& normal, Vec2f u, Vec3f& towards, float& density) const;
    /// Per solid angle, with which `sample` chooses a direction (unit, world).
    float density(const Vec3f& normal, const Vec3f& towards) const;

    /// No direction is much brighter than the others are on average.
    bool smooth() const { return smooth_; }

private:
    Rgb lookUp(const Vec3f& lightDirection) const;
    float imageDensity(const Vec3f& lightDirection) const;
    Vec3f sampleImage(Vec2f u) const;
    void buildCdf();

    Rgb tint_{0.0f}; ///< factor of the texture
    bool smooth_ = true;
    Transform lightToWorld_, worldToLight_;
    LatLongImage image_;
    std::vector<float> rowCdf_, columnCdf_; ///< cumulative brightness, times the sine of the row's polar angle
};

} // namespace stf
