// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/transform.h"
#include "stfLib/surface/ray_scene.h"

#include <array>

namespace stf {

/// 4x4 in double precision, row-major with row vectors (p' = p M), as OpenUSD stores it.
using Matrix4 = std::array<double, 16>;

/// How wide what a pixel sees is along its ray (Akenine-Moller et al. 2021, "Improved shader and texture level of
/// detail using ray cones"), world units; what curved mirrors do to it is left aside.
struct RayCone {
    float width = 0;  ///< where the ray starts
    float spread = 0; ///< per unit of the way
    float at(float distance) const { return width + spread * distance; }
};

/// A pinhole or orthographic camera given by its matrices: any projection that maps view space to normalised device
/// coordinates -1..1 with depth -1 (near) to 1 (far). Immutable; used from all threads.
class Camera {
public:
    Camera();
    /// Throws Error if a matrix is singular or not finite.
    Camera(const Matrix4& worldToView, const Matrix4& projection);

    /// Ray through normalised device coordinates (-1..1, y up), unit direction, starting on the near plane; world space
    /// relative to `origin`, which keeps its digits where the scene is far from the world's own.
    Ray ray(double ndcX, double ndcY, const Vec3d& origin = Vec3d(0.0)) const;
    /// The cone of a pixel there, whose width and height are given in normalised device coordinates.
    RayCone cone(double ndcX, double ndcY, double pixelWidth, double pixelHeight) const;
    /// Normalised device depth -1..1 of a world point, and its distance along the view axis.
    double ndcDepth(const Vec3d& world) const;
    double viewDepth(const Vec3d& world) const;
    Vec3f viewNormal(const Vec3f& worldNormal) const;
    bool operator==(const Camera& c) const { return worldToView_ == c.worldToView_ && projection_ == c.projection_; }

private:
    Matrix4 worldToView_, projection_, ndcToWorld_;
};

} // namespace stf
