// SPDX-License-Identifier: Apache-2.0
#include "hdStf/renderJob.h"

#include "hdStf/renderBuffer.h"
#include "stfLib/base/thread_sanitizer.h"
#include "stfLib/cache/map_cache.h"
#include "stfLib/cache/table_cache.h"
#include "stfLib/reference/reference_integrator.h"

#include "pxr/base/gf/vec4f.h"
#include "pxr/base/tf/getenv.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <thread>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

using _Seconds = std::chrono::duration<double>;

/// Buffers are not written more often than this, nor for more than a tenth of the time.
constexpr double _minSecondsBetweenWrites = 0.05;
constexpr double _writeTimeShare = 0.1;

/// Pixels that are taken first, every so many-th, where there are enough of them: the image shows at once, in blocks.
constexpr int _strides[] = {8, 4, 2, 1};
constexpr int _leastPixels = 40000;

/// For as long a draft gets finer, while `prepare` waits.
constexpr double _draftSeconds = 0.3;

/// Progress whose cancellation is the job's flag, which stfLib may ask for from any of its threads.
class _JobProgress final : public stf::Progress {
public:
    _JobProgress(std::atomic<bool> const& cancel, Callback onUpdate)
        : stf::Progress(std::move(onUpdate)), _cancel(cancel) {}
    bool cancelled() const override { return _cancel.load(std::memory_order_relaxed) || stf::Progress::cancelled(); }

private:
    std::atomic<bool> const& _cancel;
};

/// AOVs of what is hit: where nothing is, the binding's clear value counts.
bool _IsOfHit(stf::Aov aov) {
    switch (aov) {
    case stf::Aov::Depth:
    case stf::Aov::CameraDepth:
    case stf::Aov::Normal:
    case stf::Aov::Neye:
    case stf::Aov::Position:
    case stf::Aov::Albedo:
    case stf::Aov::PrimId:
    case stf::Aov::InstanceId:
    case stf::Aov::ElementId:
        return true;
    default:
        return false;
    }
}

template<class T>
void _PutClearValue(std::vector<T>& pixels, int channels, std::vector<int32_t> const& primIds, VtValue const& value) {
    float components[4];
    const int given = static_cast<int>(HdStfClearComponents(value, components));
    if (given == 0) {
        return;
    }
    const int count = std::min(channels, 4);
    for (size_t i = 0; i < primIds.size(); ++i) {
        if (primIds[i] < 0) {
            for (int c = 0; c < count; ++c) {
                pixels[i * static_cast<size_t>(channels) + static_cast<size_t>(c)] =
                    static_cast<T>(components[std::min(c, given - 1)]);
            }
        }
    }
}

/// Pixels between those that were taken show the nearest of these to their lower left.
template<class T>
void _FillBlocks(std::vector<T>& pixels, int channels, int width, int height, int stride) {
    const size_t n = static_cast<size_t>(channels), row = static_cast<size_t>(width) * n;
    for (int y = 0; stride > 1 && y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const T* const from =
                pixels.data() + static_cast<size_t>(y - y % stride) * row + static_cast<size_t>(x - x % stride) * n;
            std::copy(from, from + n, pixels.data() + static_cast<size_t>(y) * row + static_cast<size_t>(x) * n);
        }
    }
}

} // namespace

HdStfRenderJob::HdStfRenderJob(stf::Scene& scene, HdStfMessages& messages)
    : _scene(scene), _messages(messages),
      _renderer(stf::cachedTables(), stf::cachedMaps(), &stf::ReferenceIntegrator::maker) {
    _renderer.setMessages(
        [this](stf::Severity severity, std::string const& text) { _messages.Report(severity, text); });
    _thread.SetRenderCallback([this] {
        _Render();
        stf::sanitizerGive(&_thread);
    });
    _thread.StartThread();
}

HdStfRenderJob::~HdStfRenderJob() {
    StopRender();
    _thread.StopThread();
}

