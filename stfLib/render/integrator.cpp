// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/integrator.h"

#include "stfLib/render/core_light.h"
#include "stfLib/render/surface_point.h"
#include "stfLib/transport/tile_tracer.h"

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
constexpr int kMaxSurfaces = 64;     // of transparent shells along one ray
constexpr int kMaxLightsPerPath = 4; // more are chosen from at random, so that cost stays bounded
/// A dome is half hidden by the ground and by the object itself: several directions a path cost less than more paths.
constexpr int kDomeDirections = 4;
/// Of other lights on a shell: their visibility is averaged over a disc.
constexpr int kNearDirections = 2;
constexpr int kMaxShellLights = kMaxLightsPerPath * kDomeDirections;
const Rgb kDefaultColor(0.5f);

/// A mirrored path whose throughput is below this takes part in surfaces only with the chance that makes up for it.
constexpr float kFaint = 0.25f;

} // namespace

bool Integrator::occluded(const Vec3f& origin, const LightSample& light) {
    if (!light.shadows) {
        return false;
    }
    ++rays_;
    return scene_.rays->occluded(shadowRay(origin, light));
}

int Integrator::chooseLights(const Vec3f& point, const Vec3f& normal, PixelSampler& sampler, LightPick* picks) const {
    // Nothing is drawn where there is nothing to choose.
    const float u = scene_.lights.count() > std::size_t(kMaxLightsPerPath) ? sampler.next1d() : 0.0f;
    return scene_.lights.choose(point, normal, u, kMaxLightsPerPath, picks);
}

Integrator::Surfel Integrator::surfelAt(const PreparedInstance& instance, const Ray& ray, const RayHit& hit) const {
    const RefinedSurface& s = *instance.mesh->surface;
    const Vec3i& t = s.triangles[hit.triangle];
    const Vec3f p = betweenCorners(s.points, t, hit.u, hit.v);
    // Shadow rays start from the smooth surface, else facets show at the terminator (Hanika 2021, "Hacking the shadow
    // terminator", Ray Tracing Gems II): the mean of the projections onto the corners' tangent planes.
    Vec3f lifted = p;
    const float weight[3] = {1 - hit.u - hit.v, hit.u, hit.v};
    for (int k = 0; k < 3 && s.cornerNormals.empty(); ++k) {
        const std::size_t i = std::size_t(t[k]);
        lifted -= s.normals[i] * (weight[k] * std::min(0.0f, dot(p - s.points[i], s.normals[i])));
    }
    Surfel out;
    out.triangle = hit.triangle;
    out.point = ray.origin + ray.direction * hit.t;
    out.normal = normalize(Vec3f(instance.objectToWorld.normal(Vec3d(smoothNormal(s, hit)))));
    out.objectPoint = p;
    out.shadowOrigin = lifted;
    out.albedo = s.colors.empty() ? kDefaultColor : betweenCorners(s.colors, t, hit.u, hit.v);
    return out;
}

Rgb Integrator::shadePlain(const PreparedInstance& instance, const Surfel& surfel, const Vec3f& direction,
                           PixelSampler& sampler) {
    const Vec3f n = dot(surfel.normal, direction) > 0 ? -surfel.normal : surfel.normal;
    const Vec3f origin = Vec3f(instance.objectToWorld.point(Vec3d(surfel.shadowOrigin))) + n * scene_.shadowOffset;
    Rgb sum(0.0f);
    LightPick picks[kMaxLightsPerPath];
    const int count = chooseLights(surfel.point, n, sampler, picks);
    for (int i = 0; i < count; ++i) {
        const std::size_t l = picks[i].light;
        const int directions = scene_.lights.isDome(l) ? kDomeDirections : 1;
        const PixelSampler::Points u = sampler.next2dPoints(directions);
        for (int k = 0; k < directions; ++k) {
            const LightSample light = scene_.lights.sample(l, surfel.point, n, u[k]);
            const float cosine = dot(n, light.towards);
            if (cosine > 0 && maxComponent(light.irradiance) > 0 && !occluded(origin, light)) {
                sum += light.irradiance * (cosine * picks[i].weight / float(directions));
            }
        }
    }
    return surfel.albedo * sum / kPi;
}

