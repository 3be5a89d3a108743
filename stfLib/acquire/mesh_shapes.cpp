// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_shapes.h"

#include <map>
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stb_perlin.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;

TriangleMesh icosphere(int detail) {
    const double t = 0.5 * (1 + std::sqrt(5.0));
    TriangleMesh m;
    m.points = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
    m.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                   {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                   {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (int level = 0; level < detail; ++level) {
        std::map<std::pair<int, int>, int> middles;
        const auto middle = [&](int a, int b) {
            const auto [at, added] = middles.emplace(std::minmax(a, b), int(m.points.size()));
            if (added) {
                m.points.push_back(normalize(m.points[std::size_t(a)]) + normalize(m.points[std::size_t(b)]));
            }
            return at->second;
        };
        std::vector<Vec3i> finer;
        for (const Vec3i& f : m.triangles) {
            const int a = middle(f.x, f.y), b = middle(f.y, f.z), c = middle(f.z, f.x);
            finer.insert(finer.end(), {{f.x, a, c}, {f.y, b, a}, {f.z, c, b}, {a, b, c}});
        }
        m.triangles = std::move(finer);
    }
    for (Vec3d& p : m.points) {
        p = normalize(p);
    }
    return m;
}

/// Scaled evenly to a volume.
void giveVolume(TriangleMesh& m, double volume) {
    const double scale = std::cbrt(volume / signedVolume(m));
    for (Vec3d& p : m.points) {
        p *= scale;
    }
}

TriangleMesh pebble(const MeshSource& s, int detail) {
    TriangleMesh m = icosphere(detail);
    const Vec3f offset(float(s.seed % 251) * 7.31f, float(s.seed / 251 % 241) * 5.17f, float(s.seed % 97) * 3.77f);
    for (Vec3d& p : m.points) {
        const auto noise = [&](float frequency) {
            const Vec3f q = Vec3f(p) * frequency + offset;
            return double(stb_perlin_noise3_seed(q.x, q.y, q.z, 0, 0, 0, int(s.seed & 0xff)));
        };
        p *= std::max(0.05, 1 + s.roughness * (1.4 * noise(1.3f) + 0.5 * noise(3.1f)));
    }
    giveVolume(m, kPi / 6);
    return m;
}

/// Walls between two rings of points of equal number; `lower` and `upper` are the first points.
void addWall(TriangleMesh& m, int lower, int upper, int next, int nextUpper) {
    m.triangles.push_back({lower, next, nextUpper});
    m.triangles.push_back({lower, nextUpper, upper});
}

TriangleMesh cylinder(int detail) {
    const int n = 8 << detail;
    TriangleMesh m;
    for (const double z : {-0.5, 0.5}) {
        m.points.push_back({0, 0, z});
        for (int i = 0; i < n; ++i) {
            const double angle = 2 * kPi * i / n;
            m.points.push_back({0.5 * std::cos(angle), 0.5 * std::sin(angle), z});
        }
    }
    for (int i = 0; i < n; ++i) {
        const int a = 1 + i, b = 1 + (i + 1) % n, up = n + 1;
        m.triangles.push_back({0, b, a});
        m.triangles.push_back({up, up + a, up + b});
        addWall(m, a, up + a, b, up + b);
    }
    // Across, the polygon has less than the circle.
    const double widen = std::sqrt(kPi / 4 / signedVolume(m));
    for (Vec3d& p : m.points) {
        p.x *= widen;
        p.y *= widen;
    }
    return m;
}

TriangleMesh box() {
    TriangleMesh m;
    for (int k = 0; k < 8; ++k) {
        m.points.push_back({(k & 1) - 0.5, (k >> 1 & 1) - 0.5, (k >> 2) - 0.5});
    }
    m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return m;
}

TriangleMesh layer(const MeshSource& s, const Vec3d& extentMm) {
    const int n = s.waveMm > 0 ? std::min(16 * s.cells, 256) : 1, row = n + 1;
    TriangleMesh m;
    const auto wave = [&](int x, int y, std::uint64_t salt) {
        const float f = float(s.cells) / float(n);
        return s.waveMm * 1.6 *
               double(stb_perlin_noise3_wrap_nonpow2(float(x) * f, float(y) * f, 0.5f, s.cells, s.cells, 256,
                                                     static_cast<unsigned char>(s.seed * 2 + salt)));
    };
    for (int side = 0; side < 2; ++side) {
        for (int y = 0; y <= n; ++y) {
            for (int x = 0; x <= n; ++x) {
                // The same at both ends of the tile, whatever the noise rounds to.
                double top = -s.depthMm.x, bottom = -s.depthMm.y;
                if (s.waveMm > 0) {
                    top += wave(x % n, y % n, 0);
                    bottom += wave(x % n, y % n, 1);
                }
                // Where the waves would cross, next to nothing is left of the layer: a film keeps it one closed body.
                m.points.push_back(
                    {extentMm.x * x / n, extentMm.y * y / n, side ? top : std::min(bottom, top - 1e-6 * extentMm.z)});
            }
        }
    }
    const int up = row * row;
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            const int a = x + row * y, b = a + 1, c = a + row, d = c + 1;
            m.triangles.insert(m.triangles.end(),
                               {{a, c, b}, {b, c, d}, {up + a, up + b, up + c}, {up + b, up + d, up + c}});
        }
    }
    for (int i = 0; i < n; ++i) {
        addWall(m, i, up + i, i + 1, up + i + 1);
        addWall(m, row * n + i + 1, up + row * n + i + 1, row * n + i, up + row * n + i);
        addWall(m, row * (i + 1), up + row * (i + 1), row * i, up + row * i);
        addWall(m, row * i + n, up + row * i + n, row * (i + 1) + n, up + row * (i + 1) + n);
    }
    return m;
}

