// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/ray_scene.h"

#include "stfLib/base/error.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <array>
#include <iterator>

namespace stf {

namespace {

/// One device per process, made at the first use and never released: hosts unload plug-ins in any order, and Embree's
/// threads must not outlive a static destructor.
RTCDevice sharedDevice() {
    static RTCDevice const device = rtcNewDevice(nullptr);
    if (!device) {
        throw Error("Embree cannot be started");
    }
    return device;
}

/// Owns an Embree scene.
class Scene {
public:
    Scene() : scene_(rtcNewScene(sharedDevice())) { rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST); }
    ~Scene() { rtcReleaseScene(scene_); }
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;
    RTCScene get() const { return scene_; }

private:
    RTCScene scene_;
};

void addTriangles(RTCScene scene, const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles) {
    RTCGeometry geometry = rtcNewGeometry(sharedDevice(), RTC_GEOMETRY_TYPE_TRIANGLE);
    // Buffers made by Embree are padded as its 16-byte loads need.
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), points.size()));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                   3 * sizeof(unsigned), triangles.size()));
    if (!vertices || !indices) {
        rtcReleaseGeometry(geometry);
        throw Error("Embree has no memory for " + std::to_string(triangles.size()) + " triangles");
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        vertices[3 * i] = points[i].x;
        vertices[3 * i + 1] = points[i].y;
        vertices[3 * i + 2] = points[i].z;
    }
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        indices[3 * i] = unsigned(triangles[i].x);
        indices[3 * i + 1] = unsigned(triangles[i].y);
        indices[3 * i + 2] = unsigned(triangles[i].z);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
}

using Columns = std::array<float, 12>;

Columns columnsOf(const Transform& m) {
    return {float(m.x.x), float(m.x.y),           float(m.x.z),           float(m.y.x),
            float(m.y.y), float(m.y.z),           float(m.z.x),           float(m.z.y),
            float(m.z.z), float(m.translation.x), float(m.translation.y), float(m.translation.z)};
}

bool traceable(const Ray& ray) {
    return isFinite(ray.origin) && isFinite(ray.direction) && dot(ray.direction, ray.direction) > 0 &&
           ray.tNear <= ray.tFar;
}

void fill(const Ray& ray, float time, RTCRay& out) {
    out.org_x = ray.origin.x;
    out.org_y = ray.origin.y;
    out.org_z = ray.origin.z;
    out.tnear = std::max(0.0f, ray.tNear);
    out.dir_x = ray.direction.x;
    out.dir_y = ray.direction.y;
    out.dir_z = ray.direction.z;
    out.time = time;
    out.tfar = ray.tFar;
    out.mask = ~0u;
    out.id = 0;
    out.flags = 0;
}

/// Nearest hit nearer than `ray.tFar`; `instance` receives the number of the instance in the scene.
bool nearest(RTCScene scene, const Ray& ray, float time, RayHit& hit, unsigned* instance) {
    RTCRayHit rayHit;
    fill(ray, time, rayHit.ray);
    rayHit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayHit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene, &rayHit);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &rayHit);
#endif
    if (rayHit.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
        return false;
    }
    hit.t = rayHit.ray.tfar;
    hit.geometricNormal = {rayHit.hit.Ng_x, rayHit.hit.Ng_y, rayHit.hit.Ng_z};
    hit.u = rayHit.hit.u;
    hit.v = rayHit.hit.v;
    hit.triangle = rayHit.hit.primID;
    if (instance) {
        *instance = rayHit.hit.instID[0];
    }
    return true;
}

/// Sixteen rays are traced as one where the processor has vectors of sixteen.
bool tracesSixteen() {
    static const bool native = rtcGetDeviceProperty(sharedDevice(), RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
    return native;
}

void nearestOfSixteen(RTCScene scene, const int* valid, RTCRayHit16& rayHits) {
#if RTC_VERSION_MAJOR >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &rayHits, &arguments);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &context, &rayHits);
#endif
}

bool anyHit(RTCScene scene, const Ray& ray, float time) {
    RTCRay rtcRay;
    fill(ray, time, rtcRay);
#if RTC_VERSION_MAJOR >= 4
    rtcOccluded1(scene, &rtcRay);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &rtcRay);
#endif
    return rtcRay.tfar < 0;
}

