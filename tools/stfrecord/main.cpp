// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/console.h"
#include "tools/stfrecord/diagnostics.h"
#include "tools/stfrecord/host.h"
#include "tools/stfrecord/options.h"
#include "tools/stfrecord/settings.h"
#include "tools/stfrecord/stageCamera.h"
#include "tools/stfrecord/stats.h"

#include "pxr/base/tf/fileUtils.h"
#include "pxr/base/tf/pathUtils.h"
#include "pxr/base/tf/stringUtils.h"
#include "pxr/usd/usdGeom/metrics.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>

PXR_NAMESPACE_USING_DIRECTIVE

namespace stfrecord {
namespace {

volatile std::sig_atomic_t interrupted = 0;

/// The first Ctrl-C ends rendering in good order, a second one the process.
void onInterrupt(int signal) {
    interrupted = 1;
    std::signal(signal, SIG_DFL);
}

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

UsdStageRefPtr openStage(const std::string& path, Diagnostics& diagnostics, Console& console) {
    if (!TfIsFile(path, true)) {
        console.message("error", "cannot open " + path + ": there is no such file", true);
        return {};
    }
    if (!UsdStage::IsSupportedFile(path)) {
        console.message("error", "cannot open " + path + ": not a USD file", true);
        return {};
    }
    diagnostics.holdBack();
    const UsdStageRefPtr stage = UsdStage::Open(path);
    const std::string problem = diagnostics.release();
    if (!stage) {
        console.message("error", "cannot open " + path + ": " + (problem.empty() ? "not a readable scene" : problem),
                        true);
    } else if (!problem.empty()) {
        console.message("error", problem, true);
    }
    return stage;
}

/// Says which output cannot be written because its folder is not there; hours of rendering should not find that out.
bool foldersExist(const Options& options, Console& console) {
    for (const std::string& path : {options.output, options.png, options.stats}) {
        const std::string folder = TfGetPathName(path);
        if (!folder.empty() && !TfIsDir(folder, true)) {
            console.message("error", "cannot write " + path + ": there is no folder " + folder, true);
            return false;
        }
    }
    return true;
}

/// The camera to render from; empty where the one asked for does not exist (which is then said).
SdfPath chooseCamera(const UsdStageRefPtr& stage, const Options& options, UsdTimeCode time, Console& console) {
    const SdfPath camera = findCamera(stage, options.camera);
    if (!camera.IsEmpty()) {
        return camera;
    }
    if (options.camera.empty()) {
        console.message("error", options.scene + " has no camera; one that sees everything is used", true);
        return defineFramingCamera(stage, time, options.purposes);
    }
    std::vector<std::string> names;
    for (const SdfPath& path : findCameras(stage)) {
        names.push_back(path.GetString());
    }
    console.message("error",
                    "no camera \"" + options.camera + "\"; " +
                        (names.empty() ? "the scene has none" : "there are: " + TfStringJoin(names, ", ")),
                    true);
    return SdfPath();
}

/// Renders and writes frame after frame.
class Recorder {
public:
    Recorder(const Options& options, const UsdStageRefPtr& stage, Host& host, Console& console)
        : options_(options), stage_(stage), host_(host), console_(console) {}

    ExitCode run() {
        const std::vector<double>& frames = options_.frames;
        // The start where there is one: shutters need a time that is a number.
        const UsdTimeCode first = !frames.empty()                      ? UsdTimeCode(frames[0])
                                  : stage_->HasAuthoredTimeCodeRange() ? UsdTimeCode(stage_->GetStartTimeCode())
                                                                       : UsdTimeCode::EarliestTime();
        camera_ = chooseCamera(stage_, options_, first, console_);
        if (camera_.IsEmpty()) {
            return BadUsage;
        }
        host_.populate(options_.purposes, options_.refineLevel, options_.sceneIndices);
        bool complete = true;
        if (frames.empty()) {
            complete = record(first, stage_->HasAuthoredTimeCodeRange() ? stage_->GetStartTimeCode() : 0.0);
        }
        for (std::size_t i = 0; i < frames.size() && complete; ++i) {
            complete = record(UsdTimeCode(frames[i]), frames[i]);
        }
        finish();
        if (interrupted) {
            return Interrupted;
        }
        return written_ == 0 ? NothingRendered : console_.anyErrors() ? RenderedWithErrors : Rendered;
    }

private:
    /// False where there is no use in going on.
    bool record(UsdTimeCode time, double frame) {
        const int height = imageHeight(stage_, camera_, time, options_.imageWidth);
        if (height != height_) {
            height_ = height;
            if (!bindOutputs()) {
                return false;
            }
        }
        const std::string what = options_.frames.empty() ? "render" : TfStringPrintf("frame %g", frame);
        const auto start = std::chrono::steady_clock::now();
        const bool complete = host_.render(camera_, time, [&] {
            const VtDictionary stats = host_.delegate().GetRenderStats();
            console_.progress(what, VtDictionaryGet<double>(stats, "fractionDone", VtDefault = 0.0),
                              VtDictionaryGet<std::string>(stats, "renderProgressAnnotation", VtDefault = ""));
            return interrupted == 0;
        });
        if (!complete) {
            console_.done(what + ": interrupted, nothing written");
            return false;
        }
        FrameStats stats = {
            options_.scene, frame, options_.imageWidth, height, secondsSince(start), host_.delegate().GetRenderStats()};
        collectMessages(stats.delegate, console_);
        const bool ok = write(frame, stats.seconds);
        stats_.push_back(std::move(stats));
        return ok;
    }