ShellMarch& Integrator::marchOf(const PreparedInstance& instance) {
    std::unique_ptr<ShellMarch>& march = marches_[std::size_t(&instance - scene_.instances.data())];
    if (!march) {
        march =
            std::make_unique<ShellMarch>(*instance.mesh->shell, instance.core.empty() ? nullptr : instance.core.data());
    }
    return *march;
}

int Integrator::lightsOnShell(const PreparedInstance& instance, const Surfel& surfel, PixelSampler& sampler,
                              ShellLight* lights) {
    const ShellObject& shell = *instance.mesh->shell;
    const Vec3f objectNormal = normalize(Vec3f(instance.worldToObject.normal(Vec3d(surfel.normal))));
    const float offset = 1e-3f * shell.grid->voxelSize();

    int count = 0;
    const auto visible = [&](const Vec3f& point, const LightSample& light) {
        const Vec3f lifted(instance.objectToWorld.point(Vec3d(point + objectNormal * offset)));
        return !occluded(lifted + surfel.normal * scene_.rounding, light);
    };
    LightPick picks[kMaxLightsPerPath];
    const int chosen = chooseLights(surfel.point, surfel.normal, sampler, picks);
    for (int i = 0; i < chosen; ++i) {
        const std::size_t l = picks[i].light;
        const int directions = scene_.lights.isDome(l) ? kDomeDirections : kNearDirections;
        const PixelSampler::Points u = sampler.next2dPoints(directions), disc = sampler.next2dPoints(directions);
        for (int k = 0; k < directions; ++k) {
            const LightSample light = scene_.lights.sample(l, surfel.point, surfel.normal, u[k]);
            if (!(maxComponent(light.irradiance) > 0)) {
                continue;
            }
            const Rgb irradiance = light.irradiance * (picks[i].weight / float(directions));
            const bool exact = visible(surfel.shadowOrigin, light);
            const Vec3f moved = jitterOnSurface(*instance.mesh->rayMesh, surfel.shadowOrigin, objectNormal,
                                                shell.blurRadiusMm / shell.mmPerUnit, disc[k]);
            const bool blurred = moved == surfel.shadowOrigin ? exact : visible(moved, light);
            if (exact || blurred) {
                ShellLight& s = lights[count++];
                s.towards = normalize(Vec3f(instance.worldToObject.vector(Vec3d(light.towards))));
                s.forSingle = exact ? irradiance : Rgb(0.0f);
                s.forMultiple = blurred ? irradiance : Rgb(0.0f);
            }
        }
    }

    return count;
}

ShellRadiance Integrator::shadeShell(const PreparedInstance& instance, const Surfel& surfel, const Vec3f& direction,
                                     float footprintMm, PixelSampler& sampler) {
    ShellLight lights[kMaxShellLights];
    const int count = lightsOnShell(instance, surfel, sampler, lights);
    ++rays_;
    return marchOf(instance).march(surfel.objectPoint, surfel.triangle, direction, footprintMm, lights, count, sampler);
}

ReliefRadiance Integrator::shadeRelief(const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit,
                                       const Vec3f& direction, float footprintMm, PixelSampler& sampler) {
    ShellLight lights[kMaxShellLights];
    const int count = lightsOnShell(instance, surfel, sampler, lights);
    ++rays_;
    const ReliefEntry entry{surfel.objectPoint, direction, normalize(smoothNormal(*instance.mesh->surface, hit)),
                            hit.geometricNormal, surfel.triangle};
    return marchOf(instance).marchRelief(entry, footprintMm, lights, count, sampler);
}

Ray Integrator::leaveRelief(const PreparedInstance& instance, const ShellExit& exit) const {
    const Vec3f outward = normalize(Vec3f(instance.objectToWorld.normal(Vec3d(exit.outward))));
    Ray ray;
    ray.direction = normalize(Vec3f(instance.objectToWorld.vector(Vec3d(exit.direction))));
    ray.origin = Vec3f(instance.objectToWorld.point(Vec3d(exit.point))) + outward * scene_.shadowOffset;
    return ray;
}

