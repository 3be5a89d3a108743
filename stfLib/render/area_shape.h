// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/light.h"

#include <optional>

namespace stf {

/// A point of a light seen from another: direction, distance, and the inverse of the density (per solid angle) with
/// which it was chosen: a radiance times that is the estimate of the light's perpendicular irradiance.
struct ShapeSample {
    Vec3f towards{0, 0, 1};
    float distance = 0;
    float solidAngle = 0; ///< 1 / density; 0: nothing comes from there
};

/// The emitting surface of a sphere, disk, rectangle or cylinder light in a frame of the caller, in single precision;
/// affine transforms are kept but for spheres, which take their mean scale. Disks and rectangles shine to one side,
/// along the light's -z; spheres and cylinders outward; cylinders have no caps (UsdLux). Immutable.
class AreaShape {
public:
    /// `toFrame`: light space to the caller's frame. Nothing for lights without an area and for degenerate ones.
    static std::optional<AreaShape> make(const Light& light, const Transform& toFrame);

    double area() const { return area_; } ///< units of the frame, squared
    /// Directions from a point, `u` in [0, 1)^2: uniform in solid angle for spheres and rectangles (Urena, Fajardo &
    /// King 2013, "An Area-Preserving Parametrization for Spherical Rectangles"), uniform in area for disks, and for
    /// cylinders in area of the half that is seen. Solid angle 0 where the point is behind or inside.
    ShapeSample sample(const Vec3f& point, Vec2f u) const;
    /// 1 / density with which `sample` chooses the point that `intersect` finds at `distance` along a unit direction.
    float solidAngle(const Vec3f& point, const Vec3f& direction, float distance) const;
    /// Distance along a ray (unit direction) to the emitting side, or infinity.
    float intersect(const Vec3f& origin, const Vec3f& direction) const;
    /// Bounds, and the middle of them.
    const Box3f& bounds() const { return bounds_; }
    /// Position on a rectangle in an image that it shows, [0, 1]^2 from the image's top left.
    Vec2f textureAt(const Vec3f& point) const;

private:
    ShapeSample sampleSphere(const Vec3d& point, Vec2f u) const;
    Vec3d cylinderElement(double phi) const;
    bool cylinderSide(const Vec3d& point, double& half, double& towards) const;
    struct SphericalRect;
    bool sphericalRect(const Vec3d& point, SphericalRect& rect) const;
    ShapeSample sampleRect(const Vec3d& point, Vec2f u) const;
    ShapeSample sampleDisk(const Vec3d& point, Vec2f u) const;
    ShapeSample sampleCylinder(const Vec3d& point, Vec2f u) const;
    ShapeSample toPoint(const Vec3d& from, const Vec3d& at, const Vec3d& areaVector) const;

    Light::Type type_ = Light::Type::Sphere;
    Vec3d centre_;
    /// Half axes: of the rectangle and the disk x and y, of the cylinder x (half its length), y and z.
    Vec3d x_, y_, z_;
    Vec3d normal_; ///< rectangle, disk: unit, of the side that shines
    double radius_ = 0, area_ = 0;
    bool square_ = false; ///< the rectangle's axes are at right angles
    Box3f bounds_;
};

} // namespace stf