void HdStfRenderJob::SetSettings(stf::RenderSettings const& settings, bool denoise) {
    StopRender();
    _denoise = denoise;
    _settings = settings;
    _samplesWanted = settings.samples;
    _renderer.setSettings(settings);
}

void HdStfRenderJob::SetInteractive(bool interactive) {
    StopRender();
    _interactive = interactive;
}

void HdStfRenderJob::SetCamera(stf::Matrix4 const& worldToView, stf::Matrix4 const& projection,
                               stf::CameraOptics const& optics, HdStfWindow const& window,
                               stf::FrameWindow const& frame) {
    StopRender();
    _window = window;
    _cameraUsable = false;
    if (window.IsEmpty()) {
        return;
    }
    try {
        _renderer.setCamera(stf::Camera(worldToView, projection, optics), frame);
        _cameraUsable = true;
    } catch (std::exception const& error) {
        _messages.Report(stf::Severity::Error, std::string("camera: ") + error.what() + "; nothing is rendered");
    }
}

void HdStfRenderJob::SetAovBindings(HdRenderPassAovBindingVector const& bindings) {
    StopRender();
    _bindings.clear();
    _wantsCoverage = false;
    _renderer.setClearColor(stf::Rgb(0.0f), 0.0f);
    for (HdRenderPassAovBinding const& binding : bindings) {
        auto* buffer = dynamic_cast<HdStfRenderBuffer*>(binding.renderBuffer);
        if (!buffer) {
            continue;
        }
        stf::Aov aov;
        if (!stf::aovFromName(binding.aovName.GetString(), aov)) {
            _messages.Report(stf::Severity::Warning, "AOV \"" + binding.aovName.GetString() +
                                                         "\" is not known; its buffer keeps its clear value");
            buffer->Clear(binding.clearValue);
            buffer->SetConverged(true);
            continue;
        }
        if (aov == stf::Aov::Color && !binding.clearValue.IsEmpty()) {
            float color[4];
            const size_t given = HdStfClearComponents(binding.clearValue, color);
            _renderer.setClearColor({color[0], color[1], color[2]}, given > 3 ? color[3] : 1.0f);
        }
        _wantsCoverage = _wantsCoverage || stf::aovIsCrypto(aov);
        buffer->ClearIfUnwritten(binding.clearValue);
        _bindings.push_back(binding);
    }
    _renderer.keepCoverage(_wantsCoverage);
}

void HdStfRenderJob::ForgetBuffer(HdStfRenderBuffer const* buffer) {
    StopRender();
    _bindings.erase(std::remove_if(_bindings.begin(), _bindings.end(),
                                   [buffer](HdRenderPassAovBinding const& b) { return b.renderBuffer == buffer; }),
                    _bindings.end());
}

void HdStfRenderJob::StartRender() {
    StopRender();
    {
        std::lock_guard<std::mutex> lock(_progressMutex);
        _progress.samplesDone = 0;
        _progress.samplesWanted = _samplesWanted;
        _progress.finished = false;
        _progress.stage = "prepare";
        _progress.stageFraction = 0;
    }
    if (_stopped.load() || _bindings.empty() || !_cameraUsable) {
        _MarkBuffers(true);
        std::lock_guard<std::mutex> lock(_progressMutex);
        _progress.finished = true;
        return;
    }
    _MarkBuffers(false);
    _start = _Clock::now();
    _cancel.store(false);
    _thread.StartRender();
}

void HdStfRenderJob::StopRender() {
    _cancel.store(true);
    _thread.StopRender();
    stf::sanitizerTake(&_thread); // it has waited for the callback, by an atomic of OpenUSD's library
}

void HdStfRenderJob::Pause() {
    _paused.store(true);
}

void HdStfRenderJob::Resume() {
    _paused.store(false);
}

void HdStfRenderJob::Stop() {
    _stopped.store(true);
    StopRender();
    _MarkBuffers(true);
}

