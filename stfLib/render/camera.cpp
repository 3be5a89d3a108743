// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/camera.h"

#include "stfLib/base/error.h"

namespace stf {

namespace {

Matrix4 multiply(const Matrix4& a, const Matrix4& b) {
    Matrix4 m{};
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
            for (std::size_t k = 0; k < 4; ++k) {
                m[i * 4 + j] += a[i * 4 + k] * b[k * 4 + j];
            }
        }
    }
    return m;
}

// Gauss-Jordan with partial pivoting; rows are scaled first, since clipping planes spread over many orders.
Matrix4 invert(Matrix4 a) {
    Matrix4 inv{};
    for (std::size_t i = 0; i < 4; ++i) {
        inv[i * 4 + i] = 1;
    }
    for (std::size_t c = 0; c < 4; ++c) {
        std::size_t pivot = c;
        for (std::size_t r = c + 1; r < 4; ++r) {
            if (std::abs(a[r * 4 + c]) > std::abs(a[pivot * 4 + c])) {
                pivot = r;
            }
        }
        const double p = a[pivot * 4 + c];
        if (!(std::abs(p) > 0) || !std::isfinite(p)) {
            throw Error("the camera's matrix is singular or not finite");
        }
        for (std::size_t k = 0; k < 4; ++k) {
            std::swap(a[c * 4 + k], a[pivot * 4 + k]);
            std::swap(inv[c * 4 + k], inv[pivot * 4 + k]);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            a[c * 4 + k] /= p;
            inv[c * 4 + k] /= p;
        }
        for (std::size_t r = 0; r < 4; ++r) {
            const double f = a[r * 4 + c];
            if (r == c || f == 0) {
                continue;
            }
            for (std::size_t k = 0; k < 4; ++k) {
                a[r * 4 + k] -= f * a[c * 4 + k];
                inv[r * 4 + k] -= f * inv[c * 4 + k];
            }
        }
    }
    return inv;
}

Vec3d project(const Matrix4& m, const Vec3d& p) {
    const double w = p.x * m[3] + p.y * m[7] + p.z * m[11] + m[15];
    return Vec3d(p.x * m[0] + p.y * m[4] + p.z * m[8] + m[12], p.x * m[1] + p.y * m[5] + p.z * m[9] + m[13],
                 p.x * m[2] + p.y * m[6] + p.z * m[10] + m[14]) /
           w;
}

Matrix4 matrixOf(const Transform& t) {
    return {t.x.x, t.x.y, t.x.z, 0, t.y.x,           t.y.y,           t.y.z,           0,
            t.z.x, t.z.y, t.z.z, 0, t.translation.x, t.translation.y, t.translation.z, 1};
}

constexpr Matrix4 kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

} // namespace

Camera::Camera()
    : worldToView_(kIdentity), projection_(kIdentity), ndcToView_(kIdentity), viewToWorld_(kIdentity),
      ndcToWorld_(kIdentity), given_(kIdentity) {}

Camera::Camera(const Matrix4& worldToView, const Matrix4& projection, const CameraOptics& optics)
    : worldToView_(worldToView), projection_(projection), ndcToView_(invert(projection)),
      viewToWorld_(invert(worldToView)),
      // Inverted one by one: the product of both loses digits where the camera is far from the origin.
      ndcToWorld_(multiply(ndcToView_, viewToWorld_)), given_(worldToView), optics_(optics),
      motion_(motionSteps(optics.viewToWorld, optics.shutter)) {
    if (!std::isfinite(optics.lens.radius) || !std::isfinite(optics.lens.focusDistance) ||
        !std::isfinite(optics.exposure)) {
        throw Error("the camera's lens or exposure is not finite");
    }
    if (moves()) {
        viewToWorld_ = matrixOf(atTime(motion_, 0.5f));
        worldToView_ = invert(viewToWorld_);
        ndcToWorld_ = multiply(ndcToView_, viewToWorld_);
    }
}

Camera Camera::pinhole() const {
    CameraOptics optics = optics_;
    optics.lens = Lens();
    return Camera(given_, projection_, optics);
}

Camera Camera::atRest() const {
    CameraOptics optics = optics_;
    optics.shutter = Shutter();
    optics.viewToWorld.clear();
    return Camera(given_, projection_, optics);
}

