// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/messages.h"
#include "hdStf/window.h"
#include "stfLib/render/forecast.h"
#include "stfLib/render/renderer.h"

#include "pxr/imaging/hd/aov.h"
#include "pxr/imaging/hd/renderThread.h"
#include "pxr/pxr.h"

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class HdStfRenderBuffer;

/// \class HdStfRenderJob
///
/// Drives stf::Renderer on Hydra's render thread: prepares the scene, adds passes until the image has converged, and
/// writes the bound AOV buffers after the first and the last pass and in between as often as it is worth.
///
/// Threading: the host's thread configures the job and starts it; StopRender may be called from any thread and returns
/// when nothing runs any more. Setters stop rendering by themselves. GetProgress may be called at any time.
class HdStfRenderJob {
public:
    /// A picture of the job's state, taken between passes.
    struct Progress {
        std::string stage;
        double stageFraction = 0;
        int samplesDone = 0;
        int samplesWanted = 0;
        bool finished = false;
        double clockSeconds = 0;
        stf::RenderStats stats;
        std::vector<stf::PlanEntry> plan;
        std::vector<std::string> objectNames;     ///< of a cryptomatte, where one is rendered
        std::vector<stf::ForecastEntry> forecast; ///< instead of it, where no work is done
    };

    HdStfRenderJob(stf::Scene& scene, HdStfMessages& messages);
    ~HdStfRenderJob();

    /// \p denoise: the converged colour is shown without its noise.
    void SetSettings(stf::RenderSettings const& settings, bool denoise);
    /// Whether somebody looks on: pictures begin with coarse pixels and drafts.
    void SetInteractive(bool interactive);
    /// \p window: the pixels of the AOV buffers that are rendered, rows from the bottom up. \p frame: which part they
    /// are of what the projection covers; as large as the window.
    void SetCamera(stf::Matrix4 const& worldToView, stf::Matrix4 const& projection, stf::CameraOptics const& optics,
                   HdStfWindow const& window, stf::FrameWindow const& frame);
    /// Every binding has its buffer resolved to a pointer, or none.
    void SetAovBindings(HdRenderPassAovBindingVector const& bindings);
    /// Drops all bindings to \p buffer.
    void ForgetBuffer(HdStfRenderBuffer const* buffer);

    /// Starts rendering from the first sample, unless stopped by Stop(), or nothing can be rendered to.
    void StartRender();
    /// Cancels what runs and waits for its end.
    void StopRender();

    // What a host's user asks for.
    void Pause();
    void Resume();
    bool IsPaused() const { return _paused.load(); }
    /// Stops until Restart(); buffers count as converged meanwhile, so that nobody waits for them.
    void Stop();
    void Restart();
    bool IsStopped() const { return _stopped.load(); }

    /// True where every bound buffer is: nothing is being rendered into any of them.
    bool IsConverged() const;

    Progress GetProgress() const;

private:
    using _Clock = std::chrono::steady_clock;

    // On the render thread.
    void _Render();
    void _RenderUntilConverged(stf::Progress& progress);
    void _RenderDraft(stf::Progress& progress);
    bool _RenderFirstPass(stf::Progress& progress, double seconds);
    bool _ShowsCoarse() const;
    void _Foresee(stf::Progress& progress);
    void _WriteAovs(int stride = 1);
    void _WriteAov(HdRenderPassAovBinding const& binding, std::vector<int32_t> const& primIds, int stride);
    bool _WantsDenoised() const;
    void _WaitWhilePaused() const;
    void _TakeStats(bool withError);
    void _SetStage(std::string const& stage, double fraction);

    void _MarkBuffers(bool converged);

    stf::Scene& _scene;
    HdStfMessages& _messages;
    stf::Renderer _renderer;
    HdRenderThread _thread;
    std::atomic<bool> _cancel{false};
    std::atomic<bool> _paused{false};
    std::atomic<bool> _stopped{false};

    // Written by the host's thread while nothing renders.
    HdRenderPassAovBindingVector _bindings;
    HdStfWindow _window;
    bool _cameraUsable = false;
    bool _denoise = false;
    bool _interactive = true;
    bool _wantsCoverage = false;
    stf::RenderSettings _settings;
    int _samplesWanted = 0;
    _Clock::time_point _start;

    mutable std::mutex _progressMutex;
    Progress _progress;
};

PXR_NAMESPACE_CLOSE_SCOPE
