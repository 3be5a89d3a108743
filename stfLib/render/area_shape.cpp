// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/area_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Below this solid angle the spherical rectangle's formulas cancel; the rectangle is flat to the eye then.
constexpr double kSmall = 1e-4;

/// Surface area of the side of an elliptic cylinder: perimeter of the ellipse swept along x, by its integral over the
/// angle (trapezoids converge exponentially on periodic functions).
double cylinderArea(const Vec3d& x, const Vec3d& y, const Vec3d& z) {
    constexpr int n = 256;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double phi = 2 * kPi * i / n;
        sum += length(cross(y * -std::sin(phi) + z * std::cos(phi), x * 2.0)) * 2 * kPi / n;
    }
    return sum;
}

} // namespace

std::optional<AreaShape> AreaShape::make(const Light& light, const Transform& t) {
    AreaShape s;
    s.type_ = light.type;
    s.centre_ = t.translation;
    Vec3d extent(0.0); // of the bounds, half
    const auto reach = [&](const Vec3d& v) { return Vec3d(std::abs(v.x), std::abs(v.y), std::abs(v.z)); };
    switch (light.type) {
    case Light::Type::Sphere:
        s.radius_ = double(light.radius) * std::cbrt(std::abs(t.determinant()));
        s.area_ = 4 * kPi * s.radius_ * s.radius_;
        extent = Vec3d(s.radius_);
        break;
    case Light::Type::Disk:
    case Light::Type::Rect: {
        const bool disk = light.type == Light::Type::Disk;
        s.x_ = t.x * (disk ? double(light.radius) : 0.5 * double(light.width));
        s.y_ = t.y * (disk ? double(light.radius) : 0.5 * double(light.height));
        const Vec3d across = cross(s.x_, s.y_);
        s.area_ = length(across) * (disk ? kPi : 4.0);
        // Its own -z, whichever way the transform is handed.
        s.normal_ = normalize(across);
        s.normal_ = dot(s.normal_, t.z) > 0 ? -s.normal_ : s.normal_;
        s.square_ = std::abs(dot(s.x_, s.y_)) < 1e-6 * length(s.x_) * length(s.y_);
        extent = reach(s.x_) + reach(s.y_);
        break;
    }
    case Light::Type::Cylinder:
        s.x_ = t.x * (0.5 * double(light.length));
        s.y_ = t.y * double(light.radius);
        s.z_ = t.z * double(light.radius);
        s.area_ = cylinderArea(s.x_, s.y_, s.z_);
        extent = reach(s.x_) + reach(s.y_) + reach(s.z_);
        break;
    default:
        return std::nullopt;
    }
    if (!(s.area_ > 0) || !std::isfinite(s.area_) || !isFinite(s.centre_)) {
        return std::nullopt;
    }
    s.bounds_.add(Vec3f(s.centre_ - extent));
    s.bounds_.add(Vec3f(s.centre_ + extent));
    return s;
}

ShapeSample AreaShape::sample(const Vec3f& point, Vec2f u) const {
    const Vec3d p(point);
    switch (type_) {
    case Light::Type::Sphere:
        return sampleSphere(p, u);
    case Light::Type::Rect:
        return sampleRect(p, u);
    case Light::Type::Disk:
        return sampleDisk(p, u);
    default:
        return sampleCylinder(p, u);
    }
}

// `areaVector`: outward normal times area over density of the choice.
ShapeSample AreaShape::toPoint(const Vec3d& from, const Vec3d& at, const Vec3d& areaVector) const {
    ShapeSample s;
    const Vec3d d = at - from;
    const double square = dot(d, d), facing = -dot(areaVector, d);
    if (!(square > 0) || !(facing > 0)) {
        return s;
    }
    const double distance = std::sqrt(square);
    s.towards = Vec3f(d / distance);
    s.distance = float(distance);
    s.solidAngle = float(facing / (square * distance));
    return s;
}

ShapeSample AreaShape::sampleSphere(const Vec3d& p, Vec2f u) const {
    ShapeSample s;
    const Vec3d d = centre_ - p;
    const double square = dot(d, d), sin2Max = radius_ * radius_ / square;
    if (!(sin2Max < 1)) {
        return s; // inside
    }
    // 1 - cos of the cone, without cancellation.
    const double most = sin2Max / (1 + std::sqrt(1 - sin2Max));
    const double away = double(u.x) * most, cosine = 1 - away, sin2 = away * (2 - away), phi = 2 * kPi * double(u.y);
    const double distance = std::sqrt(square);
    const Vec3d axis = d / distance;
    Vec3d t, b;
    orthonormalBasis(axis, t, b);
    const double sine = std::sqrt(std::max(0.0, sin2));
    s.towards = Vec3f(t * (sine * std::cos(phi)) + b * (sine * std::sin(phi)) + axis * cosine);
    s.distance = float(distance * cosine - std::sqrt(std::max(0.0, radius_ * radius_ - square * sin2)));
    s.solidAngle = float(2 * kPi * most);
    return s;
}

