// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/sampler.h"
#include "stfLib/render/film.h"
#include "stfLib/surface/ray_scene.h"

#include <functional>
#include <memory>

namespace stf {

struct PreparedScene;

/// Light along camera rays by other means than transport tables. One per thread.
class PathTracer {
public:
    virtual ~PathTracer() = default;
    /// A sample of a pixel along a camera ray. `time`: of the exposure, 0 to 1.
    virtual PixelSample sample(const Ray& ray, float time, PixelSampler& sampler) = 0;
    virtual std::uint64_t rays() const = 0;
};

/// Makes path tracers of one scene, from any thread; the scene outlives them.
using PathTracerMaker = std::function<std::unique_ptr<PathTracer>()>;
/// How a scene is path traced: given by who builds a Renderer (layer `reference` has one).
using PathTracerProvider = std::function<PathTracerMaker(const PreparedScene& scene)>;

} // namespace stf
