// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/render/camera.h"
#include "stfLib/render/exactness.h"
#include "stfLib/render/film.h"
#include "stfLib/render/path_tracer.h"
#include "stfLib/render/scene.h"

#include <functional>
#include <memory>

namespace stf {

class StfTable;
struct BaseVolume;
struct ExemplarMap;
struct TransportOptions;

/// The settings a host can change (tokens `stf:*`).
struct RenderSettings {
    int samples = 64; ///< per pixel
    std::uint64_t seed = 0;
    /// Wanted relative error of a pixel's luminance: pixels that are below it get no more samples (`samples` is the
    /// most). 0: all get `samples`.
    float errorTarget = 0;
    int threads = 0;               ///< 0 = all cores
    float quality = 0.02f;         ///< target relative error of the tables, where a binding does not say
    std::uint64_t tableSeed = 0;   ///< of the walks that tables are made from
    std::string transport = "dE1"; ///< form of the tables, where a binding does not say: dE1, classic
    int maxDepth = 4;              ///< bounces off surfaces that are no shells; 0: direct light alone
    float indirectClamp = 0;       ///< most that a bounced path brings (radiance, largest channel); 0: no limit
    bool regularize = true;        ///< what bounced paths would find as rare bright dots is blurred
    std::string pixelFilter = "blackmanHarris"; ///< box, triangle, gaussian, blackmanHarris
    float pixelFilterWidth = 0;                 ///< of its support, pixels; 0: the filter's own
    bool depthOfField = true;                   ///< the camera's lens counts; else it is a pinhole
    std::string integrator = "stf";             ///< stf, or reference: path traced, without tables
    /// Shells read light of other surfaces where it is kept for samples of theirs; else paths look for it.
    bool irradianceCache = true;
    bool motionBlur = true; ///< what moves while the shutter is open is blurred
    Exactness exact;        ///< what is finer than usual, to measure errors
    bool operator==(const RenderSettings& s) const {
        return samples == s.samples && seed == s.seed && errorTarget == s.errorTarget && threads == s.threads &&
               quality == s.quality && tableSeed == s.tableSeed && transport == s.transport && maxDepth == s.maxDepth &&
               indirectClamp == s.indirectClamp && regularize == s.regularize && pixelFilter == s.pixelFilter &&
               pixelFilterWidth == s.pixelFilterWidth && depthOfField == s.depthOfField && integrator == s.integrator &&
               motionBlur == s.motionBlur && irradianceCache == s.irradianceCache && exact == s.exact;
    }
};

/// One line of the plan: a stage that ran or was left out, and why.
struct PlanEntry {
    std::string object; ///< prim, or "scene"
    std::string stage;
    bool runs = false;
    std::string why;
    double seconds = 0;
};

struct RenderStats {
    /// Stages run so far: surfaces refined, samples laid out by synthesis, shell grids filled, poses taken.
    int refinements = 0, syntheses = 0, grids = 0, poses = 0;
    double precomputeSeconds = 0, synthesisSeconds = 0, shellSeconds = 0, coreSeconds = 0, indirectSeconds = 0,
           loadSeconds = 0;
    double firstPixelSeconds = 0; ///< from the start of prepare to the first pixels, coarse or not
    double renderSeconds = 0;
    std::size_t tableBytes = 0, shellBytes = 0;
    std::uint64_t rays = 0;
    int samplesDone = 0;
    double estimatedError = 0;
};

/// How tables are had: computed at once, or through a store (the cache layer gives one).
using TableProvider = std::function<std::shared_ptr<const StfTable>(const std::shared_ptr<const BaseVolume>& volume,
                                                                    const TransportOptions& options, Progress& progress,
                                                                    const MessageSink& messages)>;

/// How synthesised exemplar coordinates are had: by `make`, or through a store by their key.
using MapProvider = std::function<std::shared_ptr<const ExemplarMap>(
    const std::string& key, const std::function<ExemplarMap()>& make, Progress& progress, const MessageSink& messages)>;

/// Renders a Scene progressively. Owned and driven by one thread (a host's render thread); `Progress::cancel` of the
/// progress handed to `prepare` and `renderPass` may be called from any other.
class Renderer {
public:
    /// `reference`: for the setting `integrator`; without it there is only stf.
    explicit Renderer(TableProvider tables = {}, MapProvider maps = {}, PathTracerProvider reference = {});
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    void setMessages(MessageSink messages);
    /// Throws Error for a pixel filter or an integrator that does not exist.
    void setSettings(const RenderSettings& settings);
    void setCamera(const Camera& camera, int width, int height);
    void setCamera(const Camera& camera, const FrameWindow& window);
    /// Background where no dome covers it: colour and alpha. The camera's exposure does not touch it.
    void setClearColor(const Rgb& color, float alpha);

    /// Whether the film keeps which objects cover a pixel, for the AOVs of cryptomattes; restarts nothing by itself.
    void keepCoverage(bool keep);

    /// Brings everything derived up to date with the scene: only what an edit touched. A mesh whose preparation fails
    /// is reported once with its id and left out or drawn with its displayColor. Throws Cancelled.
    void prepare(const Scene& scene, Progress& progress);
    /// Brings the scene into a state in which it can be shown while `prepare`, which has to follow, would take long:
    /// with shells, cores and light between surfaces as they were before the edit, and new shells as plain surfaces of
    /// their displayColor. False where nothing has shells, nothing changed, or the integrator is not stf: it did
    /// nothing then. Its image is not that of `prepare`. Throws Cancelled.
    bool prepareDraft(const Scene& scene, Progress& progress);
    /// Restarts the image (film cleared, sample 0).
    void restart();
    /// Adds one sample to every pixel. Returns false, with the pass undone for no pixel, when cancelled: call restart.
    /// `stride` above 1: only to every so many-th pixel of every so many-th row, from 0 on; the pass is not over then,
    /// and goes on with the next call, for pixels that have not had their sample of it.
    bool renderPass(Progress& progress, int stride = 1);
    bool converged() const;
    /// Takes the noise out of the colour as it is now, for `Aov::Denoised`; the next pass drops that. Where lens and
    /// motion leave the first hits sharp in the pixels, their albedo and normal help. Where Open Image Denoise is
    /// missing or fails, a warning says so once and nothing changes.
    void denoise();

    const Film& film() const;
    RenderStats stats() const;
    std::vector<PlanEntry> plan() const;
    /// Names of all objects that are drawn, each once, sorted: cryptomattes know them by these.
    std::vector<std::string> objectNames() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace stf