ShapeSample AreaShape::sampleDisk(const Vec3d& p, Vec2f u) const {
    const double r = std::sqrt(double(u.x)), phi = 2 * kPi * double(u.y);
    return toPoint(p, centre_ + x_ * (r * std::cos(phi)) + y_ * (r * std::sin(phi)), normal_ * area_);
}

/// A rectangle as seen from a point, in axes of its own.
struct AreaShape::SphericalRect {
    Vec3d ax, ay, az;
    double x0, x1, y0, y1, z0; ///< of its corners; z0 < 0
    double b0, b1, k, solid;
};

// False where the formulas do not hold or would cancel: it is sampled by area then.
bool AreaShape::sphericalRect(const Vec3d& p, SphericalRect& r) const {
    if (!square_ || area_ < kSmall * dot(p - centre_, p - centre_)) {
        return false;
    }
    const double lengthX = 2 * length(x_), lengthY = 2 * length(y_);
    r.ax = x_ * (2 / lengthX);
    r.ay = y_ * (2 / lengthY);
    r.az = normal_; // towards the point
    const Vec3d d = centre_ - x_ - y_ - p;
    r.z0 = dot(d, r.az);
    r.x0 = dot(d, r.ax);
    r.y0 = dot(d, r.ay);
    r.x1 = r.x0 + lengthX;
    r.y1 = r.y0 + lengthY;
    const auto edge = [](const Vec3d& a, const Vec3d& b) { return normalize(cross(a, b)); };
    const Vec3d v00(r.x0, r.y0, r.z0), v01(r.x0, r.y1, r.z0), v10(r.x1, r.y0, r.z0), v11(r.x1, r.y1, r.z0);
    const Vec3d n0 = edge(v00, v10), n1 = edge(v10, v11), n2 = edge(v11, v01), n3 = edge(v01, v00);
    const auto angle = [](const Vec3d& a, const Vec3d& b) { return std::acos(std::clamp(-dot(a, b), -1.0, 1.0)); };
    const double g2 = angle(n2, n3), g3 = angle(n3, n0);
    r.k = 2 * kPi - g2 - g3;
    r.solid = angle(n0, n1) + angle(n1, n2) - r.k;
    r.b0 = n0.z;
    r.b1 = n2.z;
    return r.solid > kSmall;
}

ShapeSample AreaShape::sampleRect(const Vec3d& p, Vec2f u) const {
    const double height = dot(p - centre_, normal_);
    if (!(height > 0)) {
        return {};
    }
    SphericalRect r;
    if (!sphericalRect(p, r)) {
        const Vec3d at = centre_ + x_ * (2 * double(u.x) - 1) + y_ * (2 * double(u.y) - 1);
        return toPoint(p, at, normal_ * area_);
    }
    const double au = double(u.x) * r.solid + r.k;
    const double fu = (std::cos(au) * r.b0 - r.b1) / std::sin(au);
    const double cu = std::clamp(std::copysign(1 / std::sqrt(fu * fu + r.b0 * r.b0), fu), -1.0, 1.0);
    const double xu = std::clamp(-(cu * r.z0) / std::max(std::sqrt(1 - cu * cu), 1e-12), r.x0, r.x1);
    const double dd = std::sqrt(xu * xu + r.z0 * r.z0);
    const double h0 = r.y0 / std::sqrt(dd * dd + r.y0 * r.y0), h1 = r.y1 / std::sqrt(dd * dd + r.y1 * r.y1);
    const double hv = h0 + double(u.y) * (h1 - h0);
    const double yv = hv * hv < 1 - 1e-9 ? std::clamp(hv * dd / std::sqrt(1 - hv * hv), r.y0, r.y1) : r.y1;
    const Vec3d way = r.ax * xu + r.ay * yv + r.az * r.z0;
    ShapeSample s;
    s.distance = float(length(way));
    s.towards = Vec3f(normalize(way));
    s.solidAngle = float(r.solid);
    return s;
}

// Half the angle of the side that a point sees, in the cylinder's own coordinates, where it is round and tangents stay
// tangents, and the middle of that side. False from inside, or in front of a cap that does not shine.
bool AreaShape::cylinderSide(const Vec3d& p, double& half, double& towards) const {
    const double volume = dot(x_, cross(y_, z_));
    if (!(std::abs(volume) > 0)) {
        return false;
    }
    const Vec3d d = p - centre_;
    const double py = dot(d, cross(z_, x_)) / volume, pz = dot(d, cross(x_, y_)) / volume;
    const double rho = std::hypot(py, pz);
    if (!(rho > 1)) {
        return false;
    }
    half = std::acos(1 / rho);
    towards = std::atan2(pz, py);
    return true;
}

