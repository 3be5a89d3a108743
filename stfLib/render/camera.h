// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/motion.h"
#include "stfLib/surface/ray_scene.h"

#include <array>
#include <cmath>
#include <vector>

namespace stf {

/// 4x4 in double precision, row-major with row vectors (p' = p M), as OpenUSD stores it.
using Matrix4 = std::array<double, 16>;

/// How wide what a pixel sees is along its ray (Akenine-Moller et al. 2021, "Improved shader and texture level of
/// detail using ray cones"), world units; what curved mirrors do to it is left aside.
struct RayCone {
    float width = 0;  ///< where the ray starts
    float spread = 0; ///< per unit of the way
    float lens = 0;   ///< of the circle of confusion, more than that where the ray starts
    float focus = 1;  ///< way to where the circle of confusion is a point
    float at(float distance) const {
        const float cone = width + spread * distance;
        return lens > 0 ? cone + lens * std::abs(1 - distance / focus) : cone;
    }
};

/// A thin lens: what lies in the plane of focus is sharp. World units.
struct Lens {
    double radius = 0;        ///< of the aperture: focal length / (2 f-number); 0: a pinhole
    double focusDistance = 0; ///< from the lens along the view axis, positive
    bool blurs() const { return radius > 0 && focusDistance > 0; }
    bool operator==(const Lens& l) const { return radius == l.radius && focusDistance == l.focusDistance; }
};

/// What a camera has beside its place and its projection.
struct CameraOptics {
    Lens lens;
    Shutter shutter;
    std::vector<TransformSample> viewToWorld; ///< where the camera is around the present time; empty: at rest
    double exposure = 0;                      ///< stops: the film's values are 2^exposure times radiance
    bool operator==(const CameraOptics& o) const {
        return lens == o.lens && shutter == o.shutter && viewToWorld == o.viewToWorld && exposure == o.exposure;
    }
};

/// A camera given by its matrices: any projection that maps view space to normalised device coordinates -1..1 with
/// depth -1 (near) to 1 (far), perspective or orthographic; with a lens, rays differ by where they pass it. While the
/// shutter is open it may move. Immutable; used from all threads.
class Camera {
public:
    Camera();
    /// Throws Error if a matrix is singular or not finite, or a value of the optics is not finite.
    Camera(const Matrix4& worldToView, const Matrix4& projection, const CameraOptics& optics = {});
    /// The same without a lens, and at rest where it is at the present time, with a shutter that does not blur.
    Camera pinhole() const;
    Camera atRest() const;

    const CameraOptics& optics() const { return optics_; }
    bool moves() const { return !motion_.empty(); }

    /// Ray through normalised device coordinates (-1..1, y up), unit direction, starting on the near plane; world space
    /// relative to `origin`, which keeps its digits where the scene is far from the world's own. Through the middle of
    /// the lens, at the middle of the exposure.
    Ray ray(double ndcX, double ndcY, const Vec3d& origin = Vec3d(0.0)) const;
    /// The same through a point of the lens (`onLens`: of the unit disc) at a time, 0 (shutter opens) to 1.
    Ray ray(double ndcX, double ndcY, const Vec3d& origin, const Vec2d& onLens, float time) const;
    /// The cone of a pixel there, whose width and height are given in normalised device coordinates. `lensSamples`: how
    /// many rays share the lens: each stands for its part of the circle of confusion.
    RayCone cone(double ndcX, double ndcY, double pixelWidth, double pixelHeight, int lensSamples = 1) const;
    /// Normalised device depth -1..1 of a world point, and its distance along the view axis. Of a camera that moves: in
    /// the middle of the exposure.
    double ndcDepth(const Vec3d& world) const;
    double viewDepth(const Vec3d& world) const;
    Vec3f viewNormal(const Vec3f& worldNormal) const;
    bool operator==(const Camera& c) const {
        return worldToView_ == c.worldToView_ && projection_ == c.projection_ && optics_ == c.optics_;
    }

private:
    Matrix4 worldToView_, projection_, ndcToView_, viewToWorld_, ndcToWorld_;
    Matrix4 given_; ///< worldToView at the present time
    CameraOptics optics_;
    std::vector<Transform> motion_; ///< view to world, steps over the exposure
};

/// A point of the unit disc, uniformly for u uniform in the unit square, neighbours staying neighbours (Shirley and
/// Chiu 1997, "A Low Distortion Map Between Disk and Square").
Vec2d onUnitDisc(const Vec2f& u);

} // namespace stf