void HdStfRenderJob::Restart() {
    _stopped.store(false);
    _paused.store(false);
    StartRender();
}

bool HdStfRenderJob::IsConverged() const {
    return std::all_of(_bindings.begin(), _bindings.end(),
                       [](HdRenderPassAovBinding const& binding) { return binding.renderBuffer->IsConverged(); });
}

HdStfRenderJob::Progress HdStfRenderJob::GetProgress() const {
    std::lock_guard<std::mutex> lock(_progressMutex);
    return _progress;
}

void HdStfRenderJob::_Render() {
    _JobProgress progress(_cancel, [this](std::string const& stage, double fraction) { _SetStage(stage, fraction); });
    try {
        if (TfGetenvBool("HDSTF_PLAN_ONLY", false)) {
            _Foresee(progress);
        } else {
            _RenderUntilConverged(progress);
        }
    } catch (stf::Cancelled const&) {
        return;
    } catch (std::exception const& error) {
        _messages.Report(stf::Severity::Error, std::string("rendering ended: ") + error.what());
    }
    if (_cancel.load()) {
        return; // whoever cancelled decides what becomes of the buffers
    }
    _SetStage("done", 1);
    {
        std::lock_guard<std::mutex> lock(_progressMutex);
        _progress.finished = true;
    }
    _MarkBuffers(true);
}

// Says what would be done; the buffers keep their clear values.
void HdStfRenderJob::_Foresee(stf::Progress& progress) {
    std::vector<stf::ForecastEntry> forecast = stf::foresee(_scene, _settings, stf::tablesKept(), progress);
    std::lock_guard<std::mutex> lock(_progressMutex);
    _progress.forecast = std::move(forecast);
}

// While what an edit made out of date is made anew, the host shows what there was before, under its new lights and in
// its new places, and shells that come for the first time as plain surfaces.
void HdStfRenderJob::_RenderDraft(stf::Progress& progress) {
    if (_ShowsCoarse() && _renderer.prepareDraft(_scene, progress)) {
        _renderer.restart();
        _SetStage("draft", 0);
        _RenderFirstPass(progress, _draftSeconds);
    }
}

bool HdStfRenderJob::_ShowsCoarse() const {
    return _interactive && double(_window.width) * double(_window.height) >= _leastPixels;
}

// The first pass, coarse pixels first; ends early, after those, when `seconds` are over. False where it was cancelled.
bool HdStfRenderJob::_RenderFirstPass(stf::Progress& progress, double seconds) {
    const _Clock::time_point start = _Clock::now();
    for (const int stride : _strides) {
        if (stride > 1 && !_ShowsCoarse()) {
            continue;
        }
        if (!_renderer.renderPass(progress, stride)) {
            return false;
        }
        if (stride > 1) {
            _WriteAovs(stride);
        }
        if (_Seconds(_Clock::now() - start).count() > seconds) {
            return true;
        }
    }
    return true;
}

void HdStfRenderJob::_RenderUntilConverged(stf::Progress& progress) {
    _RenderDraft(progress);
    _renderer.prepare(_scene, progress);
    _renderer.restart();
    _TakeStats(false);
    {
        std::vector<std::string> names = _wantsCoverage ? _renderer.objectNames() : std::vector<std::string>();
        std::lock_guard<std::mutex> lock(_progressMutex);
        _progress.objectNames = std::move(names);
    }

    _Clock::time_point lastWrite;
    double writeSeconds = 0;
    for (bool first = true; !_renderer.converged(); first = false) {
        _WaitWhilePaused();
        _SetStage("render", 0);
        if (!(first ? _RenderFirstPass(progress, std::numeric_limits<double>::infinity())
                    : _renderer.renderPass(progress))) {
            return;
        }
        if (_renderer.converged() && _WantsDenoised()) {
            _SetStage("denoise", 0);
            _renderer.denoise();
        }
        const _Clock::time_point now = _Clock::now();
        const double sinceWrite = _Seconds(now - lastWrite).count();
        const bool due = sinceWrite >= std::max(_minSecondsBetweenWrites, writeSeconds / _writeTimeShare);
        const bool write = first || due || _renderer.converged();
        _TakeStats(write);
        if (write) {
            _WriteAovs();
            lastWrite = _Clock::now();
            writeSeconds = _Seconds(lastWrite - now).count();
        }
    }
}