// Squared distance from p to the triangle a b c (Ericson 2005, "Real-Time Collision Detection", 5.1.5).
float distance2(const Vec3f& p, const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    const auto to = [&](const Vec3f& q) { return dot(p - q, p - q); };
    const Vec3f ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const float d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
                d6 = dot(ac, cp);
    if (d1 <= 0 && d2 <= 0) {
        return to(a);
    }
    if (d3 >= 0 && d4 <= d3) {
        return to(b);
    }
    if (d6 >= 0 && d5 <= d6) {
        return to(c);
    }
    const float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        return to(a + ab * (d1 / (d1 - d3)));
    }
    if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        return to(a + ac * (d2 / (d2 - d6)));
    }
    if (va <= 0 && d4 >= d3 && d5 >= d6) {
        return to(b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
    }
    const float sum = va + vb + vc;
    return sum > 0 ? to(a + ab * (vb / sum) + ac * (vc / sum)) : std::min(to(a), std::min(to(b), to(c)));
}

struct Buffers {
    const float* points;
    const unsigned* triangles;
};

bool nearerTriangle(RTCPointQueryFunctionArguments* args) {
    const Buffers& buffers = *static_cast<const Buffers*>(args->userPtr);
    const unsigned* const t = buffers.triangles + 3 * std::size_t(args->primID);
    const auto at = [&](unsigned i) {
        const float* const p = buffers.points + 3 * std::size_t(i);
        return Vec3f(p[0], p[1], p[2]);
    };
    const float d =
        std::sqrt(distance2({args->query->x, args->query->y, args->query->z}, at(t[0]), at(t[1]), at(t[2])));
    if (!(d < args->query->radius)) {
        return false;
    }
    args->query->radius = d;
    return true;
}

} // namespace

/// Surface and inner boundary are scenes of their own: Embree's ray masks are a build option, and instances show the
/// surface only.
struct RayMesh::Impl {
    Scene surface;
    std::unique_ptr<Scene> inner;
};

RayMesh::RayMesh(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles,
                 const std::vector<Vec3f>& innerPoints)
    : impl_(std::make_unique<Impl>()) {
    if (!innerPoints.empty() && innerPoints.size() != points.size()) {
        throw Error("the inner boundary has another number of points than the surface");
    }
    for (const Vec3i& t : triangles) {
        for (int c = 0; c < 3; ++c) {
            if (t[c] < 0 || std::size_t(t[c]) >= points.size()) {
                throw Error("a triangle names a point that does not exist");
            }
        }
    }
    if (!triangles.empty()) {
        addTriangles(impl_->surface.get(), points, triangles);
    }
    rtcCommitScene(impl_->surface.get());
    if (!innerPoints.empty()) {
        impl_->inner = std::make_unique<Scene>();
        if (!triangles.empty()) {
            addTriangles(impl_->inner->get(), innerPoints, triangles);
        }
        rtcCommitScene(impl_->inner->get());
    }
}

RayMesh::~RayMesh() = default;

bool RayMesh::intersect(const Ray& objectRay, RayHit& hit, unsigned mask) const {
    if (!traceable(objectRay)) {
        return false;
    }
    Ray ray = objectRay;
    bool found = false;
    if ((mask & 1u) && nearest(impl_->surface.get(), ray, 0, hit, nullptr)) {
        hit.geometry = 0;
        ray.tFar = hit.t;
        found = true;
    }
    if ((mask & 2u) && impl_->inner && nearest(impl_->inner->get(), ray, 0, hit, nullptr)) {
        hit.geometry = 1;
        found = true;
    }
    if (found) {
        hit.instance = 0;
    }
    return found;
}

bool RayMesh::occluded(const Ray& objectRay, unsigned mask) const {
    return traceable(objectRay) && (((mask & 1u) && anyHit(impl_->surface.get(), objectRay, 0)) ||
                                    ((mask & 2u) && impl_->inner && anyHit(impl_->inner->get(), objectRay, 0)));
}

float RayMesh::innerDistance(const Vec3f& objectPoint, float limit) const {
    RTCGeometry const geometry = impl_->inner ? rtcGetGeometry(impl_->inner->get(), 0) : nullptr;
    if (!geometry || !isFinite(objectPoint)) {
        return limit;
    }
    Buffers buffers{static_cast<const float*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0)),
                    static_cast<const unsigned*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_INDEX, 0))};
    RTCPointQuery query;
    query.x = objectPoint.x;
    query.y = objectPoint.y;
    query.z = objectPoint.z;
    query.radius = limit;
    query.time = 0;
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(impl_->inner->get(), &query, &context, nearerTriangle, &buffers);
    return query.radius;
}

Box3f RayMesh::innerBounds() const {
    Box3f box;
    if (impl_->inner) {
        RTCBounds b;
        rtcGetSceneBounds(impl_->inner->get(), &b);
        if (b.lower_x <= b.upper_x) {
            box.add({b.lower_x, b.lower_y, b.lower_z});
            box.add({b.upper_x, b.upper_y, b.upper_z});
        }
    }
    return box;
}

