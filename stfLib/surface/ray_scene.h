// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/transform.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace stf {

/// A ray of Embree's kind; `direction` need not be unit, distances are in its units.
struct Ray {
    Vec3f origin;
    float tNear = 0;
    Vec3f direction;
    float tFar = 1e30f;
};

struct RayHit {
    float t = 0;
    Vec3f geometricNormal; ///< object space of the mesh, not normalised, right-hand rule of the triangle
    float u = 0, v = 0;    ///< barycentric: (1-u-v) a + u b + v c
    std::uint32_t instance = 0;
    std::uint32_t geometry = 0; ///< 0: the (outer) surface, 1: inner boundary
    std::uint32_t triangle = 0;
};

/// Triangles of one mesh in object space: the surface and, for a shell, its inner boundary. Robust flag on: rays along
/// shared edges hit one of the triangles. Immutable after construction.
class RayMesh {
public:
    RayMesh(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles,
            const std::vector<Vec3f>& innerPoints = {});
    ~RayMesh();
    RayMesh(const RayMesh&) = delete;
    RayMesh& operator=(const RayMesh&) = delete;

    /// Nearest hit in object space; geometry 0 and 1. `mask`: bit 0 the surface, bit 1 the inner boundary.
    bool intersect(const Ray& objectRay, RayHit& hit, unsigned mask = 3) const;
    bool occluded(const Ray& objectRay, unsigned mask = 1) const;
    /// Distance from a point to the inner boundary, at most `limit`, which is given where nothing is nearer.
    float innerDistance(const Vec3f& objectPoint, float limit) const;
    /// Empty without an inner boundary.
    Box3f innerBounds() const;

    struct Impl;
    const Impl& impl() const { return *impl_; }

private:
    std::unique_ptr<Impl> impl_;
};

struct RayInstance {
    std::shared_ptr<const RayMesh> mesh;
    Transform objectToWorld;
    /// Of an instance that moves: at least two steps (at most 129), even in time, matrix elements linear in between.
    std::vector<Transform> motion;
    std::uint32_t id = 0; ///< returned as RayHit::instance
    bool visible = true;
};

constexpr int kMostTogether = 16;

/// All instances in world space. Only surfaces (geometry 0) take part in world-space queries; the march asks the mesh
/// for its inner boundary. Immutable after construction; queries from any number of threads.
class RayScene {
public:
    explicit RayScene(const std::vector<RayInstance>& instances);
    ~RayScene();
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    /// `time`: 0 (first step of motion) to 1 (last).
    bool intersect(const Ray& worldRay, RayHit& hit, float time = 0.5f) const;
    /// The same for up to kMostTogether rays that start and go much alike, as those of neighbouring pixels, each at a
    /// time of its own: several times as fast as one by one. `met`: which of them hit something.
    void intersectTogether(const Ray* worldRays, const float* times, int count, RayHit* hits, bool* met) const;
    bool occluded(const Ray& worldRay, float time = 0.5f) const;
    /// Of all instances at all times.
    Box3f bounds() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace stf
