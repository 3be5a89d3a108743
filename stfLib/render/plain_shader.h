// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/light_path.h"
#include "stfLib/render/scene_rays.h"
#include "stfLib/render/surfel.h"

namespace stf {

/// Light of surfaces that are no shells: UsdPreviewSurface where a material is bound, else Lambert in the displayColor.
/// One per thread.
class PlainShader {
public:
    PlainShader(const PreparedScene& scene, SceneRays& rays) : scene_(scene), rays_(rays) {}

    struct Step {
        Rgb radiance{0.0f}; ///< towards where the path came from, without its throughput
        bool covers = true; ///< false: the path goes straight on, nothing is here
        bool ends = false;
    };
    /// Emission and direct light at a hit; the path gets its next ray, which finds the light that comes by way of other
    /// surfaces and shares that of the lights.
    Step shade(LightPath& path, const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit,
               PixelSampler& sampler);

    /// What comes along a ray by way of plain surfaces.
    struct Sight {
        Rgb radiance{0.0f}; ///< their emission and the light that they get directly, after up to maxDepth bounces
        Rgb weight{0.0f};   ///< of light that leaves a shell, where the path ends at the front of one, at `hit`
        RayHit hit;
    };
    /// Emission of meshes that samples of lights find as well is left to these, but for what the ray itself meets,
    /// where `density`, of the ray per solid angle, says how many such rays there are for each of `lightSamples`
    /// samples (balance heuristic).
    Sight look(Ray ray, PixelSampler& sampler, float density = 0, int lightSamples = 1);

    /// Light that other surfaces send to a point (world) of a shell: one direction by the cosine to its normal, and
    /// what comes from there, as perpendicular irradiance over the density; of shells the radiance that is kept for
    /// them. `lightSamples`: how many samples the point takes of a light with an area besides, each with the share
    /// that `besideBounced` gives.
    LightSample bounced(const Vec3f& origin, const Vec3f& normal, int lightSamples, PixelSampler& sampler);
    static float besideBounced(const LightSample& light, const Vec3f& normal, int lightSamples);

    /// Whether more of a surface is missing than there, by its opacity.
    static bool isHole(const PreparedInstance& instance, const Ray& ray, const RayHit& hit);
    /// Albedo, for the AOV.
    static Rgb albedo(const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit);

    /// What a path that only looks for lights takes of a mesh that is one.
    Rgb lightMet(const LightPath& path, const PreparedInstance& instance, const RayHit& hit) const;

private:
    // A hit with its frame, whose z is the shading normal on the side of the ray.
    struct Vertex {
        Vec3f point, origin; // origin: of rays that leave
        Vec3f x, y, z;
        Vec3f geometric; // on the side of the ray
        Vec3f out;       // in the frame
        PreviewPoint at;
        const PreparedInstance* instance = nullptr;
        Vec3f toLocal(const Vec3f& d) const { return {dot(d, x), dot(d, y), dot(d, z)}; }
        Vec3f toWorld(const Vec3f& d) const { return normalize(x * d.x + y * d.y + z * d.z); }
    };
    /// `spread`: of the path so far. What wide lobes see is no sharper: narrower lobes are widened to it.
    float emissionShare(const LightPath& path, const PreparedInstance& instance, const RayHit& hit) const;
    Vertex vertexAt(const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit, const Vec3f& direction,
                    float spread) const;
    /// Whether a path goes straight on at a surface that is not opaque: its throughput is that behind then. Else what
    /// the surface sends counts by `weight`.
    static bool goesThrough(const Vertex& vertex, const PreviewBsdf& bsdf, Rgb& throughput, float& weight,
                            PixelSampler& sampler);
    /// What leaves shells, by one sample of it, where a ray looks for it as well.
    Rgb glow(const Vertex& vertex, const PreviewBsdf& bsdf, PixelSampler& sampler);
    Rgb direct(const Vertex& vertex, const PreviewBsdf& bsdf, int domeDirections, bool shared, PixelSampler& sampler);

    const PreparedScene& scene_;
    SceneRays& rays_;
};

} // namespace stf
