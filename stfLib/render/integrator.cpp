// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/integrator.h"

#include "stfLib/render/core_light.h"
#include "stfLib/render/shell_glow.h"
#include "stfLib/render/shells_compiled.h"
#include "stfLib/render/surface_point.h"
#include "stfLib/transport/tile_tracer.h"

#include <optional>

namespace stf {

namespace {

constexpr int kMaxSurfaces = 64; // of transparent shells along one ray

/// A mirrored path whose throughput is below this takes part in surfaces only with the chance that makes up for it.
constexpr float kFaint = 0.25f;

/// Radians: paths of lobes so wide see no detail of a shell.
constexpr float kBlindSpread = 0.4f;

} // namespace

ShellMarch& Integrator::marchOf(const PreparedInstance& instance) {
    std::unique_ptr<ShellMarch>& march = marches_[instance.index];
    if (!march) {
        const std::vector<Rgb>& core = scene_.instances[instance.index].core;
        march = std::make_unique<ShellMarch>(*instance.mesh->shell, core.empty() ? nullptr : core.data());
    }
    return *march;
}

int Integrator::lightsOnShell(const PreparedInstance& instance, const Surfel& surfel, bool indirect,
                              PixelSampler& sampler, ShellLight* lights) {
    const ShellObject& shell = *instance.mesh->shell;
    const Vec3f objectNormal = instance.objectNormal(surfel.normal);
    const float offset = 1e-3f * shell.grid->voxelSize();

    int count = 0;
    const bool kept = indirect && scene_.irradianceCache && !instance.indirect.empty();
    const bool traced = indirect && scene_.shellsSeeOthers && !scene_.irradianceCache;
    const auto visible = [&](const Vec3f& point, const LightSample& light) {
        const Vec3f lifted = instance.worldPoint(point + objectNormal * offset);
        return rays_.visibility(lifted + surfel.normal * scene_.rounding, light);
    };
    LightPick picks[kMaxLightsPerPath];
    rays_.setReceiver(instance);
    const int chosen = rays_.chooseLights(surfel.point, surfel.normal, sampler, picks);
    for (int i = 0; i < chosen; ++i) {
        const std::size_t l = picks[i].light;
        if (kept && scene_.keepsDomes && scene_.lights.isSmoothDome(l)) {
            continue;
        }
        const int directions = scene_.lights.isDome(l) ? kDomeDirections : kNearDirections;
        const PixelSampler::Points u = sampler.next2dPoints(directions), disc = sampler.next2dPoints(directions);
        for (int k = 0; k < directions; ++k) {
            const LightSample light = scene_.lights.sample(l, surfel.point, surfel.normal, u[k]);
            if (!(maxComponent(light.irradiance) > 0)) {
                continue;
            }
            const float share = traced ? PlainShader::besideBounced(light, surfel.normal, directions) : 1.0f;
            const Rgb irradiance = light.irradiance * (share * picks[i].weight / float(directions));
            const Rgb exact = visible(surfel.shadowOrigin, light);
            const Vec3f moved = jitterOnSurface(*instance.mesh->rayMesh, surfel.shadowOrigin, objectNormal,
                                                shell.blurRadiusMm / shell.mmPerUnit, disc[k]);
            const Rgb blurred = moved == surfel.shadowOrigin ? exact : visible(moved, light);
            if (maxComponent(exact) > 0 || maxComponent(blurred) > 0) {
                ShellLight& s = lights[count++];
                s.towards = instance.objectDirection(light.towards);
                s.forSingle = irradiance * exact;
                s.forMultiple = irradiance * blurred;
            }
        }
    }
    if (kept) {
        const Vec3i& corners = instance.mesh->surface->triangles[surfel.triangle];
        const IndirectSample from =
            sampleIndirect(instance.indirect, corners, surfel.u, surfel.v, surfel.normal, sampler);
        for (int k = 0; k < IndirectSample::kDirections && maxComponent(from.irradiance[k]) > 0; ++k) {
            lights[count++] = {instance.objectDirection(from.towards[k]), from.irradiance[k], from.irradiance[k]};
        }
    } else if (traced) {
        const Vec3f from = instance.worldPoint(surfel.shadowOrigin + objectNormal * offset);
        const LightSample light =
            plain_.bounced(from + surfel.normal * scene_.rounding, surfel.normal, kNearDirections, sampler);
        if (maxComponent(light.irradiance) > 0) {
            const Vec3f towards = instance.objectDirection(light.towards);
            lights[count++] = {towards, light.irradiance, light.irradiance};
        }
    }
    return count;
}

ShellRadiance Integrator::shadeShell(const PreparedInstance& instance, const Surfel& surfel, const Vec3f& direction,
                                     float footprintMm, bool indirect, PixelSampler& sampler) {
    ShellLight lights[kMaxShellLights];
    const int count = lightsOnShell(instance, surfel, indirect, sampler, lights);
    rays_.add(1);
    ShellSpan span;
    span.stop = instance.overlapped ? obstacle(instance, surfel.objectPoint, direction) : span.stop;
    return marchOf(instance).march(surfel.objectPoint, surfel.triangle, direction, footprintMm, lights, count, sampler,
                                   span);
}

ReliefRadiance Integrator::shadeRelief(const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit,
                                       const Vec3f& direction, float footprintMm, bool indirect,
                                       PixelSampler& sampler) {
    ShellLight lights[kMaxShellLights];
    const int count = lightsOnShell(instance, surfel, indirect, sampler, lights);
    rays_.add(1);
    ReliefEntry entry{surfel.objectPoint,
                      direction,
                      normalize(smoothNormal(*instance.mesh->surface, hit)),
                      hit.geometricNormal,
                      surfel.triangle,
                      false,
                      nullptr};
    if (instance.overlapped) {
        entry.obstacle = [&](const Vec3f& p, const Vec3f& d) { return obstacle(instance, p, d); };
    }
    return marchOf(instance).marchRelief(entry, footprintMm, lights, count, sampler);
}

Ray Integrator::leaveRelief(const PreparedInstance& instance, const ShellExit& exit) const {
    const Vec3f outward = instance.worldNormal(exit.outward);
    Ray ray;
    ray.direction = instance.worldDirection(exit.direction);
    ray.origin = instance.worldPoint(exit.point) + outward * scene_.shadowOffset;
    return ray;
}

Ray Integrator::leaveShell(const PreparedInstance& instance, const Vec3f& entry, const Vec3f& direction,
                           const ShellRadiance& through, float& share) {
    const RefinedSurface& s = *instance.mesh->surface;
    const RayHit& exit = through.exit;
    const Vec3f normal = normalize(smoothNormal(s, exit)), point = entry + direction * through.tExit;
    const float ior = marchOf(instance).iorAt(point, exit.triangle);
    // What is reflected there goes on inside the shell: it is dropped, as are rays that are reflected altogether.
    const SurfaceCrossing out = crossSurface(direction, -normal, -exit.geometricNormal, 1 / ior);
    share = 1 - out.reflectance;
    const Vec3f worldNormal = instance.worldNormal(normal);
    Ray ray;
    ray.direction = instance.worldDirection(out.refracted);
    ray.origin = instance.worldPoint(point) + worldNormal * scene_.shadowOffset;
    return ray;
}

Integrator::ShellMeeting Integrator::meetShell(const PreparedInstance& instance, const Surfel& surfel, const Ray& ray,
                                               const RayHit& hit, float medium, float footprintMm, bool indirect,
                                               PixelSampler& sampler) {
    const ShellObject& shell = *instance.mesh->shell;
    const Vec3f scaled(instance.worldToObject.vector(Vec3d(ray.direction)));
    const float scale = length(scaled);
    Vec3f direction = scaled / scale;
    ShellMeeting m;
    m.onward = ray;
    m.mirrorMoved = hit.t;
    const bool refracts = shell.medium->refracts();
    if (refracts && shell.medium->hasSurface()) {
        const ReliefRadiance r = shadeRelief(instance, surfel, hit, direction, footprintMm, indirect, sampler);
        m.single = r.single * medium;
        m.multiple = r.multiple * medium;
        m.core = r.core * medium;
        m.reflection = r.reflection * medium;
        if (maxComponent(r.through.weight) > 0) {
            m.stopped = r.through.stopped;
            m.through = r.through.weight * (m.stopped ? medium : 1.0f);
            m.onward = m.stopped ? goOnWithin(instance, r.through) : leaveRelief(instance, r.through);
            m.moved = hit.t + r.through.travelled / scale;
        }
        m.reflected = r.mirror.weight;
        if (maxComponent(m.reflected) > 0) {
            m.mirrorRay = leaveRelief(instance, r.mirror);
            m.mirrorMoved = hit.t + r.mirror.travelled / scale;
        }
        return m;
    }
    // What is inside is seen through the surface: (1 - F) of it, and less by n^2, for the solid angle widens there
    // (DESIGN 3.6).
    SurfaceCrossing in;
    float inner = medium;
    if (refracts) {
        const float ior = marchOf(instance).iorAt(surfel.objectPoint, surfel.triangle);
        in = enterShell(instance, ior, direction, hit);
        direction = in.reflectance < 1 ? in.refracted : direction;
        inner *= (1 - in.reflectance) / (ior * ior);
    }
    if (inner > 0) {
        const ShellRadiance r = shadeShell(instance, surfel, direction, footprintMm, indirect, sampler);
        m.single = r.single * inner;
        m.multiple = r.multiple * inner;
        m.core = r.core * inner;
        m.through = r.transmittance * (1 - in.reflectance); // n^2 is undone where it leaves again
        m.onward.tNear = (hit.t + r.tExit / scale) * (1 + 1e-6f) + scene_.shadowOffset;
        m.stopped = r.stopped;
        if (m.stopped) {
            m.through = r.transmittance * inner;
            if (refracts) {
                m.onward = Ray();
                m.onward.origin = instance.worldPoint(surfel.objectPoint);
                m.onward.direction = instance.worldDirection(direction);
                m.moved = hit.t;
            }
            m.onward.tNear = (hit.t - m.moved + r.tExit / scale) * (1 - 1e-6f) - scene_.rounding;
        } else if (refracts && r.throughSurface && dot(direction, r.exit.geometricNormal) > 0 &&
                   maxComponent(m.through) > 0) {
            float share = 1;
            m.onward = leaveShell(instance, surfel.objectPoint, direction, r, share);
            m.moved = hit.t + r.tExit / scale;
            m.through *= share;
        }
    }
    mirrorOff(instance, surfel, in, m);
    return m;
}

SurfaceCrossing Integrator::enterShell(const PreparedInstance& instance, float ior, const Vec3f& direction,
                                       const RayHit& hit) {
    return crossSurface(direction, normalize(smoothNormal(*instance.mesh->surface, hit)), hit.geometricNormal, ior);
}

void Integrator::mirrorOff(const PreparedInstance& instance, const Surfel& surfel, const SurfaceCrossing& in,
                           ShellMeeting& m) const {
    if (in.reflectance > 0) {
        m.reflected = Rgb(in.reflectance);
        m.mirrorRay.direction = instance.worldDirection(in.reflected);
        m.mirrorRay.origin = instance.worldPoint(surfel.shadowOrigin) + surfel.normal * scene_.shadowOffset;
    }
}

Integrator::ShellMeeting Integrator::meetKept(const PreparedInstance& instance, const Surfel& surfel, const Ray& ray,
                                              const RayHit& hit) {
    ShellMeeting m;
    m.multiple = exitantAt(instance, hit.triangle, hit.u, hit.v);
    m.mirrorMoved = hit.t;
    if (instance.mesh->shell->medium->refracts()) {
        const float ior = marchOf(instance).iorAt(surfel.objectPoint, surfel.triangle);
        mirrorOff(instance, surfel, enterShell(instance, ior, instance.objectDirection(ray.direction), hit), m);
    }
    return m;
}

Rgb Integrator::scattered(const PreparedInstance& instance, const Ray& ray, const RayHit& hit, float footprintMm,
                          PixelSampler& sampler) {
    const ShellMeeting m = meetShell(instance, surfelAt(instance, ray, hit), ray, hit, 1, footprintMm, true, sampler);
    return m.single + m.multiple + m.core + m.reflection;
}

PixelSample Integrator::sample(const Bundle& bundle, int i, const RayCone& cone, PixelSampler& sampler) {
    rays_.setTime(bundle.time[i]);
    PixelSample out;
    LightPath path;
    path.ray = bundle.ray[i];
    Ray& ray = path.ray;
    Rgb& throughput = path.throughput;
    const bool& mirrored = path.mirrored;
    // Light that is no part of the path's own shell.
    const auto add = [&](Rgb light, bool bounced) {
        if (bounced && scene_.indirectClamp > 0) {
            light *= std::min(1.0f, scene_.indirectClamp / std::max(scene_.indirectClamp, maxComponent(light)));
        }
        out.color += light;
        if (mirrored) {
            out.reflection += light;
        }
    };
    const auto collect = [&](const Rgb& single, const Rgb& multiple, const Rgb& core) {
        add(single + multiple + core, path.bounced);
        if (path.seen()) {
            out.single += single;
            out.multiple += multiple;
            out.core += core;
        }
    };
    if (kShellsCompiled && !scene_.aroundCamera.empty()) {
        if (Rgb core(0.0f); !startWithin(path, core)) {
            collect(Rgb(0.0f), Rgb(0.0f), core);
            out.cover(0, 1); // which core it is is not known
            return out;
        }
        if (path.withinCount > 0) {
            out.cover(path.within[path.withinCount - 1]->objectId, 1 - average(throughput));
        }
    }
    bool known = path.withinCount == 0; // what the ray meets
    for (int surface = 0; surface < kMaxSurfaces; ++surface) {
        while (kShellsCompiled && path.withinCount > 0 && !path.lightsOnly && !path.met) {
            const PreparedInstance& around = *path.within[path.withinCount - 1];
            const Interior r = crossInterior(around, path, cone, sampler);
            if (r.inside) {
                collect(throughput * r.single, throughput * r.multiple, throughput * r.core);
                if (path.seen()) {
                    out.cover(around.objectId, average(throughput - throughput * r.through));
                }
                throughput *= r.through;
                if (!(maxComponent(throughput) > 0)) {
                    return out;
                }
                ray = r.onward;
                path.travelled += r.moved;
                path.index = r.stopped ? r.index : 1.0f;
                if (r.stopped) {
                    path.stopWithin();
                    break;
                }
            }
            --path.withinCount;
        }
        if (kShellsCompiled && path.lightsOnly && path.withinCount > 0) {
            leaveShells(path, sampler);
        }
        path.met = false;
        RayHit hit = bundle.hit[i];
        const bool met = known ? bundle.met[i] : rays_.intersect(ray, hit);
        known = false;
        const float tMax = met ? hit.t : std::numeric_limits<float>::infinity();
        if (path.lights == LightPath::Lights::All) {
            const float blur = scene_.regularize ? regularizedDisc(path.spread) : 0.0f;
            add(throughput * scene_.lights.mirrored(ray.origin, ray.direction, ray.tNear, tMax, blur, path.links),
                path.bounced);
        } else if (path.lights == LightPath::Lights::Shared) {
            const LightSet::Reach reach = rays_.reachOf(ray, sampler);
            add(throughput * scene_.lights.met(
                                 ray.origin, ray.direction, ray.tNear, tMax,
                                 {path.normal, path.density, path.domeSamples, path.shadowless, path.links, &reach}),
                path.bounced);
            path.shadowless = false;
        }
        if (!met) {
            // The clear colour is a backdrop, not a light: no surface mirrors it.
            const bool dome = scene_.lights.hasDome();
            if (path.seen()) {
                out.color += throughput * (dome ? scene_.lights.background(ray.direction) : scene_.clearColor);
                out.alpha += average(throughput) * (dome ? 1.0f : scene_.clearAlpha);
            } else if (dome && path.lights == LightPath::Lights::All) {
                add(throughput * scene_.lights.background(ray.direction, path.links), path.bounced);
            }
            return out;
        }
        if (path.lightsOnly) {
            add(throughput * plain_.lightMet(path, rays_.instance(hit.instance), hit), path.bounced);
            throughput *= rays_.straightOn(ray, hit, &sampler);
            if (!(maxComponent(throughput) > 0)) {
                return out;
            }
            continue;
        }
        if (const float chance = maxComponent(throughput) / kFaint; !path.seen() && chance < 1) {
            if (!(sampler.next1d() < chance)) {
                return out;
            }
            throughput /= chance;
        }
        const PreparedInstance& instance = rays_.instance(hit.instance);
        const Surfel surfel = surfelAt(instance, ray, hit);
        const ShellObject* const shell = kShellsCompiled ? instance.mesh->shell.get() : nullptr;
        std::optional<WayOutGuard> wayOut;
        if (kShellsCompiled && path.withinCount > 0) {
            wayOut.emplace(*this, path, sampler);
        }
        if (!shell) {
            const Rgb before = throughput;
            const bool seen = path.seen(), bounced = path.bounced;
            const PlainShader::Step step = plain_.shade(path, instance, surfel, hit, sampler);
            if (step.covers) {
                add(before * step.radiance, bounced);
                if (seen) {
                    out.cover(instance.objectId, average(before));
                }
            }
            if (step.ends) {
                return out;
            }
            continue;
        }
        const Vec3f scaled(instance.worldToObject.vector(Vec3d(ray.direction)));
        if (dot(scaled, hit.geometricNormal) >= 0) {
            // The inside of a surface: light that left the shell on its other side. Nothing is here.
            ray.tNear = hit.t * (1 + 1e-6f) + scene_.shadowOffset;
            continue;
        }
        if (path.isWithin(instance)) {
            ray.tNear = hit.t * (1 + 1e-6f); // something else is met on its very surface
            path.met = true;
            continue;
        }
        // Shells are lit as in air, also where they lie in another that refracts.
        const float footprint =
            (cone.at(path.travelled + hit.t) + path.spread * hit.t) * length(scaled) * shell->mmPerUnit;
        const bool kept = path.bounced && path.spread >= kBlindSpread && path.index == 1 && scene_.glow &&
                          scene_.glow->holds(instance.index);
        ShellMeeting m = kept ? meetKept(instance, surfel, ray, hit)
                              : meetShell(instance, surfel, ray, hit, path.index * path.index, footprint,
                                          path.bounces < scene_.maxDepth, sampler);
        if (path.glowShared) {
            const float share = path.density / (path.density + scene_.glow->density(instance.index, hit, ray.direction,
                                                                                    ray.origin, path.normal));
            m.single *= share;
            m.multiple *= share;
            m.core *= share;
        }
        collect(throughput * m.single, throughput * m.multiple, throughput * m.core);
        add(throughput * m.reflection, path.bounced);
        out.reflection += path.seen() ? throughput * m.reflection : Rgb(0.0f);
        const Rgb through = throughput * m.through, reflected = throughput * m.reflected;
        if (path.seen()) {
            out.cover(instance.objectId, average(throughput - through));
        }
        // Where both bring something, one is taken by its share.
        const float a = maxComponent(through), b = maxComponent(reflected);
        if (!(a + b > 0)) {
            return out;
        }
        const bool mirror = b > 0 && (!(a > 0) || sampler.next1d() * (a + b) < b);
        throughput = mirror ? reflected * ((a + b) / b) : through * (a > 0 && b > 0 ? (a + b) / a : 1.0f);
        path.passShell(!shell->medium->refracts());
        if (m.stopped && !mirror) {
            path.enter(instance);
            path.index = indexWithin(instance, surfel.objectPoint, surfel.triangle);
            path.stopWithin();
            path.met = true;
        }
        if (mirror) {
            path.links = instance.links;
            path.mirror();
        }
        ray = mirror ? m.mirrorRay : m.onward;
        path.travelled += mirror ? m.mirrorMoved : m.moved;
    }
    return out;
}

PixelHit Integrator::firstHit(const Bundle& bundle, int which, const Camera& camera) {
    rays_.setTime(bundle.time[which]);
    PixelHit out;
    Ray ray = bundle.ray[which];
    RayHit hit = bundle.hit[which];
    for (int surface = 0;; ++surface) {
        if (surface == kMaxSurfaces || !(surface > 0 ? rays_.intersect(ray, hit) : bundle.met[which])) {
            return out;
        }
        const PreparedInstance& instance = rays_.instance(hit.instance);
        if (kShellsCompiled && instance.mesh->shell ? seesShell(instance, ray, hit, camera, out)
                                                    : !PlainShader::isHole(instance, ray, hit)) {
            break;
        }
        ray.tNear = hit.t * (1 + 1e-6f) + scene_.shadowOffset;
    }
    const PreparedInstance& instance = rays_.instance(hit.instance);
    out.primId = instance.primId;
    out.instanceId = instance.instanceId;
    if (kShellsCompiled && instance.mesh->shell) {
        return out;
    }
    const Surfel s = surfelAt(instance, ray, hit);
    setSeen(s.point, s.normal, camera, out);
    out.albedo = PlainShader::albedo(instance, s, hit);
    out.elementId = instance.mesh->surface->triangleFace[hit.triangle];
    return out;
}

void Integrator::setSeen(const Vec3f& point, const Vec3f& normal, const Camera& camera, PixelHit& out) const {
    const Vec3d p = Vec3d(point) + scene_.origin;
    out.depth = float(0.5 * camera.ndcDepth(p) + 0.5);
    out.cameraDepth = float(camera.viewDepth(p));
    out.normal = normal;
    out.neye = camera.viewNormal(normal);
    out.position = Vec3f(p);
}

bool Integrator::seesShell(const PreparedInstance& instance, const Ray& ray, RayHit& hit, const Camera& camera,
                           PixelHit& out) {
    const ShellObject& shell = *instance.mesh->shell;
    const Vec3f scaled(instance.worldToObject.vector(Vec3d(ray.direction)));
    if (dot(scaled, hit.geometricNormal) >= 0) {
        return false; // its inside: nothing is there
    }
    const Surfel s = surfelAt(instance, ray, hit);
    ShellMarch& march = marchOf(instance);
    ReliefSight sight;
    if (shell.medium->hasSurface()) {
        const float scale = length(scaled);
        const ReliefEntry entry{s.objectPoint,
                                scaled / scale,
                                normalize(smoothNormal(*shell.surface, hit)),
                                hit.geometricNormal,
                                s.triangle,
                                false,
                                nullptr};
        if (!march.firstSight(entry, sight)) {
            hit.t += sight.travelled / scale * (1 - 1e-4f); // what is behind comes next
            return false;
        }
        if (sight.travelled > 0) {
            setSeen(instance.worldPoint(sight.point), instance.worldNormal(sight.normal), camera, out);
            out.elementId = shell.surface->triangleFace[sight.place.known ? sight.place.at.triangle : s.triangle];
            out.albedo = sight.place.known ? march.albedoAt(sight.place.at, sight.atMm) : s.albedo;
            return true;
        }
    }
    setSeen(s.point, s.normal, camera, out);
    out.elementId = shell.surface->triangleFace[hit.triangle];
    // Of the first voxel with material, straight down from where the ray enters.
    ShellProbe probe(*shell.grid, *shell.surface, shell.pose.get());
    probe.enter(s.triangle);
    ShellLookup at;
    out.albedo = probe.lookup(s.objectPoint, at) ? march.albedoAt(at, 0) : s.albedo;
    return true;
}

} // namespace stf
