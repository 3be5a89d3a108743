// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/scene_rays.h"

#include "stfLib/render/shells_compiled.h"
#include "stfLib/render/surfel.h"

namespace stf {

namespace {
constexpr int kMaxClearSurfaces = 64; // along one shadow ray
}

Rgb SceneRays::visibility(const Vec3f& origin, const LightSample& light, PixelSampler* throughShells) {
    if (light.lit != 0 && (light.lit & receiver_) == 0) {
        return Rgb(0.0f);
    }
    if (!light.shadows) {
        return Rgb(1.0f);
    }
    if (kShellsCompiled && wayOut_) {
        return fromWithin(origin, light, throughShells);
    }
    const Ray ray = shadowRay(origin, light);
    const bool shells = kShellsCompiled && throughShells && scene_.clearShells;
    if (!scene_.clearSurfaces) {
        ++count_;
        if (!scene_.rays->occluded(ray, time_)) {
            return Rgb(1.0f);
        }
        if (!shells && light.shading == 0) {
            return Rgb(0.0f);
        }
    }
    return throughSurfaces(ray, light.shading, shells ? throughShells : nullptr);
}

const PreparedInstance& SceneRays::moved(const PreparedInstance& placed) {
    Moved& m = moved_[placed.index];
    if (m.timeVersion == 0) {
        // What light needs of a place; the core's radiance stays with the scene.
        m.instance.mesh = placed.mesh;
        m.instance.material = placed.material;
        m.instance.primId = placed.primId;
        m.instance.instanceId = placed.instanceId;
        m.instance.objectId = placed.objectId;
        m.instance.links = placed.links;
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

Rgb SceneRays::fromWithin(Vec3f origin, LightSample light, PixelSampler* throughShells) {
    WayOut wayOut;
    wayOut.swap(wayOut_); // beyond there is none
    Rgb left = wayOut(origin, light);
    if (maxComponent(left) > 0) {
        left *= visibility(origin, light, throughShells);
    }
    wayOut.swap(wayOut_);
    return left;
}

Rgb SceneRays::straightOn(Ray& ray, const RayHit& hit, PixelSampler* throughShells) {
    const PreparedInstance& instance = this->instance(hit.instance);
    if (kShellsCompiled && instance.mesh->shell) {
        return throughShells && throughShell_ ? throughShell_(instance, ray, hit, *throughShells) : Rgb(0.0f);
    }
    if (!instance.material || instance.material->opaque()) {
        return Rgb(0.0f);
    }
    const Surfel surfel = surfelAt(instance, ray, hit);
    const PreviewPoint at = instance.material->at(uvAt(*instance.mesh->surface, hit), surfel.albedo);
    ray.tNear = hit.t * (1 + 1e-6f) + scene_.shadowOffset;
    return PreviewBsdf(at).through({0, 0, dot(surfel.normal, ray.direction)});
}

Rgb SceneRays::throughSurfaces(Ray ray, std::uint64_t shading, PixelSampler* throughShells) {
    Rgb left(1.0f);
    for (int i = 0; i < kMaxClearSurfaces; ++i) {
        RayHit hit;
        if (!intersect(ray, hit)) {
            return left;
        }
        if (shading != 0 && (scene_.instances[hit.instance].links & shading) == 0) {
            ray.tNear = hit.t * (1 + 1e-6f) + scene_.shadowOffset;
            --i; // what throws no shadow is not counted: the ray gets on by each of them
            continue;
        }
        left *= straightOn(ray, hit, throughShells);
        if (!(maxComponent(left) > 0)) {
            return left;
        }
    }
    return Rgb(0.0f);
}

LightSet::Reach SceneRays::reachOf(const Ray& ray, PixelSampler& sampler) {
    if (!scene_.lights.linksShadows()) {
        return {};
    }
    return [this, ray, &sampler](std::uint64_t shading, float distance) {
        Ray way = ray;
        way.tFar = distance * (1 - 1e-4f);
        return throughSurfaces(way, shading, scene_.clearShells ? &sampler : nullptr);
    };
}

int SceneRays::chooseLights(const Vec3f& point, const Vec3f& normal, PixelSampler& sampler, LightPick* picks) const {
    // Nothing is drawn where there is nothing to choose.
    const float u = scene_.lights.count() > std::size_t(kMaxLightsPerPath) ? sampler.next1d() : 0.0f;
    return scene_.lights.choose(point, normal, u, kMaxLightsPerPath, picks);
}

} // namespace stf
