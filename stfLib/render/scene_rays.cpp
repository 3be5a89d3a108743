// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/scene_rays.h"

#include "stfLib/render/surfel.h"

namespace stf {

namespace {
constexpr int kMaxClearSurfaces = 64; // along one shadow ray
}

Rgb SceneRays::visibility(const Vec3f& origin, const LightSample& light) {
    if (!light.shadows) {
        return Rgb(1.0f);
    }
    if (wayOut_) {
        return fromWithin(origin, light);
    }
    const Ray ray = shadowRay(origin, light);
    if (scene_.clearSurfaces) {
        return throughSurfaces(ray);
    }
    ++count_;
    return Rgb(scene_.rays->occluded(ray, time_) ? 0.0f : 1.0f);
}

const PreparedInstance& SceneRays::moved(const PreparedInstance& placed) {
    Moved& m = moved_[placed.index];
    if (m.timeVersion == 0) {
        // What light needs of a place; the core's radiance stays with the scene.
        m.instance.mesh = placed.mesh;
        m.instance.material = placed.material;
        m.instance.primId = placed.primId;
        m.instance.instanceId = placed.instanceId;
        m.instance.index = placed.index;
        m.instance.overlapped = placed.overlapped;
    }
    if (m.timeVersion != timeVersion_) {
        m.timeVersion = timeVersion_;
        m.instance.objectToWorld = atTime(placed.motion, time_);
        m.instance.worldToObject = m.instance.objectToWorld.inverse();
    }
    return m.instance;
}

Rgb SceneRays::fromWithin(Vec3f origin, LightSample light) {
    WayOut wayOut;
    wayOut.swap(wayOut_); // beyond there is none
    Rgb left = wayOut(origin, light);
    if (maxComponent(left) > 0) {
        left *= visibility(origin, light);
    }
    wayOut.swap(wayOut_);
    return left;
}

Rgb SceneRays::throughSurface(const PreparedInstance& instance, const Ray& ray, const RayHit& hit) {
    if (!instance.material || instance.material->opaque()) {
        return Rgb(0.0f);
    }
    const Surfel surfel = surfelAt(instance, ray, hit);
    const PreviewPoint at = instance.material->at(uvAt(*instance.mesh->surface, hit), surfel.albedo);
    return PreviewBsdf(at).through({0, 0, dot(surfel.normal, ray.direction)});
}

Rgb SceneRays::throughSurfaces(Ray ray) {
    Rgb left(1.0f);
    for (int i = 0; i < kMaxClearSurfaces; ++i) {
        RayHit hit;
        if (!intersect(ray, hit)) {
            return left;
        }
        const PreparedInstance& instance = this->instance(hit.instance);
        left *= instance.mesh->shell ? Rgb(0.0f) : throughSurface(instance, ray, hit);
        if (!(maxComponent(left) > 0)) {
            return left;
        }
        ray.tNear = hit.t * (1 + 1e-6f) + scene_.shadowOffset;
    }
    return Rgb(0.0f);
}

int SceneRays::chooseLights(const Vec3f& point, const Vec3f& normal, PixelSampler& sampler, LightPick* picks) const {
    // Nothing is drawn where there is nothing to choose.
    const float u = scene_.lights.count() > std::size_t(kMaxLightsPerPath) ? sampler.next1d() : 0.0f;
    return scene_.lights.choose(point, normal, u, kMaxLightsPerPath, picks);
}

} // namespace stf
