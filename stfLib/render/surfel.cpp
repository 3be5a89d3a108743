// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/surfel.h"

#include "stfLib/render/surface_point.h"

namespace stf {

namespace {

const Rgb kDefaultColor(0.5f);

} // namespace

RayHit hitAt(const PreparedInstance& instance, const TrianglePlace& place) {
    const RefinedSurface& s = *instance.mesh->surface;
    const Vec3i& t = s.triangles[place.triangle];
    const Vec3f& a = s.points[std::size_t(t.x)];
    RayHit hit;
    hit.geometricNormal = cross(s.points[std::size_t(t.y)] - a, s.points[std::size_t(t.z)] - a);
    hit.u = place.b1;
    hit.v = place.b2;
    hit.instance = instance.index;
    hit.triangle = place.triangle;
    return hit;
}

Rgb exitantAt(const PreparedInstance& instance, std::uint32_t triangle, float u, float v) {
    return instance.exitant.empty()
               ? Rgb(0.0f)
               : betweenCorners(instance.exitant, instance.mesh->surface->triangles[triangle], u, v);
}

Vec2f uvAt(const RefinedSurface& s, const RayHit& hit) {
    return s.uvTriangles.empty() ? Vec2f() : betweenCorners(s.uvs, s.uvTriangles[hit.triangle], hit.u, hit.v);
}

Vec3f uvTangent(const RefinedSurface& s, std::uint32_t triangle, bool& mirrored) {
    mirrored = false;
    if (s.uvTriangles.empty()) {
        return Vec3f(0.0f);
    }
    const Vec3i &t = s.triangles[triangle], &w = s.uvTriangles[triangle];
    const Vec3f& a = s.points[std::size_t(t.x)];
    const Vec3f e1 = s.points[std::size_t(t.y)] - a, e2 = s.points[std::size_t(t.z)] - a;
    const Vec2f c = s.uvs[std::size_t(w.x)], d1 = s.uvs[std::size_t(w.y)] - c, d2 = s.uvs[std::size_t(w.z)] - c;
    const float area = d1.x * d2.y - d1.y * d2.x;
    mirrored = area < 0;
    return area != 0 ? (e1 * d2.y - e2 * d1.y) * (mirrored ? -1.0f : 1.0f) : Vec3f(0.0f);
}

Surfel surfelAt(const PreparedInstance& instance, const Ray& ray, const RayHit& hit) {
    const RefinedSurface& s = *instance.mesh->surface;
    const Vec3i& t = s.triangles[hit.triangle];
    const Vec3f p = betweenCorners(s.points, t, hit.u, hit.v);
    // Shadow rays start from the smooth surface, else facets show at the terminator (Hanika 2021, "Hacking the shadow
    // terminator", Ray Tracing Gems II): the mean of the projections onto the corners' tangent planes.
    Vec3f lifted = p;
    const float weight[3] = {1 - hit.u - hit.v, hit.u, hit.v};
    for (int k = 0; k < 3 && !s.normals.empty() && s.cornerNormals.empty(); ++k) {
        const std::size_t i = std::size_t(t[k]);
        lifted -= s.normals[i] * (weight[k] * std::min(0.0f, dot(p - s.points[i], s.normals[i])));
    }
    Surfel out;
    out.triangle = hit.triangle;
    out.u = hit.u;
    out.v = hit.v;
    out.point = ray.origin + ray.direction * hit.t;
    out.normal = instance.worldNormal(smoothNormal(s, hit));
    out.objectPoint = p;
    out.shadowOrigin = lifted;
    out.albedo = s.colors.empty() ? kDefaultColor : betweenCorners(s.colors, t, hit.u, hit.v);
    return out;
}

} // namespace stf