Ray Integrator::leaveShell(const PreparedInstance& instance, const Surfel& entry, const Vec3f& direction,
                           const ShellRadiance& through, float& share) {
    const RefinedSurface& s = *instance.mesh->surface;
    const RayHit& exit = through.exit;
    const Vec3f normal = normalize(smoothNormal(s, exit)), point = entry.objectPoint + direction * through.tExit;
    const float ior = marchOf(instance).iorAt(point, exit.triangle);
    // What is reflected there goes on inside the shell: it is dropped, as are rays that are reflected altogether.
    const SurfaceCrossing out = crossSurface(direction, -normal, -exit.geometricNormal, 1 / ior);
    share = 1 - out.reflectance;
    const Vec3f worldNormal = normalize(Vec3f(instance.objectToWorld.normal(Vec3d(normal))));
    Ray ray;
    ray.direction = normalize(Vec3f(instance.objectToWorld.vector(Vec3d(out.refracted))));
    ray.origin = Vec3f(instance.objectToWorld.point(Vec3d(point))) + worldNormal * scene_.shadowOffset;
    return ray;
}

PixelSample Integrator::sample(Ray ray, const RayCone& cone, PixelSampler& sampler) {
    PixelSample out;
    float travelled = 0; // before the ray's origin
    Rgb throughput(1.0f);
    bool mirrored = false; // the path has been reflected: the rest of it is what is seen in a shell's surface
    for (int surface = 0; surface < kMaxSurfaces; ++surface) {
        RayHit hit;
        ++rays_;
        const bool met = scene_.rays->intersect(ray, hit);
        if (mirrored) {
            const Rgb lamps = throughput * scene_.lights.mirrored(ray.origin, ray.direction,
                                                                  met ? hit.t : std::numeric_limits<float>::infinity());
            out.color += lamps;
            out.reflection += lamps;
        }
        if (!met) {
            // The clear colour is a backdrop, not a light: no surface mirrors it.
            const bool dome = scene_.lights.hasDome();
            const Rgb behind = dome       ? scene_.lights.background(ray.direction)
                               : mirrored ? Rgb(0.0f)
                                          : scene_.clearColor;
            out.color += throughput * behind;
            if (mirrored) {
                out.reflection += throughput * behind;
            } else {
                out.alpha += average(throughput) * (dome ? 1.0f : scene_.clearAlpha);
            }
            return out;
        }
        if (const float chance = maxComponent(throughput) / kFaint; mirrored && chance < 1) {
            if (!(sampler.next1d() < chance)) {
                return out;
            }
            throughput /= chance;
        }
        const PreparedInstance& instance = scene_.instances[hit.instance];
        const Surfel surfel = surfelAt(instance, ray, hit);
        const ShellObject* shell = instance.mesh->shell.get();
        if (!shell) {
            const Rgb plain = throughput * shadePlain(instance, surfel, ray.direction, sampler);
            out.color += plain;
            if (mirrored) {
                out.reflection += plain;
            } else {
                out.alpha += average(throughput);
            }
            return out;
        }
        const Vec3f scaled(instance.worldToObject.vector(Vec3d(ray.direction)));
        if (dot(scaled, hit.geometricNormal) >= 0) {
            // The inside of a surface: light that left the shell on its other side. Nothing is here.
            ray.tNear = hit.t * (1 + 1e-6f) + scene_.shadowOffset;
            continue;
        }
        const float scale = length(scaled);
        Vec3f direction = scaled / scale;

        const float footprint = cone.at(travelled + hit.t) * scale * shell->mmPerUnit;
        const auto collect = [&](const Rgb& single, const Rgb& multiple, const Rgb& core) {
            out.color += single + multiple + core;
            if (mirrored) {
                out.reflection += single + multiple + core;
            } else {
                out.single += single;
                out.multiple += multiple;
                out.core += core;
            }
        };
        // Two ways lead on: through the shell and off its surface.
        Rgb through(0.0f), reflected(0.0f);
        Ray onward = ray, mirrorRay;
        float moved = 0, mirrorMoved = hit.t; // from the ray's origin to that of the next
        if (shell->medium->refracts() && shell->medium->hasSurface()) {
            const ReliefRadiance r = shadeRelief(instance, surfel, hit, direction, footprint, sampler);
            collect(throughput * r.single, throughput * r.multiple, throughput * r.core);
            out.color += throughput * r.reflection;
            out.reflection += throughput * r.reflection;
            through = throughput * r.through.weight;
            if (maxComponent(through) > 0) {
                onward = leaveRelief(instance, r.through);
                moved = hit.t + r.through.travelled / scale;
            }
            reflected = throughput * r.mirror.weight;
            if (maxComponent(reflected) > 0) {
                mirrorRay = leaveRelief(instance, r.mirror);
                mirrorMoved = hit.t + r.mirror.travelled / scale;
            }
        } else {
            // What is inside is seen through the surface: (1 - F) of it, and less by n^2, for the solid angle widens
            // there (DESIGN 3.6).
            const bool refracts = shell->medium->refracts();
            SurfaceCrossing in;
            Rgb inner = throughput;
            if (refracts) {
                const float ior = marchOf(instance).iorAt(surfel.objectPoint, surfel.triangle);
                in = crossSurface(direction, normalize(smoothNormal(*instance.mesh->surface, hit)), hit.geometricNormal,
                                  ior);
                direction = in.reflectance < 1 ? in.refracted : direction;
                inner *= (1 - in.reflectance) / (ior * ior);
            }
            if (maxComponent(inner) > 0) {
                const ShellRadiance r = shadeShell(instance, surfel, direction, footprint, sampler);
                collect(inner * r.single, inner * r.multiple, inner * r.core);
                through = throughput * r.transmittance * (1 - in.reflectance); // n^2 is undone where it leaves again
                onward.tNear = (hit.t + r.tExit / scale) * (1 + 1e-6f) + scene_.shadowOffset;
                if (refracts && r.throughSurface && dot(direction, r.exit.geometricNormal) > 0 &&
                    maxComponent(through) > 0) {
                    float share = 1;
                    onward = leaveShell(instance, surfel, direction, r, share);
                    moved = hit.t + r.tExit / scale;
                    through *= share;
                }
            }
            if (in.reflectance > 0) {
                reflected = throughput * in.reflectance;
                mirrorRay.direction = normalize(Vec3f(instance.objectToWorld.vector(Vec3d(in.reflected))));
                mirrorRay.origin = Vec3f(instance.objectToWorld.point(Vec3d(surfel.shadowOrigin))) +
                                   surfel.normal * scene_.shadowOffset;
            }
        }
        if (!mirrored) {
            out.alpha += average(throughput - through);
        }
        // Where both bring something, one is taken by its share.
        const float a = maxComponent(through), b = maxComponent(reflected);
        if (!(a + b > 0)) {
            return out;
        }
        const bool mirror = b > 0 && (!(a > 0) || sampler.next1d() * (a + b) < b);
        throughput = mirror ? reflected * ((a + b) / b) : through * (a > 0 && b > 0 ? (a + b) / a : 1.0f);
        if (mirror) {
            mirrored = true;
            moved = mirrorMoved;
            onward = mirrorRay;
        }
        ray = onward;
        travelled += moved;
    }
    return out;
}