// Of area, per angle and along, outward.
Vec3d AreaShape::cylinderElement(double phi) const {
    const Vec3d radial = y_ * std::cos(phi) + z_ * std::sin(phi), turn = z_ * std::cos(phi) - y_ * std::sin(phi);
    const Vec3d element = cross(turn, x_);
    return dot(element, radial) < 0 ? -element : element;
}

ShapeSample AreaShape::sampleCylinder(const Vec3d& p, Vec2f u) const {
    double half = 0, middle = 0;
    if (!cylinderSide(p, half, middle)) {
        return {};
    }
    const double phi = middle + (2 * double(u.x) - 1) * half, along = 2 * double(u.y) - 1;
    const Vec3d radial = y_ * std::cos(phi) + z_ * std::sin(phi);
    return toPoint(p, centre_ + x_ * along + radial, cylinderElement(phi) * (2 * half * 2));
}

float AreaShape::solidAngle(const Vec3f& point, const Vec3f& direction, float distance) const {
    const Vec3d p(point), at = p + Vec3d(direction) * double(distance);
    switch (type_) {
    case Light::Type::Sphere:
        return sampleSphere(p, {}).solidAngle;
    case Light::Type::Rect: {
        SphericalRect r;
        return sphericalRect(p, r) ? float(r.solid) : toPoint(p, at, normal_ * area_).solidAngle;
    }
    case Light::Type::Disk:
        return toPoint(p, at, normal_ * area_).solidAngle;
    default: {
        double half = 0, middle = 0;
        if (!cylinderSide(p, half, middle)) {
            return 0;
        }
        const double volume = dot(x_, cross(y_, z_));
        const Vec3d d = at - centre_;
        const double phi = std::atan2(dot(d, cross(x_, y_)) / volume, dot(d, cross(z_, x_)) / volume);
        return toPoint(p, at, cylinderElement(phi) * (2 * half * 2)).solidAngle;
    }
    }
}

float AreaShape::intersect(const Vec3f& o, const Vec3f& dir) const {
    const Vec3d d(dir), w = Vec3d(o) - centre_;
    if (type_ == Light::Type::Sphere) {
        const double b = dot(w, d), c = dot(w, w) - radius_ * radius_;
        const Vec3d nearest = w - d * b; // of the line: no cancellation far away
        const double rest = radius_ * radius_ - dot(nearest, nearest);
        return c > 0 && b < 0 && rest > 0 ? float(-b - std::sqrt(rest)) : kInfinity;
    }
    if (type_ == Light::Type::Rect || type_ == Light::Type::Disk) {
        const double facing = -dot(d, normal_), height = dot(w, normal_);
        if (!(facing > 0) || !(height > 0)) {
            return kInfinity;
        }
        const double t = height / facing;
        const Vec3d at = w + d * t, across = cross(x_, y_);
        const double square = dot(across, across);
        const double a = dot(cross(at, y_), across) / square, b = dot(cross(x_, at), across) / square;
        const bool inside = type_ == Light::Type::Disk ? a * a + b * b <= 1 : std::abs(a) <= 1 && std::abs(b) <= 1;
        return inside ? float(t) : kInfinity;
    }
    const double volume = dot(x_, cross(y_, z_));
    const Vec3d ax = cross(y_, z_) / volume, ay = cross(z_, x_) / volume, az = cross(x_, y_) / volume;
    const double wy = dot(w, ay), wz = dot(w, az), dy = dot(d, ay), dz = dot(d, az);
    const double a = dy * dy + dz * dz, b = wy * dy + wz * dz, c = wy * wy + wz * wz - 1;
    const double rest = b * b - a * c;
    if (!(c > 0) || !(b < 0) || !(rest > 0) || !(a > 0)) {
        return kInfinity; // from inside it is dark
    }
    const double t = c / (-b + std::sqrt(rest));
    return std::abs(dot(w + d * t, ax)) <= 1 ? float(t) : kInfinity;
}

Vec2f AreaShape::textureAt(const Vec3f& point) const {
    const Vec3d at = Vec3d(point) - centre_, across = cross(x_, y_);
    const double square = dot(across, across);
    const double a = dot(cross(at, y_), across) / square, b = dot(cross(x_, at), across) / square;
    return {float(0.5 - 0.5 * a), float(0.5 - 0.5 * b)};
}

} // namespace stf