Transform rotation(const Vec3d& degrees) {
    Transform all;
    for (int axis = 0; axis < 3; ++axis) {
        const double angle = degrees[axis] * kPi / 180;
        // Right angles are exact.
        const auto exact = [](double v) { return std::abs(v) < 1e-15 ? 0.0 : v; };
        const double c = exact(std::cos(angle)), s = exact(std::sin(angle));
        Transform r;
        if (axis == 0) {
            r.y = {0, c, s};
            r.z = {0, -s, c};
        } else if (axis == 1) {
            r.x = {c, 0, -s};
            r.z = {s, 0, c};
        } else {
            r.x = {c, s, 0};
            r.y = {-s, c, 0};
        }
        all = compose(r, all);
    }
    return all;
}

Transform scaling(const Vec3d& s) {
    Transform t;
    t.x.x = s.x;
    t.y.y = s.y;
    t.z.z = s.z;
    return t;
}

Transform scaledAndTurned(const MeshPlacement& p) {
    return compose(rotation(p.rotateDegrees), scaling(p.scale));
}

/// Scales about `from`, which goes to `to`.
Transform about(const Vec3d& from, const Vec3d& scale, const Vec3d& to) {
    Transform t = scaling(scale);
    t.translation = to - from * scale;
    return t;
}

} // namespace

TriangleMesh makeShape(const MeshSource& source, const Vec3d& extentMm, int detail) {
    switch (source.shape) {
    case MeshSource::Shape::Sphere: {
        TriangleMesh m = icosphere(detail);
        giveVolume(m, kPi / 6);
        return m;
    }
    case MeshSource::Shape::Pebble:
        return pebble(source, detail);
    case MeshSource::Shape::Cylinder:
        return cylinder(detail);
    case MeshSource::Shape::Box:
        return box();
    case MeshSource::Shape::Layer:
        return layer(source, extentMm);
    case MeshSource::Shape::None:
        break;
    }
    throw Error("a mesh from a file is not a shape");
}

Transform placementOf(const MeshPlacement& p, const TriangleMesh& mesh, const Vec3d& extentMm) {
    Transform t = scaledAndTurned(p);
    if (p.fit > 0) {
        const Box3d bounds = boundsOf(transformed(mesh, t));
        const Vec3d size = bounds.size();
        double scale = 1e300;
        for (int k = 0; k < 3; ++k) {
            scale = size[k] > 0 ? std::min(scale, extentMm[k] / size[k]) : scale;
        }
        if (scale == 1e300) {
            throw Error("is a point and cannot be made to fit");
        }
        t = compose(about(bounds.middle(), Vec3d(p.fit * scale), extentMm * Vec3d(0.5, 0.5, -0.5)), t);
    }
    t.translation += p.translateMm;
    return t;
}

Transform reliefPlacementOf(const MeshPlacement& p, const TriangleMesh& mesh, const Vec3d& extentMm) {
    Transform t = scaledAndTurned(p);
    if (p.fit > 0) {
        const Box3d bounds = boundsOf(transformed(mesh, t));
        const Vec3d size = bounds.size();
        if (!(size.x > 0 && size.y > 0)) {
            throw Error("has no width and cannot be stretched over the tile");
        }
        const Vec3d scale(extentMm.x / size.x, extentMm.y / size.y,
                          p.fit * std::sqrt(extentMm.x / size.x * extentMm.y / size.y));
        t = compose(about({bounds.lo.x, bounds.lo.y, bounds.hi.z}, scale, Vec3d(0.0)), t);
    }
    t.translation += p.translateMm;
    return t;
}

} // namespace stf