bool HdStfRenderJob::_WantsDenoised() const {
    return _denoise || std::any_of(_bindings.begin(), _bindings.end(), [](HdRenderPassAovBinding const& binding) {
               stf::Aov aov;
               return stf::aovFromName(binding.aovName.GetString(), aov) && aov == stf::Aov::Denoised;
           });
}

void HdStfRenderJob::_WaitWhilePaused() const {
    while (_paused.load() && !_cancel.load()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
}

void HdStfRenderJob::_WriteAovs(int stride) {
    std::vector<int32_t> primIds;
    for (HdRenderPassAovBinding const& binding : _bindings) {
        stf::Aov aov;
        if (primIds.empty() && stf::aovFromName(binding.aovName.GetString(), aov) && _IsOfHit(aov)) {
            primIds = _renderer.film().readIds(stf::Aov::PrimId);
            _FillBlocks(primIds, 1, _window.width, _window.height, stride);
        }
        _WriteAov(binding, primIds, stride);
    }
}

void HdStfRenderJob::_WriteAov(HdRenderPassAovBinding const& binding, std::vector<int32_t> const& primIds, int stride) {
    stf::Aov aov;
    if (!stf::aovFromName(binding.aovName.GetString(), aov)) {
        return;
    }
    if (aov == stf::Aov::Color && _denoise) {
        aov = stf::Aov::Denoised; // the colour itself, until that is there
    }
    auto* buffer = static_cast<HdStfRenderBuffer*>(binding.renderBuffer);
    const int channels = stf::aovChannels(aov);
    if (stf::aovIsInteger(aov)) {
        std::vector<int32_t> pixels = _renderer.film().readIds(aov);
        _FillBlocks(pixels, channels, _window.width, _window.height, stride);
        if (_IsOfHit(aov)) {
            _PutClearValue(pixels, channels, primIds, binding.clearValue);
        }
        buffer->Write(pixels, channels, _window, binding.clearValue);
    } else {
        std::vector<float> pixels = _renderer.film().read(aov);
        _FillBlocks(pixels, channels, _window.width, _window.height, stride);
        if (_IsOfHit(aov)) {
            _PutClearValue(pixels, channels, primIds, binding.clearValue);
        }
        buffer->Write(pixels, channels, _window, binding.clearValue);
    }
}

void HdStfRenderJob::_TakeStats(bool withError) {
    const stf::RenderStats stats = _renderer.stats();
    std::vector<stf::PlanEntry> plan = _renderer.plan();
    const double error = withError ? _renderer.film().relativeError() : 0;
    const double seconds = _Seconds(_Clock::now() - _start).count();

    std::lock_guard<std::mutex> lock(_progressMutex);
    const double lastError = _progress.stats.estimatedError;
    _progress.stats = stats;
    _progress.stats.estimatedError = withError ? error : lastError;
    _progress.plan = std::move(plan);
    _progress.samplesDone = stats.samplesDone;
    _progress.clockSeconds = seconds;
}

void HdStfRenderJob::_SetStage(std::string const& stage, double fraction) {
    const double seconds = _Seconds(_Clock::now() - _start).count();
    std::lock_guard<std::mutex> lock(_progressMutex);
    _progress.stage = stage;
    _progress.stageFraction = fraction;
    _progress.clockSeconds = seconds;
}

void HdStfRenderJob::_MarkBuffers(bool converged) {
    for (HdRenderPassAovBinding const& binding : _bindings) {
        static_cast<HdStfRenderBuffer*>(binding.renderBuffer)->SetConverged(converged);
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
