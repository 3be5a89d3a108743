// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/reference/light_cones.h"
#include "stfLib/reference/shell_walk.h"
#include "stfLib/render/path_tracer.h"
#include "stfLib/render/plain_shader.h"

#include <unordered_map>

namespace stf {

/// The unbiased reference (DESIGN section 6): a volumetric path tracer of what the STF renderer draws, on the same
/// surfaces, shell grids and base volumes, without tables, without a scaled medium and without a diffusion model of the
/// core. Surfaces that are no shells are shaded by PlainShader. docs/reference.md says what it leaves out.
///
/// Where a shell does not refract, each vertex asks one light (next event estimation, shared with the path's own
/// direction by the balance heuristic; Veach 1997), through all shells that do not refract either. Where it refracts,
/// vertices choose a direction around where a flat surface would bend light to, follow it out, and share what shines
/// there the same way; other light is found by the path's own direction.
class ReferenceIntegrator : public PathTracer, private WalkVisitor {
public:
    /// The media of a scene's shells, made once for all threads.
    using Media = std::unordered_map<const BaseVolume*, std::shared_ptr<const ReferenceMedium>>;
    ReferenceIntegrator(const PreparedScene& scene, std::shared_ptr<const Media> media);

    PixelSample sample(const Ray& ray, float time, PixelSampler& sampler) override;
    std::uint64_t rays() const override;

    /// For Renderer.
    static PathTracerMaker maker(const PreparedScene& scene);

private:
    /// How a path's last vertex inside an object asked for lights: what its own direction meets is shared with that.
    enum class Asked { Nothing, Straight, Cones };
    struct Visited {
        Asked asked = Asked::Nothing;
        Vec3f point;     ///< world
        float share = 1; ///< of lights that cones find
    };

    ShellWalk& walkOf(const PreparedInstance& instance);
    /// The path goes on after a shell. False where it ends.
    bool crossShell(const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit);
    void leave(const PreparedInstance& instance, const ShellWalk::Outcome& out, const ShellWalk::State& state);
    void visit(const WalkVertex& vertex, const Rgb& throughput) override;
    void turned(const WalkVertex& vertex, const Vec3f& direction) override;
    Rgb straightLight(const WalkVertex& vertex);
    Rgb refractedLight(const WalkVertex& vertex);
    Rgb straightThrough(const PreparedInstance& instance, Ray& ray, const RayHit& hit);
    void add(const Rgb& light) {
        out_.color += light;
        out_.reflection += reflected_ ? light : Rgb(0.0f);
    }

    const PreparedScene& scene_;
    std::shared_ptr<const Media> media_;
    SceneRays rays_;
    PlainShader plain_;
    std::vector<std::unique_ptr<ShellWalk>> walks_; ///< by instance

    // Of the path.
    CounterRng rng_{0, 0};
    PixelSampler* sampler_ = nullptr;
    PixelSample out_;
    LightPath path_;
    Visited visited_;
    bool reflected_ = false;                   ///< by the surface of the shell that was seen
    const PreparedInstance* inside_ = nullptr; ///< of the walk
    LightCones cones_;                         ///< of the vertex
};

} // namespace stf