struct RayScene::Impl {
    Scene scene;
    std::vector<std::uint32_t> ids;                     ///< by Embree's number of the instance
    std::vector<std::shared_ptr<const RayMesh>> meshes; ///< kept alive as long as the scene
};

RayScene::RayScene(const std::vector<RayInstance>& instances) : impl_(std::make_unique<Impl>()) {
    for (const RayInstance& instance : instances) {
        if (!instance.visible || !instance.mesh || !instance.objectToWorld.invertible()) {
            continue;
        }
        std::vector<Columns> steps;
        if (instance.motion.size() > 1) {
            std::transform(instance.motion.begin(), instance.motion.end(), std::back_inserter(steps), columnsOf);
        } else {
            steps.push_back(columnsOf(instance.objectToWorld));
        }
        const auto representable = [](const Columns& columns) {
            return std::all_of(columns.begin(), columns.end(), [](float f) { return std::abs(f) < 1e18f; });
        };
        if (!std::all_of(steps.begin(), steps.end(), representable)) {
            continue;
        }
        RTCGeometry geometry = rtcNewGeometry(sharedDevice(), RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, instance.mesh->impl().surface.get());
        rtcSetGeometryTimeStepCount(geometry, unsigned(steps.size()));
        for (std::size_t i = 0; i < steps.size(); ++i) {
            rtcSetGeometryTransform(geometry, unsigned(i), RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, steps[i].data());
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(impl_->scene.get(), geometry, unsigned(impl_->ids.size()));
        rtcReleaseGeometry(geometry);
        impl_->ids.push_back(instance.id);
        impl_->meshes.push_back(instance.mesh);
    }
    rtcCommitScene(impl_->scene.get());
}

RayScene::~RayScene() = default;

bool RayScene::intersect(const Ray& worldRay, RayHit& hit, float time) const {
    unsigned instance = 0;
    if (!traceable(worldRay) || !nearest(impl_->scene.get(), worldRay, time, hit, &instance)) {
        return false;
    }
    hit.geometry = 0;
    hit.instance = impl_->ids[instance];
    return true;
}

void RayScene::intersectTogether(const Ray* rays, const float* times, int count, RayHit* hits, bool* met) const {
    if (count <= 0) {
        return;
    }
    if (!tracesSixteen()) {
        for (int i = 0; i < count; ++i) {
            met[i] = intersect(rays[i], hits[i], times[i]);
        }
        return;
    }
    static_assert(kMostTogether == 16);
    alignas(64) int valid[kMostTogether] = {};
    RTCRayHit16 all;
    for (int i = 0; i < kMostTogether; ++i) {
        const Ray& ray = rays[std::min(i, count - 1)];
        valid[i] = i < count && traceable(ray) ? -1 : 0;
        all.ray.org_x[i] = ray.origin.x;
        all.ray.org_y[i] = ray.origin.y;
        all.ray.org_z[i] = ray.origin.z;
        all.ray.tnear[i] = std::max(0.0f, ray.tNear);
        all.ray.dir_x[i] = ray.direction.x;
        all.ray.dir_y[i] = ray.direction.y;
        all.ray.dir_z[i] = ray.direction.z;
        all.ray.time[i] = times[std::min(i, count - 1)];
        all.ray.tfar[i] = ray.tFar;
        all.ray.mask[i] = ~0u;
        all.ray.id[i] = all.ray.flags[i] = 0;
        all.hit.geomID[i] = all.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    nearestOfSixteen(impl_->scene.get(), valid, all);
    for (int i = 0; i < count; ++i) {
        met[i] = valid[i] && all.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        if (met[i]) {
            RayHit& hit = hits[i];
            hit.t = all.ray.tfar[i];
            hit.geometricNormal = {all.hit.Ng_x[i], all.hit.Ng_y[i], all.hit.Ng_z[i]};
            hit.u = all.hit.u[i];
            hit.v = all.hit.v[i];
            hit.triangle = all.hit.primID[i];
            hit.geometry = 0;
            hit.instance = impl_->ids[all.hit.instID[0][i]];
        }
    }
}

bool RayScene::occluded(const Ray& worldRay, float time) const {
    return traceable(worldRay) && anyHit(impl_->scene.get(), worldRay, time);
}

Box3f RayScene::bounds() const {
    Box3f box;
    if (impl_->ids.empty()) {
        return box;
    }
    RTCBounds b;
    rtcGetSceneBounds(impl_->scene.get(), &b);
    if (b.lower_x <= b.upper_x) {
        box.add({b.lower_x, b.lower_y, b.lower_z});
        box.add({b.upper_x, b.upper_y, b.upper_z});
    }
    return box;
}

} // namespace stf
