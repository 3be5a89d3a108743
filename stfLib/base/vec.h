// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stf {

/// A vector of three numbers: a point, a direction or one number per colour channel.
template<class T>
struct Vec3 {
    T x{}, y{}, z{};

    constexpr Vec3() = default;
    constexpr explicit Vec3(T s) : x(s), y(s), z(s) {}
    constexpr Vec3(T a, T b, T c) : x(a), y(b), z(c) {}
    template<class U>
    constexpr explicit Vec3(const Vec3<U>& v) : x(T(v.x)), y(T(v.y)), z(T(v.z)) {}

    constexpr T& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    constexpr const T& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }

    constexpr Vec3 operator-() const { return {-x, -y, -z}; }
    constexpr Vec3& operator+=(const Vec3& v) { return x += v.x, y += v.y, z += v.z, *this; }
    constexpr Vec3& operator-=(const Vec3& v) { return x -= v.x, y -= v.y, z -= v.z, *this; }
    constexpr Vec3& operator*=(const Vec3& v) { return x *= v.x, y *= v.y, z *= v.z, *this; }
    constexpr Vec3& operator*=(T s) { return x *= s, y *= s, z *= s, *this; }
    constexpr Vec3& operator/=(T s) { return x /= s, y /= s, z /= s, *this; }
    friend constexpr Vec3 operator+(Vec3 a, const Vec3& b) { return a += b; }
    friend constexpr Vec3 operator-(Vec3 a, const Vec3& b) { return a -= b; }
    friend constexpr Vec3 operator*(Vec3 a, const Vec3& b) { return a *= b; }
    friend constexpr Vec3 operator*(Vec3 a, T s) { return a *= s; }
    friend constexpr Vec3 operator*(T s, Vec3 a) { return a *= s; }
    friend constexpr Vec3 operator/(Vec3 a, T s) { return a /= s; }
    friend constexpr bool operator==(const Vec3& a, const Vec3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
    friend constexpr bool operator!=(const Vec3& a, const Vec3& b) { return !(a == b); }
};

template<class T>
struct Vec2 {
    T x{}, y{};
    constexpr Vec2() = default;
    constexpr Vec2(T a, T b) : x(a), y(b) {}
    friend constexpr Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
    friend constexpr Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
    friend constexpr Vec2 operator*(Vec2 a, T s) { return {a.x * s, a.y * s}; }
    friend constexpr bool operator==(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }
};

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;
using Vec3i = Vec3<int>;
using Vec2f = Vec2<float>;
using Vec2d = Vec2<double>;
/// Linear Rec.709 colour, or one coefficient per channel.
using Rgb = Vec3f;

template<class T>
constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template<class T>
constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template<class T>
T length(const Vec3<T>& v) {
    return std::sqrt(dot(v, v));
}
/// Unit vector along v; v itself where its length is zero or not finite.
template<class T>
Vec3<T> normalize(const Vec3<T>& v) {
    const T l = length(v);
    return l > T(0) && std::isfinite(l) ? v / l : v;
}
template<class T>
constexpr T maxComponent(const Vec3<T>& v) {
    return std::max(v.x, std::max(v.y, v.z));
}
template<class T>
constexpr T minComponent(const Vec3<T>& v) {
    return std::min(v.x, std::min(v.y, v.z));
}
template<class T>
constexpr T average(const Vec3<T>& v) {
    return (v.x + v.y + v.z) / T(3);
}
template<class T>
Vec3<T> exp(const Vec3<T>& v) {
    return {std::exp(v.x), std::exp(v.y), std::exp(v.z)};
}
template<class T>
bool isFinite(const Vec3<T>& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
/// Relative luminance of linear Rec.709 (ITU-R BT.709).
inline float luminance(const Rgb& c) {
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

/// Largest whole number not above x, for |x| < 2^31: without a call where the processor has no instruction for it.
template<class T>
T quickFloor(T x) {
    const int whole = int(x);
    return T(whole - (x < T(whole) ? 1 : 0));
}

/// Two unit vectors that make a right-handed frame (t, b, n) with the unit vector n.
/// Branch-free form of Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
template<class T>
void orthonormalBasis(const Vec3<T>& n, Vec3<T>& t, Vec3<T>& b) {
    const T sign = std::copysign(T(1), n.z);
    const T a = T(-1) / (sign + n.z);
    const T c = n.x * n.y * a;
    t = {T(1) + sign * n.x * n.x * a, sign * c, -sign * n.x};
    b = {c, sign + n.y * n.y * a, -n.y};
}

/// Axis-aligned box; empty until something was added.
struct Box3f {
    Vec3f lo{1e30f}, hi{-1e30f};
    void add(const Vec3f& p) {
        lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
        hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
    }
    bool empty() const { return lo.x > hi.x; }
    /// Whether both have a point in common, their faces included.
    bool overlaps(const Box3f& b) const {
        return lo.x <= b.hi.x && b.lo.x <= hi.x && lo.y <= b.hi.y && b.lo.y <= hi.y && lo.z <= b.hi.z && b.lo.z <= hi.z;
    }
    float diagonal() const { return empty() ? 0.0f : length(hi - lo); }
};

} // namespace stf