    bool bindOutputs() {
        HdStfWindow window = {0, 0, options_.imageWidth, height_};
        if (options_.crop) {
            const auto& c = *options_.crop;
            window = HdStfDataWindow(GfVec4f(c[0], c[1], c[2], c[3]), options_.imageWidth, height_);
        }
        if (window.IsEmpty()) {
            console_.message("error", "--crop leaves no pixel of the frame", true);
            return false;
        }
        std::vector<std::string> aovs = options_.aovs;
        if (options_.denoise && std::find(aovs.begin(), aovs.end(), "denoised") == aovs.end()) {
            aovs.push_back("denoised");
        }
        const std::vector<std::string> unknown = host_.setOutputs(aovs, options_.imageWidth, height_, window);
        for (const std::string& aov : unknown) {
            console_.message("error", "the renderer has no AOV \"" + aov + "\"; it is left out", true);
        }
        return unknown.size() < aovs.size();
    }

    bool write(double frame, double seconds) {
        Image image = host_.readImage();
        image.metadata = {{"software", "stfrecord (hdStf)"},
                          {"renderer", options_.renderer},
                          {"scene", options_.scene},
                          {"camera", camera_.GetString()},
                          {"frame", TfStringPrintf("%g", frame)},
                          {"renderSettings", describeSettings(host_.delegate())},
                          {"renderSeconds", TfStringPrintf("%.3f", seconds)}};
        const bool several = options_.frames.size() > 1;
        const std::string path = framePath(options_.output, frame, several);
        try {
            writeExr(image, path);
            if (!options_.png.empty()) {
                writePng(image, framePath(options_.png, frame, several));
            }
        } catch (const std::exception& error) {
            console_.message("error", error.what(), true);
            return false;
        }
        ++written_;
        console_.done(TfStringPrintf("%s: %d x %d in %.2f s", path.c_str(), image.width, image.height, seconds));
        return true;
    }

    void finish() {
        if (options_.plan && !stats_.empty()) {
            std::fputs(planTable(stats_.back().delegate).c_str(), stdout);
        }
        if (!options_.stats.empty() && !stats_.empty()) {
            try {
                writeStats(stats_, console_.messages(), options_.stats);
            } catch (const std::exception& error) {
                console_.message("error", error.what(), true);
            }
        }
    }

    const Options& options_;
    UsdStageRefPtr stage_;
    Host& host_;
    Console& console_;
    SdfPath camera_;
    int height_ = 0;
    int written_ = 0;
    std::vector<FrameStats> stats_;
};

int run(const Options& options, Console& console) {
    if (!foldersExist(options, console)) {
        return NothingRendered;
    }
    registerPlugins();
    Diagnostics diagnostics(console);
    std::vector<std::string> available;
    const TfToken pluginId = findRenderer(options.renderer, available);
    if (pluginId.IsEmpty()) {
        console.message("error",
                        "no renderer \"" + options.renderer + "\"; " +
                            (available.empty() ? "none was found (PXR_PLUGINPATH_NAME names folders with plugins)"
                                               : "there are: " + TfStringJoin(available, ", ")),
                        true);
        return BadUsage;
    }
    const UsdStageRefPtr stage = openStage(options.scene, diagnostics, console);
    if (!stage) {
        return NothingRendered;
    }
    Host host(stage, pluginId);
    const std::string problem = applySettings(host.delegate(), options, UsdGeomGetStageMetersPerUnit(stage));
    if (!problem.empty()) {
        console.message("error", problem, true);
        return BadUsage;
    }
    std::signal(SIGINT, onInterrupt);
    return Recorder(options, stage, host, console).run();
}

} // namespace
} // namespace stfrecord

int main(int argc, char** argv) {
    stfrecord::Options options;
    if (const std::optional<int> code = stfrecord::parseOptions(argc, argv, options)) {
        return *code;
    }
    stfrecord::Console console(options.quiet);
    try {
        return stfrecord::run(options, console);
    } catch (const std::exception& error) {
        console.message("error", error.what(), true);
        return stfrecord::NothingRendered;
    }
}
