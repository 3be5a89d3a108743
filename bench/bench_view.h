// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/camera.h"
#include "stfLib/render/light.h"

namespace stf {

/// A square frustum; `opening`: tangent of half its angle; from `low` to `high` along the view.
inline Matrix4 squareFrustum(double opening, double low, double high) {
    Matrix4 projection{};
    projection[0] = projection[5] = 1 / opening;
    projection[10] = -(high + low) / (high - low);
    projection[11] = -1;
    projection[14] = -2 * high * low / (high - low);
    return projection;
}

inline Light sunFrom(const Vec3d& towards, const Rgb& emission) {
    Light sun; // shines along its -z
    sun.lightToWorld.z = normalize(towards);
    sun.lightToWorld.x = normalize(cross(Vec3d(0, 1, 0), sun.lightToWorld.z));
    sun.lightToWorld.y = cross(sun.lightToWorld.z, sun.lightToWorld.x);
    sun.emission = emission;
    return sun;
}

} // namespace stf
