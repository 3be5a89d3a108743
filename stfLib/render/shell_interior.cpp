// SPDX-License-Identifier: Apache-2.0
// Paths of the integrator that begin inside a shell: those of a camera in it, and those that met something else there.
#include "stfLib/render/integrator.h"

namespace stf {

namespace {
constexpr int kMostSkipped = 64; // surfaces of the shell itself, and backs of others
constexpr float kBeyond = 1e-6f; // of a distance
} // namespace

float Integrator::obstacle(const PreparedInstance& instance, const Vec3f& point, const Vec3f& direction) {
    constexpr float none = std::numeric_limits<float>::infinity();
    Ray ray;
    ray.origin = instance.worldPoint(point);
    ray.direction = instance.worldDirection(direction);
    const float scale = length(Vec3f(instance.worldToObject.vector(Vec3d(ray.direction))));
    RayHit hit;
    for (int i = 0; i < kMostSkipped && rays_.intersect(ray, hit); ++i) {
        const PreparedInstance& other = rays_.instance(hit.instance);
        const Vec3f along(other.worldToObject.vector(Vec3d(ray.direction)));
        const bool leaves = dot(along, hit.geometricNormal) > 0;
        if (&other == &instance) {
            // Out of the shell; not where the ray starts on its surface and grazes it.
            if (leaves && hit.t > scene_.shadowOffset) {
                return none;
            }
        } else if (!leaves || !other.mesh->shell) {
            return hit.t * scale;
        }
        ray.tNear = hit.t * (1 + kBeyond) + scene_.rounding;
    }
    return none;
}

Integrator::Interior Integrator::crossInterior(const PreparedInstance& instance, const LightPath& path,
                                               const RayCone& cone, PixelSampler& sampler) {
    Interior out;
    const ShellObject& shell = *instance.mesh->shell;
    ShellMarch& march = marchOf(instance);
    const Ray& ray = path.ray;
    const Vec3d start = Vec3d(ray.origin) + Vec3d(ray.direction) * double(ray.tNear);
    const Vec3f point(instance.worldToObject.point(start)), scaled(instance.worldToObject.vector(Vec3d(ray.direction)));
    const float scale = length(scaled);
    const Vec3f direction = scaled / scale;
    ShellLookup at;
    if (!march.holds(point, direction, at)) {
        return out;
    }
    out.inside = true;
    RayHit above = hitAt(instance, {at.triangle, at.b1, at.b2});
    above.t = ray.tNear;
    const Surfel surfel = surfelAt(instance, ray, above);
    const float footprint = (cone.at(path.travelled + ray.tNear) + path.spread * ray.tNear) * scale * shell.mmPerUnit;
    const bool indirect = path.bounces < scene_.maxDepth;
    ShellLight lights[kMaxShellLights];
    const int count = lightsOnShell(instance, surfel, indirect, sampler, lights);
    rays_.add(1);
    out.index = march.iorWithin(point, at);
    out.onward = ray;
    if (shell.medium->refracts() && shell.medium->hasSurface()) {
        ReliefEntry entry{point, direction, surfel.normal, above.geometricNormal, at.triangle, true, nullptr};
        if (instance.overlapped) {
            entry.obstacle = [&](const Vec3f& p, const Vec3f& d) { return obstacle(instance, p, d); };
        }
        const ReliefRadiance r = march.marchRelief(entry, footprint, lights, count, sampler);
        out.single = r.single;
        out.multiple = r.multiple;
        out.core = r.core;
        out.through = r.through.weight;
        if (maxComponent(out.through) > 0) {
            out.stopped = r.through.stopped;
            out.onward = out.stopped ? goOnWithin(instance, r.through) : leaveRelief(instance, r.through);
            out.moved = ray.tNear + r.through.travelled / scale;
        }
        return out;
    }
    ShellSpan span;
    span.fromWithin = true;
    span.stop = instance.overlapped ? obstacle(instance, point, direction) : span.stop;
    const ShellRadiance r = march.march(point, at.triangle, direction, footprint, lights, count, sampler, span);
    out.single = r.single;
    out.multiple = r.multiple;
    out.core = r.core;
    out.through = r.transmittance;
    out.stopped = r.stopped;
    if (r.stopped) {
        out.onward.tNear = (ray.tNear + r.tExit / scale) * (1 - kBeyond) - scene_.rounding;
    } else if (shell.medium->refracts() && r.throughSurface && maxComponent(out.through) > 0) {
        float share = 1;
        const float ior = march.iorAt(point + direction * r.tExit, r.exit.triangle);
        out.onward = leaveShell(instance, point, direction, r, share);
        out.moved = ray.tNear + r.tExit / scale;
        out.through *= share * ior * ior;
    } else {
        out.onward.tNear = (ray.tNear + r.tExit / scale) * (1 + kBeyond) + scene_.shadowOffset;
    }
    return out;
}

Ray Integrator::goOnWithin(const PreparedInstance& instance, const ShellExit& stop) const {
    Ray ray;
    ray.direction = instance.worldDirection(stop.direction);
    // Just before what is met.
    ray.origin = instance.worldPoint(stop.point) - ray.direction * (scene_.shadowOffset + scene_.rounding);
    return ray;
}

bool Integrator::startWithin(LightPath& path, Rgb& radiance) {
    const Vec3d start = Vec3d(path.ray.origin);
    for (const std::uint32_t i : scene_.aroundCamera) {
        const PreparedInstance& instance = rays_.instance(i);
        const Vec3f point(instance.worldToObject.point(start)),
            direction = instance.objectDirection(path.ray.direction);
        ShellMarch& march = marchOf(instance);
        ShellLookup at;
        if (march.holds(point, direction, at)) {
            const float ior = march.iorWithin(point, at);
            path.throughput /= ior * ior;
            path.index = ior;
            path.enter(instance);
        } else if (march.coreHolds(point, direction, radiance)) {
            return false;
        }
    }
    return true;
}

Rgb Integrator::lightThrough(const PreparedInstance& instance, Vec3f& origin, LightSample& light,
                             PixelSampler& sampler) {
    const Vec3f point(instance.worldToObject.point(Vec3d(origin))),
        scaled(instance.worldToObject.vector(Vec3d(light.towards)));
    const float scale = length(scaled);
    const Vec3f direction = scaled / scale;
    ShellMarch& march = marchOf(instance);
    ShellLookup at;
    if (!march.holds(point, direction, at)) {
        return Rgb(1.0f);
    }
    if (instance.overlapped && obstacle(instance, point, direction) < std::numeric_limits<float>::infinity()) {
        return Rgb(0.0f); // left to paths, which go on behind it
    }
    ShellSpan span;
    span.fromWithin = true;
    const ShellRadiance r = march.march(point, at.triangle, direction, 0, nullptr, 0, sampler, span);
    const float length = r.tExit / scale + 2 * scene_.shadowOffset;
    origin += light.towards * length;
    light.distance -= length;
    return r.transmittance;
}

Rgb Integrator::throughShell(const PreparedInstance& instance, Ray& ray, const RayHit& hit, PixelSampler& sampler) {
    const ShellObject& shell = *instance.mesh->shell;
    const Vec3f scaled(instance.worldToObject.vector(Vec3d(ray.direction)));
    if (dot(scaled, hit.geometricNormal) >= 0) {
        ray.tNear = hit.t * (1 + kBeyond) + scene_.shadowOffset; // its inside: nothing is there
        return Rgb(1.0f);
    }
    if (shell.medium->refracts()) {
        return Rgb(0.0f);
    }
    const float scale = length(scaled);
    const Vec3f direction = scaled / scale, point = surfelAt(instance, ray, hit).objectPoint;
    // The core ends most rays: it is looked for before the march.
    Ray inward;
    inward.origin = point;
    inward.direction = direction;
    inward.tNear = 1e-3f * shell.grid->voxelSize();
    RayHit end;
    rays_.add(1);
    if (shell.rayMesh->intersect(inward, end, 3) && end.geometry == 1) {
        return Rgb(0.0f);
    }
    if (instance.overlapped && obstacle(instance, point, direction) < std::numeric_limits<float>::infinity()) {
        return Rgb(0.0f);
    }
    const ShellRadiance r = marchOf(instance).march(point, hit.triangle, direction, 0, nullptr, 0, sampler);
    ray.tNear = (hit.t + r.tExit / scale) * (1 + kBeyond) + scene_.shadowOffset;
    return ray.tNear < ray.tFar ? r.transmittance : Rgb(0.0f); // a light in a shell gets no further
}

void Integrator::leaveShells(LightPath& path, PixelSampler& sampler) {
    const Vec3f start = path.ray.origin + path.ray.direction * path.ray.tNear;
    Vec3f origin = start;
    LightSample light;
    light.towards = path.ray.direction;
    while (path.withinCount > 0) {
        path.throughput *= lightThrough(*path.within[--path.withinCount], origin, light, sampler);
    }
    path.ray.tNear += length(origin - start);
}

Integrator::WayOutGuard::WayOutGuard(Integrator& integrator, const LightPath& path, PixelSampler& sampler) {
    integrator_ = &integrator;
    const std::vector<const PreparedInstance*> around(path.within, path.within + path.withinCount);
    integrator.rays_.setWayOut([&integrator, &sampler, around](Vec3f& origin, LightSample& light) {
        Rgb left(1.0f);
        for (auto i = around.rbegin(); i != around.rend() && maxComponent(left) > 0; ++i) {
            left *= integrator.lightThrough(**i, origin, light, sampler);
        }
        return left;
    });
}

Integrator::WayOutGuard::~WayOutGuard() {
    integrator_->rays_.setWayOut(nullptr);
}

float Integrator::indexWithin(const PreparedInstance& instance, const Vec3f& point, std::uint32_t triangle) {
    const TileMedium& medium = *instance.mesh->shell->medium;
    return medium.refracts() ? marchOf(instance).iorAt(point, triangle) : 1.0f;
}

} // namespace stf
