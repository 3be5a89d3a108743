// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/core/core_response.h"

#include <map>
#include <memory>

namespace stf::test {

/// A closed boundary with all that a core is made from.
struct CoreShape {
    std::vector<Vec3f> points;
    std::vector<Vec3i> triangles;
    std::vector<Vec3f> normals;
    std::unique_ptr<RayMesh> mesh;
    BoundarySamples samples;

    void finish(std::size_t wanted, std::uint64_t seed = 1) {
        mesh = std::make_unique<RayMesh>(points, triangles, points);
        samples = spreadSamples(points, triangles, wanted, seed);
    }
    CoreResponse response(const CoreMaterial& m, CoreModel model, std::uint64_t seed = 1) const {
        Progress progress;
        return CoreResponse(m, {points, triangles, normals, *mesh, samples, 1.0}, model, seed, progress, 600'000);
    }
};

/// Six faces with corners of their own, outward.
inline CoreShape box(const Vec3f& size, std::size_t samples = 0) {
    CoreShape s;
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3, first = int(s.points.size());
            Vec3f normal(0.0f);
            normal[axis] = side ? 1.0f : -1.0f;
            for (int k = 0; k < 4; ++k) {
                Vec3f p;
                p[axis] = 0.5f * size[axis] * normal[axis];
                p[u] = (k == 1 || k == 2 ? 0.5f : -0.5f) * size[u];
                p[v] = (k >= 2 ? 0.5f : -0.5f) * size[v];
                s.points.push_back(p);
                s.normals.push_back(normal);
            }
            for (const Vec3i& t : {Vec3i{0, 1, 2}, Vec3i{0, 2, 3}}) {
                s.triangles.push_back(side ? Vec3i{first + t.x, first + t.y, first + t.z}
                                           : Vec3i{first + t.x, first + t.z, first + t.y});
            }
        }
    }
    s.finish(samples);
    return s;
}

/// By rings and meridians.
inline CoreShape ball(float radius, std::size_t samples = 0, int rings = 48) {
    CoreShape s;
    const int around = 2 * rings;
    for (int i = 0; i <= rings; ++i) {
        for (int j = 0; j < around; ++j) {
            const float theta = 3.14159265f * float(i) / float(rings), phi = 6.28318531f * float(j) / float(around);
            s.normals.push_back({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
            s.points.push_back(s.normals.back() * radius);
            // One point for each pole.
            s.points.back() = i == 0 || i == rings ? Vec3f(0, 0, i == 0 ? radius : -radius) : s.points.back();
        }
    }
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < around; ++j) {
            const int a = i * around + j, b = i * around + (j + 1) % around, c = a + around, d = b + around;
            if (i + 1 < rings) {
                s.triangles.push_back({a, c, d});
            }
            if (i > 0) {
                s.triangles.push_back({a, d, b});
            }
        }
    }
    s.finish(samples);
    return s;
}

} // namespace stf::test