PixelHit Integrator::firstHit(const Ray& ray, const Camera& camera) {
    PixelHit out;
    RayHit hit;
    ++rays_;
    if (!scene_.rays->intersect(ray, hit)) {
        return out;
    }
    const PreparedInstance& instance = scene_.instances[hit.instance];
    const Surfel s = surfelAt(instance, ray, hit);
    const Vec3d p = Vec3d(s.point) + scene_.origin;
    out.depth = float(0.5 * camera.ndcDepth(p) + 0.5);
    out.cameraDepth = float(camera.viewDepth(p));
    out.normal = s.normal;
    out.neye = camera.viewNormal(s.normal);
    out.position = Vec3f(p);
    out.albedo = s.albedo;
    if (const ShellObject* shell = instance.mesh->shell.get()) {
        // The albedo of the first voxel with material, straight down from where the ray enters.
        ShellProbe probe(*shell->grid, *shell->surface, shell->pose.get());
        probe.enter(s.triangle);
        ShellLookup at;
        if (probe.lookup(s.objectPoint, at)) {
            const BaseVolume& v = *shell->volume;
            const int x = TileTracer::wrap(int(std::floor(at.exemplar.x / float(v.voxelMm.x))), v.size.x);
            const int y = TileTracer::wrap(int(std::floor(at.exemplar.y / float(v.voxelMm.y))), v.size.y);
            for (int z = 0; z < v.size.z; ++z) {
                const std::size_t i = v.index(x, y, z);
                if (maxComponent(v.extinction[i]) > 0) {
                    out.albedo = v.albedo[i];
                    break;
                }
            }
        }
    }
    out.primId = instance.primId;
    out.instanceId = instance.instanceId;
    out.elementId = instance.mesh->surface->triangleFace[hit.triangle];
    return out;
}

} // namespace stf
