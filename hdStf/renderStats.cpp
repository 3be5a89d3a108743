// SPDX-License-Identifier: Apache-2.0
#include "hdStf/renderStats.h"

#include "hdStf/tokens.h"
#include "stfLib/render/cryptomatte.h"

#include "pxr/base/tf/stringUtils.h"
#include "pxr/base/vt/value.h"
#include "pxr/imaging/hd/tokens.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <sys/resource.h>
#include <unistd.h>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

size_t _PeakMemory() {
    rusage usage = {};
    getrusage(RUSAGE_SELF, &usage);
#ifdef __APPLE__
    return static_cast<size_t>(usage.ru_maxrss);
#else
    return static_cast<size_t>(usage.ru_maxrss) * 1024; // kilobytes
#endif
}

/// Bytes that the process has in memory now; its peak where the system does not say.
size_t _TotalMemory() {
    std::ifstream file("/proc/self/statm");
    size_t pages = 0, resident = 0;
    return file >> pages >> resident ? resident * static_cast<size_t>(sysconf(_SC_PAGESIZE)) : _PeakMemory();
}

std::string _Dump(nlohmann::json const& json) {
    return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string _PlanJson(std::vector<stf::PlanEntry> const& plan) {
    nlohmann::json list = nlohmann::json::array();
    for (stf::PlanEntry const& entry : plan) {
        list.push_back({{"object", entry.object},
                        {"stage", entry.stage},
                        {"runs", entry.runs},
                        {"why", entry.why},
                        {"seconds", entry.seconds}});
    }
    return _Dump(list);
}

std::string _ForecastJson(std::vector<stf::ForecastEntry> const& forecast) {
    nlohmann::json list = nlohmann::json::array();
    for (stf::ForecastEntry const& f : forecast) {
        list.push_back(
            {{"object", f.entry.object},
             {"stage", f.entry.stage},
             {"runs", f.entry.runs},
             {"why", f.entry.why},
             {"estimatedSeconds", f.estimatedSeconds ? nlohmann::json(*f.estimatedSeconds) : nlohmann::json()},
             {"seconds", nlohmann::json()}});
    }
    return _Dump(list);
}

std::string _MessagesJson(HdStfMessages const& messages) {
    nlohmann::json list = nlohmann::json::array();
    for (HdStfMessages::Message const& message : messages.Get()) {
        list.push_back({{"severity", HdStfSeverityName(message.severity)}, {"text", message.text}});
    }
    return _Dump(list);
}

/// prepare, transport, ... as the job names them; render, done.
std::string _Stage(HdStfRenderJob::Progress const& progress) {
    if (progress.finished) {
        return "done";
    }
    return progress.samplesDone > 0 ? "render" : progress.stage;
}

/// Names and ids as a cryptomatte's manifest has them.
std::string _ManifestJson(std::vector<std::string> const& names) {
    nlohmann::json manifest = nlohmann::json::object();
    for (std::string const& name : names) {
        manifest[name] = TfStringPrintf("%08x", stf::cryptomatteId(name));
    }
    return _Dump(manifest);
}

std::string _Annotation(HdStfRenderJob::Progress const& progress) {
    if (progress.finished) {
        return "done";
    }
    if (progress.samplesDone > 0 || progress.stage == "render") {
        return TfStringPrintf("sample %d of %d", progress.samplesDone, progress.samplesWanted);
    }
    return TfStringPrintf("%s %.0f %%", progress.stage.c_str(), 100 * progress.stageFraction);
}

} // namespace

VtDictionary HdStfMakeRenderStats(HdStfRenderJob::Progress const& progress, HdStfMessages const& messages) {
    const double fraction = progress.finished ? 1.0
                            : progress.samplesWanted > 0
                                ? std::min(1.0, static_cast<double>(progress.samplesDone) / progress.samplesWanted)
                                : 0.0;
    VtDictionary stats;
    const auto set = [&stats](TfToken const& key, auto const& value) { stats[key.GetString()] = VtValue(value); };
    // Blender reads percentDone as a double without asking.
    set(HdStfStatsTokens->percentDone, 100.0 * fraction);
    set(HdStfStatsTokens->fractionDone, fraction);
    set(HdStfStatsTokens->totalClockTime, progress.clockSeconds);
    set(HdPerfTokens->numCompletedSamples, progress.samplesDone);
    set(HdStfStatsTokens->rendererName, std::string("Stf"));
    set(HdStfStatsTokens->renderProgressAnnotation, _Annotation(progress));
    set(HdStfStatsTokens->rendererStage, _Stage(progress));
    set(HdStfStatsTokens->stageFraction,
        progress.finished || progress.samplesDone > 0 ? fraction : std::clamp(progress.stageFraction, 0.0, 1.0));
    set(HdStfStatsTokens->totalMemory, _TotalMemory());
    set(HdStfStatsTokens->peakMemory, _PeakMemory());

    set(HdStfStatsTokens->plan,
        progress.forecast.empty() ? _PlanJson(progress.plan) : _ForecastJson(progress.forecast));
    set(HdStfStatsTokens->messages, _MessagesJson(messages));
    if (!progress.objectNames.empty()) {
        set(HdStfStatsTokens->cryptoObject, _ManifestJson(progress.objectNames));
    }
    set(HdStfStatsTokens->loadSeconds, progress.stats.loadSeconds);
    set(HdStfStatsTokens->precomputeSeconds, progress.stats.precomputeSeconds);
    set(HdStfStatsTokens->synthesisSeconds, progress.stats.synthesisSeconds);
    set(HdStfStatsTokens->shellSeconds, progress.stats.shellSeconds);
    set(HdStfStatsTokens->coreSeconds, progress.stats.coreSeconds);
    set(HdStfStatsTokens->indirectSeconds, progress.stats.indirectSeconds);
    set(HdStfStatsTokens->firstPixelSeconds, progress.stats.firstPixelSeconds);
    set(HdStfStatsTokens->renderSeconds, progress.stats.renderSeconds);
    set(HdStfStatsTokens->syntheses, progress.stats.syntheses);
    set(HdStfStatsTokens->grids, progress.stats.grids);
    set(HdStfStatsTokens->poses, progress.stats.poses);
    set(HdStfStatsTokens->tableBytes, progress.stats.tableBytes);
    set(HdStfStatsTokens->shellBytes, progress.stats.shellBytes);
    set(HdStfStatsTokens->rays, static_cast<uint64_t>(progress.stats.rays));
    set(HdStfStatsTokens->estimatedError, progress.stats.estimatedError);
    return stats;
}

PXR_NAMESPACE_CLOSE_SCOPE
