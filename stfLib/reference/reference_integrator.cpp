// SPDX-License-Identifier: Apache-2.0
#include "stfLib/reference/reference_integrator.h"

#include "stfLib/optics/phase.h"
#include "stfLib/render/surface_point.h"

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
/// A path in the scene of whose light less is left goes on with the chance that makes up for it.
constexpr float kFaint = 0.25f;

std::uint64_t bitsOf(const Vec2f& u) {
    return std::uint64_t(std::uint32_t(u.x * 0x1p24f)) << 32 | std::uint32_t(u.y * 0x1p24f);
}

} // namespace

ReferenceIntegrator::ReferenceIntegrator(const PreparedScene& scene, std::shared_ptr<const Media> media)
    : scene_(scene), media_(std::move(media)), rays_(scene), plain_(scene, rays_), walks_(scene.instances.size()) {
    rays_.setThroughShell([this](const PreparedInstance& instance, Ray& ray, const RayHit& hit, PixelSampler&) {
        return straightThrough(instance, ray, hit);
    });
}

PathTracerMaker ReferenceIntegrator::maker(const PreparedScene& scene) {
    auto media = std::make_shared<Media>();
    for (const PreparedInstance& i : scene.instances) {
        if (const ShellObject* shell = i.mesh->shell.get()) {
            std::shared_ptr<const ReferenceMedium>& medium = (*media)[shell->volume.get()];
            if (!medium) {
                medium = std::make_shared<const ReferenceMedium>(shell->volume);
            }
        }
    }
    return [&scene, media] { return std::make_unique<ReferenceIntegrator>(scene, media); };
}

std::uint64_t ReferenceIntegrator::rays() const {
    std::uint64_t count = rays_.count();
    for (const auto& walk : walks_) {
        count += walk ? walk->rays() : 0;
    }
    return count;
}

ShellWalk& ReferenceIntegrator::walkOf(const PreparedInstance& instance) {
    std::unique_ptr<ShellWalk>& walk = walks_[instance.index];
    if (!walk) {
        const ShellObject& shell = *instance.mesh->shell;
        walk = std::make_unique<ShellWalk>(shell, media_->at(shell.volume.get()));
    }
    return *walk;
}

PixelSample ReferenceIntegrator::sample(const Ray& first, float time, PixelSampler& sampler) {
    rays_.setTime(time);
    const std::uint64_t key = bitsOf(sampler.next2d());
    rng_ = CounterRng(key, bitsOf(sampler.next2d()));
    sampler_ = &sampler;
    out_ = {};
    path_ = {};
    path_.ray = first;
    visited_ = {};
    reflected_ = false;
    for (;;) {
        Ray& ray = path_.ray;
        RayHit hit;
        const bool met = rays_.intersect(ray, hit);
        const float tMax = met ? hit.t : std::numeric_limits<float>::infinity();
        if (path_.lights == LightPath::Lights::All) {
            add(path_.throughput * scene_.lights.mirrored(ray.origin, ray.direction, ray.tNear, tMax, 0, path_.links) *
                visited_.share);
        } else if (path_.lights == LightPath::Lights::Shared) {
            const LightSet::Reach reach = rays_.reachOf(ray, *sampler_);
            add(path_.throughput * scene_.lights.met(ray.origin, ray.direction, ray.tNear, tMax,
                                                     {path_.normal, path_.density, path_.domeSamples, path_.shadowless,
                                                      path_.links, &reach}));
            path_.shadowless = false;
        }
        visited_.share = 1; // what cones find is not beyond the first thing that is met
        if (!met) {
            const bool dome = scene_.lights.hasDome();
            if (path_.seen()) {
                out_.color += path_.throughput * (dome ? scene_.lights.background(ray.direction) : scene_.clearColor);
                out_.alpha += average(path_.throughput) * (dome ? 1.0f : scene_.clearAlpha);
            } else if (dome && path_.lights == LightPath::Lights::All) {
                add(path_.throughput * scene_.lights.background(ray.direction, path_.links));
            }
            return out_;
        }
        const PreparedInstance& instance = rays_.instance(hit.instance);
        if (path_.lightsOnly) {
            add(path_.throughput * plain_.lightMet(path_, instance, hit));
            path_.throughput *= rays_.straightOn(ray, hit, &sampler);
            if (!(maxComponent(path_.throughput) > 0)) {
                return out_;
            }
            continue;
        }
        if (const float chance = maxComponent(path_.throughput) / kFaint; chance < 1) {
            if (!(sampler.next1d() < chance)) {
                return out_;
            }
            path_.throughput /= chance;
        }
        const Surfel surfel = surfelAt(instance, ray, hit);
        if (!instance.mesh->shell) {
            const Rgb before = path_.throughput;
            const bool seen = path_.seen();
            const PlainShader::Step step = plain_.shade(path_, instance, surfel, hit, sampler);
            if (step.covers) {
                add(before * step.radiance);
                if (seen) {
                    out_.cover(instance.objectId, average(before));
                }
                visited_ = {};
            }
            if (step.ends) {
                return out_;
            }
            continue;
        }
        if (dot(Vec3f(instance.worldToObject.vector(Vec3d(ray.direction))), hit.geometricNormal) >= 0) {
            ray.tNear = hit.t * (1 + 1e-6f) + scene_.shadowOffset; // its inside: the path was let out by a rim
            continue;
        }
        if (!crossShell(instance, surfel, hit)) {
            return out_;
        }
    }
}

