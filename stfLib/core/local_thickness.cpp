// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/local_thickness.h"

#include <limits>

namespace stf {

namespace {
struct Ring {
    int rays;
    float cosine, sine;
};
constexpr Ring kRings[] = {{1, 1, 0}, {4, 0.8191520f, 0.5735764f}, {6, 0.5f, 0.8660254f}}; // 0, 35, 60 degrees
} // namespace

float localThickness(const RayMesh& mesh, const Vec3f& point, const Vec3f& inward) {
    const Box3f box = mesh.innerBounds();
    const float lift = 2e-6f * std::max(box.diagonal(), std::max(length(box.lo), length(box.hi)));
    Vec3f x, y;
    orthonormalBasis(inward, x, y);
    float least = std::numeric_limits<float>::infinity();
    for (const Ring& ring : kRings) {
        for (int i = 0; i < ring.rays; ++i) {
            const float phi = 6.2831853f * (float(i) + 0.25f) / float(ring.rays);
            Ray ray;
            ray.origin = point + inward * lift;
            ray.direction = x * (ring.sine * std::cos(phi)) + y * (ring.sine * std::sin(phi)) + inward * ring.cosine;
            ray.tFar = std::min(least, 1e30f);
            RayHit hit;
            if (mesh.intersect(ray, hit, 2)) {
                least = hit.t;
            }
        }
    }
    return least;
}

} // namespace stf