Ray Camera::ray(double x, double y, const Vec3d& origin) const {
    // Of the points at depths -1 and 1, homogeneous, the direction is far / wFar - near / wNear; times both w, of which
    // that of the far plane may be zero, it is this.
    const Matrix4& m = ndcToWorld_;
    const Vec3d along(m[8], m[9], m[10]);
    const Vec3d near = Vec3d(m[0], m[1], m[2]) * x + Vec3d(m[4], m[5], m[6]) * y + Vec3d(m[12], m[13], m[14]) - along;
    const double w = x * m[3] + y * m[7] + m[15] - m[11], wFar = w + 2 * m[11];
    const Vec3d direction = along * w - near * m[11];
    Ray r;
    r.origin = Vec3f(near * (1 / w) - origin);
    r.direction = Vec3f(normalize(direction)) * (w * wFar < 0 ? -1.0f : 1.0f);
    return r;
}

Ray Camera::ray(double x, double y, const Vec3d& origin, const Vec2d& onLens, float time) const {
    Vec3d near = project(ndcToView_, {x, y, -1}), far = project(ndcToView_, {x, y, 1});
    if (optics_.lens.blurs()) {
        // Through the lens's middle (perspective: of all rays; orthographic: the ray's own) goes what a pinhole sees;
        // all rays of a point of the film meet in the plane of focus.
        const Vec3d direction = far - near;
        const Vec3d middle = near - direction * (near.z / direction.z);
        const Vec3d focus = middle - direction * (optics_.lens.focusDistance / direction.z);
        const Vec3d through = middle + Vec3d(onLens.x, onLens.y, 0.0) * optics_.lens.radius;
        const Vec3d bent = (focus - through) / optics_.lens.focusDistance; // per unit of depth
        near = through - bent * near.z;
        far = near + bent;
    }
    Ray r;
    if (moves()) {
        const Transform m = atTime(motion_, time);
        r.origin = Vec3f(m.point(near) - origin);
        r.direction = Vec3f(normalize(m.vector(far - near)));
        return r;
    }
    const Vec3d worldNear = project(viewToWorld_, near);
    r.origin = Vec3f(worldNear - origin);
    r.direction = Vec3f(normalize(project(viewToWorld_, far) - worldNear));
    return r;
}

RayCone Camera::cone(double x, double y, double pixelWidth, double pixelHeight, int lensSamples) const {
    // From the plane that starts rays, so that a camera far from the origin keeps its digits.
    const Vec3d start = project(ndcToWorld_, {x, y, -1});
    const Ray here = ray(x, y, start);
    RayCone out;
    for (const Vec2d& step : {Vec2d{pixelWidth, 0}, Vec2d{0, pixelHeight}}) {
        const Ray there = ray(x + step.x, y + step.y, start);
        out.width = std::max(out.width, length(there.origin - here.origin));
        out.spread = std::max(out.spread, length(there.direction - here.direction));
    }
    const Lens& lens = optics_.lens;
    if (lens.blurs()) {
        const Vec3d near = project(ndcToView_, {x, y, -1}), far = project(ndcToView_, {x, y, 1});
        const Vec3d direction = normalize(far - near);
        const double way = (-lens.focusDistance - near.z) / direction.z; // from the near plane
        if (way > 0) {
            const double circle = 2 * lens.radius * way * -direction.z / lens.focusDistance;
            out.lens = float(circle / std::sqrt(double(std::max(1, lensSamples))));
            out.focus = float(way);
        }
    }
    return out;
}

Vec2d onUnitDisc(const Vec2f& u) {
    const double x = 2 * double(u.x) - 1, y = 2 * double(u.y) - 1;
    if (x == 0 && y == 0) {
        return {0, 0};
    }
    constexpr double kQuarter = 0.78539816339744831; // pi / 4
    const bool wide = std::abs(x) > std::abs(y);
    const double r = wide ? x : y, angle = wide ? kQuarter * y / x : 2 * kQuarter - kQuarter * x / y;
    return {r * std::cos(angle), r * std::sin(angle)};
}

double Camera::ndcDepth(const Vec3d& world) const {
    return project(projection_, project(worldToView_, world)).z;
}

double Camera::viewDepth(const Vec3d& world) const {
    return -project(worldToView_, world).z;
}

Vec3f Camera::viewNormal(const Vec3f& n) const {
    const Matrix4& m = worldToView_;
    const Vec3d v(n);
    return normalize(Vec3f(float(v.x * m[0] + v.y * m[4] + v.z * m[8]), float(v.x * m[1] + v.y * m[5] + v.z * m[9]),
                           float(v.x * m[2] + v.y * m[6] + v.z * m[10])));
}

} // namespace stf