bool ReferenceIntegrator::crossShell(const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit) {
    ShellWalk& walk = walkOf(instance);
    const bool seen = path_.seen();
    const Rgb before = path_.throughput;
    if (visited_.asked == Asked::Cones || walk.medium().refracts()) {
        visited_ = {}; // who asked for lights before saw none through this shell
    }
    path_.passShell(!walk.medium().refracts());
    ShellWalk::State state;
    if (!walk.enter(surfel.objectPoint, instance.objectDirection(path_.ray.direction),
                    normalize(smoothNormal(*instance.mesh->surface, hit)), hit.geometricNormal, surfel.triangle, rng_,
                    state)) {
        reflected_ = seen;
        if (seen) {
            out_.cover(instance.objectId, average(before));
        }
        path_.mirror();
        path_.ray = Ray();
        path_.ray.direction = instance.worldDirection(state.direction);
        path_.ray.origin = instance.worldPoint(surfel.shadowOrigin) + surfel.normal * scene_.shadowOffset;
        return true;
    }
    inside_ = &instance;
    Rgb shone(0.0f);
    const ShellWalk::Outcome out = walk.follow(state, path_.throughput, *this, rng_, shone);
    inside_ = nullptr;
    add(shone);
    if (seen && !(out.left && state.scatterings == 0)) {
        out_.cover(instance.objectId, average(before));
    }
    if (out.left) {
        leave(instance, out, state);
    }
    return out.left;
}

void ReferenceIntegrator::leave(const PreparedInstance& instance, const ShellWalk::Outcome& out,
                                const ShellWalk::State& state) {
    const Vec3f exit = instance.worldPoint(out.point), direction = instance.worldDirection(out.direction);
    if (state.scatterings > 0) {
        path_.mirrored = true; // no longer what the camera sees, bent at most
    }
    if (out.interfaces == 0) {
        // The same straight way: distances and densities of lights are those from where it began.
        if (state.scatterings > 0) {
            path_.ray = Ray();
            path_.ray.origin = visited_.point;
        }
        path_.ray.direction = state.scatterings > 0 ? direction : path_.ray.direction;
        path_.ray.tNear =
            std::max(0.0f, dot(exit - path_.ray.origin, path_.ray.direction)) * (1 + 1e-6f) + scene_.shadowOffset;
        if (visited_.asked == Asked::Cones) { // by a rim, without the interface that cones look through
            visited_ = {};
        }
        return;
    }
    if (visited_.asked != Asked::Cones || out.interfaces > 1) {
        visited_ = {};
    }
    if (!path_.seen()) {
        path_.lights = LightPath::Lights::All;
    }
    path_.ray = Ray();
    path_.ray.direction = direction;
    path_.ray.origin = exit + instance.worldNormal(out.outward) * scene_.shadowOffset;
}

void ReferenceIntegrator::visit(const WalkVertex& vertex, const Rgb& throughput) {
    const Rgb light = walkOf(*inside_).medium().refracts() ? refractedLight(vertex) : straightLight(vertex);
    add(throughput * light);
}

void ReferenceIntegrator::turned(const WalkVertex& v, const Vec3f& direction) {
    const float density = henyeyGreenstein(v.g, v.direction, direction);
    visited_.point = inside_->worldPoint(v.point);
    visited_.share = 1;
    path_.mirrored = true;
    if (walkOf(*inside_).medium().refracts()) {
        visited_.asked = Asked::Cones;
        visited_.share = density / (density + cones_.density(direction));
        path_.lights = LightPath::Lights::All;
        path_.links = inside_->links;
        return;
    }
    visited_.asked = Asked::Straight;
    path_.lights = LightPath::Lights::Shared;
    path_.density = density;
    path_.domeSamples = 1;
    path_.shadowless = true;
    path_.normal = inside_->worldNormal(v.normal);
    path_.links = inside_->links;
}

