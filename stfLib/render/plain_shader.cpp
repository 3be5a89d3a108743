// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/plain_shader.h"

#include "stfLib/base/hemisphere.h"
#include "stfLib/render/shell_glow.h"
#include "stfLib/render/shells_compiled.h"

namespace stf {

namespace {

constexpr float kLeastCosine = 1e-4f; // of the viewer, where the smooth normal turns away while the triangle is seen
constexpr int kMostClear = 64;        // surfaces that a ray goes straight through
constexpr float kWideSpread = 0.5f;   // radians, of Lambert's lobe and of light in a shell

PreviewPoint lambert(const Rgb& color) {
    PreviewPoint p;
    p.diffuse = color;
    return p;
}

PreviewPoint pointAt(const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit) {
    return instance.material ? instance.material->at(uvAt(*instance.mesh->surface, hit), surfel.albedo)
                             : lambert(surfel.albedo);
}

} // namespace

bool PlainShader::isHole(const PreparedInstance& instance, const Ray& ray, const RayHit& hit) {
    if (!instance.material || instance.material->opaque()) {
        return false;
    }
    const PreviewPoint p = pointAt(instance, surfelAt(instance, ray, hit), hit);
    return p.presence && p.opacity < 0.5f;
}

Rgb PlainShader::albedo(const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit) {
    const PreviewPoint p = pointAt(instance, surfel, hit);
    return p.diffuse + p.f0;
}

PlainShader::Vertex PlainShader::vertexAt(const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit,
                                          const Vec3f& direction, float spread) const {
    Vertex v;
    v.at = pointAt(instance, surfel, hit);
    v.instance = &instance;
    if (spread > 0 && scene_.regularize) {
        const float least = std::sqrt(regularizedAlpha(spread)); // roughness
        v.at.roughness = std::max(v.at.roughness, least);
        v.at.clearcoatRoughness = std::max(v.at.clearcoatRoughness, least);
    }
    v.point = surfel.point;
    v.z = dot(surfel.normal, direction) > 0 ? -surfel.normal : surfel.normal;
    v.origin = instance.worldPoint(surfel.shadowOrigin) + v.z * scene_.shadowOffset;
    const Vec3f facet = instance.worldNormal(hit.geometricNormal);
    v.geometric = dot(facet, direction) > 0 ? -facet : facet;
    if (instance.material && instance.material->hasNormalMap()) {
        const RefinedSurface& s = *instance.mesh->surface;
        bool mirrored = false;
        const Vec3f along(instance.objectToWorld.vector(Vec3d(uvTangent(s, hit.triangle, mirrored))));
        const Vec3f t = normalize(along - surfel.normal * dot(surfel.normal, along));
        if (dot(t, t) > 0.5f) {
            const Vec3f b = cross(surfel.normal, t) * (mirrored ? -1.0f : 1.0f);
            const Vec3f n = instance.material->normalAt(uvAt(s, hit));
            const Vec3f bent = normalize(t * n.x + b * n.y + surfel.normal * n.z);
            const Vec3f turned = dot(surfel.normal, v.z) < 0 ? -bent : bent;
            v.z = dot(turned, direction) < 0 ? turned : v.z;
        }
    }
    orthonormalBasis(v.z, v.x, v.y);
    v.out = v.toLocal(-direction);
    v.out.z = std::max(kLeastCosine, v.out.z);
    return v;
}

Rgb PlainShader::direct(const Vertex& v, const PreviewBsdf& bsdf, int domeDirections, bool shared,
                        PixelSampler& sampler) {
    Rgb sum(0.0f);
    LightPick picks[kMaxLightsPerPath];
    rays_.setReceiver(*v.instance);
    const int count = rays_.chooseLights(v.point, v.z, sampler, picks);
    for (int i = 0; i < count; ++i) {
        const std::size_t l = picks[i].light;
        const int directions = scene_.lights.isDome(l) ? domeDirections : 1;
        const bool extent = scene_.lights.hasExtent(l);
        const PixelSampler::Points u = extent ? sampler.next2dPoints(directions) : sampler.skip2dPoints();
        for (int k = 0; k < directions; ++k) {
            const LightSample light = scene_.lights.sample(l, v.point, v.z, extent ? u[k] : Vec2f());
            const float cosine = dot(v.z, light.towards);
            if (!(cosine > 0) || !(maxComponent(light.irradiance) > 0)) {
                continue;
            }
            const Vec3f in = v.toLocal(light.towards);
            Rgb share = bsdf.evaluate(v.out, in) * (cosine * picks[i].weight / float(directions));
            if (shared && light.density > 0) {
                const float own = light.density * float(directions);
                share *= own / (own + bsdf.density(v.out, in));
            }
            if (maxComponent(share) > 0) {
                sum += light.irradiance * share * rays_.visibility(v.origin, light, &sampler);
            }
        }
    }
    return sum;
}

Rgb PlainShader::glow(const Vertex& v, const PreviewBsdf& bsdf, PixelSampler& sampler) {
    const float pick = sampler.next1d();
    const LightSample light = scene_.glow->sample(v.point, v.z, pick, sampler.next2d());
    const float cosine = dot(v.z, light.towards);
    if (!(cosine > 0) || !(maxComponent(light.irradiance) > 0)) {
        return Rgb(0.0f);
    }
    const Vec3f in = v.toLocal(light.towards);
    const Rgb share = bsdf.evaluate(v.out, in) * (cosine * light.density / (light.density + bsdf.density(v.out, in)));
    return maxComponent(share) > 0 ? light.irradiance * share * rays_.visibility(v.origin, light, &sampler) : Rgb(0.0f);
}

// What a path takes of the emission that it meets: samples of lights find the meshes among them as well.
float PlainShader::emissionShare(const LightPath& path, const PreparedInstance& instance, const RayHit& hit) const {
    if (path.seen() || path.lights == LightPath::Lights::All || scene_.lights.meshCount() == 0) {
        return 1;
    }
    const Vec3f facet = normalize(Vec3f(instance.objectToWorld.normal(Vec3d(hit.geometricNormal))));
    const float sampled = scene_.lights.emitterDensity(instance.index, hit.t, dot(facet, path.ray.direction));
    if (!(sampled > 0)) {
        return 1;
    }
    return path.lights == LightPath::Lights::Shared ? path.density / (path.density + sampled) : 0.0f;
}

Rgb PlainShader::lightMet(const LightPath& path, const PreparedInstance& instance, const RayHit& hit) const {
    if (!(scene_.lights.emitterDensity(instance.index, 1, 1) > 0)) {
        return Rgb(0.0f);
    }
    return instance.material->emission() * emissionShare(path, instance, hit);
}

// One of both ways, so that what is behind is seen as often as it shines through.
bool PlainShader::goesThrough(const Vertex& v, const PreviewBsdf& bsdf, Rgb& throughput, float& weight,
                              PixelSampler& sampler) {
    weight = 1;
    if (!(v.at.opacity < 1)) {
        return false;
    }
    const Rgb through = bsdf.through(v.out);
    const float chance = v.at.presence ? through.x : std::min(1.0f, maxComponent(through));
    if (sampler.next1d() < chance) {
        throughput *= through / chance;
        return true;
    }
    // What is there by chance counts as it is; a clear surface reflects wholly wherever it is.
    weight = v.at.presence ? 1.0f : 1 / (1 - chance);
    return false;
}

PlainShader::Step PlainShader::shade(LightPath& path, const PreparedInstance& instance, const Surfel& surfel,
                                     const RayHit& hit, PixelSampler& sampler) {
    Step step;
    const Vec3f direction = path.ray.direction;
    const Vertex v = vertexAt(instance, surfel, hit, direction, path.spread);
    const PreviewBsdf bsdf(v.at);
    float weight = 1;
    if (goesThrough(v, bsdf, path.throughput, weight, sampler)) {
        path.ray.tNear = hit.t * (1 + 1e-6f) + scene_.shadowOffset;
        step.covers = false;
        return step;
    }
    path.throughput *= weight;

    const bool onward = path.bounces < scene_.maxDepth && scene_.surfacesBounce, glossy = !v.at.isLambert();
    // Where a ray may meet a light that samples find: one near or large is found badly by samples, a small one by rays.
    const bool shared = glossy || scene_.lights.meshCount() > 0;
    const int domes = path.seen() ? kDomeDirections : 1;
    step.radiance =
        (v.at.emission * emissionShare(path, instance, hit) + direct(v, bsdf, domes, shared, sampler)) * weight;
    step.ends = true;
    if (!onward && !shared) {
        return step;
    }
    const bool glowing = kShellsCompiled && onward && scene_.glow && path.seen();
    if (glowing) {
        step.radiance += glow(v, bsdf, sampler) * weight;
    }
    const PreviewBsdf::Sample s = bsdf.sample(v.out, glossy ? sampler.next1d() : 0.0f, sampler.next2d());
    const Vec3f towards = v.toWorld(s.in);
    if (!(maxComponent(s.weight) > 0) || !(dot(towards, v.geometric) > 0)) {
        return step;
    }
    path.throughput *= s.weight;
    path.travelled += hit.t;
    path.spread += s.spread;
    path.bounced = true;
    ++path.bounces;
    path.lights = shared ? LightPath::Lights::Shared : LightPath::Lights::None;
    path.lightsOnly = !onward;
    path.density = s.density;
    path.domeSamples = domes;
    path.glowShared = glowing;
    path.normal = v.z;
    path.links = instance.links;
    path.shadowless = true;
    path.ray = Ray();
    path.ray.origin = v.origin;
    path.ray.direction = towards;
    step.ends = false;
    return step;
}

float PlainShader::besideBounced(const LightSample& light, const Vec3f& normal, int lightSamples) {
    if (!light.onMesh) {
        return 1; // no ray meets it
    }
    const float own = light.density * float(lightSamples);
    return own / (own + mixedHemisphereDensity(dot(normal, light.towards)));
}

PlainShader::Sight PlainShader::look(Ray ray, PixelSampler& sampler, float density, int lightSamples) {
    Sight sight;
    Rgb throughput(1.0f);
    int passed = 0;
    for (int bounce = 0; bounce < scene_.maxDepth; ++bounce) {
        if (!rays_.intersect(ray, sight.hit)) {
            // Where it left the last surface samples of lights have found the domes.
            sight.radiance += bounce == 0 && scene_.keepsDomes
                                  ? throughput * scene_.lights.smoothBackground(ray.direction)
                                  : Rgb(0.0f);
            return sight;
        }
        const PreparedInstance& instance = rays_.instance(sight.hit.instance);
        if (instance.mesh->shell) {
            const Vec3f local(instance.worldToObject.vector(Vec3d(ray.direction)));
            if (dot(local, sight.hit.geometricNormal) < 0) { // its inside has no light of its own
                sight.weight = throughput;
            }
            return sight;
        }
        const Vertex v = vertexAt(instance, surfelAt(instance, ray, sight.hit), sight.hit, ray.direction, kWideSpread);
        const PreviewBsdf bsdf(v.at);
        float weight = 1;
        if (goesThrough(v, bsdf, throughput, weight, sampler)) {
            ray.tNear = sight.hit.t * (1 + 1e-6f) + scene_.shadowOffset;
            bounce += ++passed > kMostClear ? scene_.maxDepth : -1;
            continue;
        }
        throughput *= weight;
        const float sampled =
            scene_.lights.emitterDensity(instance.index, sight.hit.t, dot(v.geometric, ray.direction));
        const float own = bounce == 0 ? density : 0.0f;
        const float share = sampled > 0 ? own / (own + float(lightSamples) * sampled) : 1.0f;
        sight.radiance += throughput * (v.at.emission * share + direct(v, bsdf, 1, false, sampler));
        const PreviewBsdf::Sample s = bsdf.sample(v.out, v.at.isLambert() ? 0.0f : sampler.next1d(), sampler.next2d());
        throughput *= s.weight;
        const float chance = std::min(1.0f, maxComponent(throughput));
        ray = Ray();
        ray.origin = v.origin;
        ray.direction = v.toWorld(s.in);
        if (!(dot(ray.direction, v.geometric) > 0) || !(sampler.next1d() < chance)) {
            return sight;
        }
        throughput /= chance;
    }
    return sight;
}

LightSample PlainShader::bounced(const Vec3f& origin, const Vec3f& normal, int lightSamples, PixelSampler& sampler) {
    LightSample light;
    Vec3f x, y;
    orthonormalBasis(normal, x, y);
    const Vec3f d = mixedHemisphere(sampler.next2d());
    Ray ray;
    ray.origin = origin;
    ray.direction = normalize(x * d.x + y * d.y + normal * d.z);
    light.towards = ray.direction;
    light.density = mixedHemisphereDensity(d.z);
    const Sight sight = look(ray, sampler, light.density, lightSamples);
    Rgb radiance = sight.radiance;
    if (maxComponent(sight.weight) > 0) {
        const RayHit& at = sight.hit;
        radiance += sight.weight * exitantAt(scene_.instances[at.instance], at.triangle, at.u, at.v);
    }
    light.irradiance = radiance / light.density;
    return light;
}

} // namespace stf
