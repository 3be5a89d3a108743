// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/area_shape.h"
#include "stfLib/surface/refined_surface.h"

#include <memory>
#include <vector>

namespace stf {

/// A mesh whose surface shines evenly to both sides, as a light: points of it are chosen uniformly by area. In a frame
/// of the caller, in single precision. Immutable, shared by threads.
class MeshShape {
public:
    /// `toFrame`: object space to the caller's frame.
    MeshShape(std::shared_ptr<const RefinedSurface> surface, const Transform& toFrame);

    double area() const { return area_; } ///< of one side; units of the frame, squared
    const Box3f& bounds() const { return bounds_; }
    ShapeSample sample(const Vec3f& point, Vec2f u) const;
    /// 1 / density (per solid angle) with which `sample` chooses a point at a distance, seen at an angle to its normal.
    float solidAngle(float distance, float cosine) const {
        return float(area_) * std::abs(cosine) / (distance * distance);
    }

private:
    std::shared_ptr<const RefinedSurface> surface_;
    Transform toFrame_;
    std::vector<double> cumulative_; ///< area of the triangles up to and with each
    double area_ = 0;
    Box3f bounds_;
};

} // namespace stf