// One light, any with the same chance.
Rgb ReferenceIntegrator::straightLight(const WalkVertex& v) {
    const std::size_t count = scene_.lights.count();
    if (count == 0) {
        return Rgb(0.0f);
    }
    const std::size_t l = std::min(count - 1, std::size_t(rng_.uniform() * float(count)));
    const Vec3f point = inside_->worldPoint(v.point);
    const float u1 = rng_.uniform(), u2 = rng_.uniform();
    const LightSample light = scene_.lights.sample(l, point, inside_->worldNormal(v.normal), {u1, u2});
    if (!(maxComponent(light.irradiance) > 0) || (light.lit != 0 && (light.lit & inside_->links) == 0)) {
        return Rgb(0.0f);
    }
    Ray ray = shadowRay(point, light);
    ShellWalk::State state;
    state.origin = v.point;
    state.direction = inside_->objectDirection(ray.direction);
    state.region = v.inCore ? ShellWalk::Region::Core : ShellWalk::Region::Material;
    const float phase = henyeyGreenstein(v.g, v.direction, state.direction);
    const float share = light.density > 0 ? light.density / (light.density + phase) : 1.0f;
    ShellWalk::Outcome out;
    Rgb left = walkOf(*inside_).wayOut(state, rng_, out);
    if (!(maxComponent(left) > 0)) {
        return left;
    }
    if (light.shadows) {
        ray.tNear = std::max(0.0f, dot(inside_->worldPoint(out.point) - point, ray.direction)) * (1 + 1e-6f) +
                    scene_.shadowOffset;
        left *= rays_.throughSurfaces(ray, light.shading, sampler_);
    }
    return light.irradiance * left * (phase * share * float(count));
}

// What a shell leaves of light that goes straight on, by ratio tracking; nothing where it would be refracted.
Rgb ReferenceIntegrator::straightThrough(const PreparedInstance& instance, Ray& ray, const RayHit& hit) {
    const Vec3f direction = instance.objectDirection(ray.direction);
    float start = hit.t;
    Rgb left(1.0f);
    if (dot(direction, hit.geometricNormal) < 0) {
        ShellWalk& walk = walkOf(instance);
        if (walk.medium().refracts()) {
            return Rgb(0.0f);
        }
        ShellWalk::Outcome out;
        left = walk.passThrough(surfelAt(instance, ray, hit).objectPoint, direction, hit.triangle, rng_, out);
        start = std::max(start, dot(instance.worldPoint(out.point) - ray.origin, ray.direction));
    }
    ray.tNear = start * (1 + 1e-6f) + scene_.shadowOffset;
    return left;
}

Rgb ReferenceIntegrator::refractedLight(const WalkVertex& v) {
    cones_.clear();
    const Vec3f point = inside_->worldPoint(v.point), normal = inside_->worldNormal(v.normal);
    const float ior = v.inCore ? walkOf(*inside_).iorAbove() : v.ior;
    const std::size_t count = scene_.lights.count() - scene_.lights.meshCount();
    for (std::size_t l = 0; l < count; ++l) {
        if (scene_.lights.isDome(l)) {
            continue;
        }
        // A distant light's disc has its middle at (0, 0), other shapes have theirs about the middle of their samples.
        LightSample light = scene_.lights.sample(l, point, normal, {0.5f, 0.5f});
        if (!(light.distance < std::numeric_limits<float>::infinity())) {
            light.towards = scene_.lights.sample(l, point, normal, {0, 0}).towards;
        }
        if (light.density > 0) {
            const float cosHalf = 1 - 1 / (2 * kPi * light.density);
            cones_.add(inside_->objectDirection(light.towards), v.normal, ior, cosHalf);
        }
    }
    if (cones_.empty()) {
        return Rgb(0.0f);
    }
    ShellWalk::State state;
    state.origin = v.point;
    const float pick = rng_.uniform(), u1 = rng_.uniform(), u2 = rng_.uniform();
    state.direction = cones_.sample(pick, u1, u2);
    state.region = v.inCore ? ShellWalk::Region::Core : ShellWalk::Region::Material;
    const float own = cones_.density(state.direction), phase = henyeyGreenstein(v.g, v.direction, state.direction);
    ShellWalk::Outcome out;
    const Rgb left = walkOf(*inside_).wayOut(state, rng_, out);
    if (!(maxComponent(left) > 0) || out.interfaces != 1) {
        return Rgb(0.0f);
    }
    Ray ray;
    ray.direction = inside_->worldDirection(out.direction);
    ray.origin = inside_->worldPoint(out.point) + inside_->worldNormal(out.outward) * scene_.shadowOffset;
    RayHit hit;
    const float tMax = rays_.intersect(ray, hit) ? hit.t : std::numeric_limits<float>::infinity();
    return scene_.lights.mirrored(ray.origin, ray.direction, ray.tNear, tMax, 0, inside_->links) * left *
           (phase / (own + phase));
}

} // namespace stf
