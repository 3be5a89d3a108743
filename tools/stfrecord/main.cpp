// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/console.h"
#include "tools/stfrecord/diagnostics.h"
#include "tools/stfrecord/host.h"
#include "tools/stfrecord/leftOut.h"
#include "tools/stfrecord/options.h"
#include "tools/stfrecord/product.h"
#include "tools/stfrecord/renderSettings.h"
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
bool foldersExist(const std::vector<std::string>& paths, Console& console) {
    for (const std::string& path : paths) {
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

/// The start where there is one: shutters need a time that is a number.
UsdTimeCode firstTime(const UsdStageRefPtr& stage, const Options& options) {
    return !options.frames.empty()             ? UsdTimeCode(options.frames[0])
           : stage->HasAuthoredTimeCodeRange() ? UsdTimeCode(stage->GetStartTimeCode())
                                               : UsdTimeCode::EarliestTime();
}

/// The one image that the command line describes; nothing where it names no camera.
std::optional<Product> productOf(const Options& options, const UsdStageRefPtr& stage, Console& console) {
    Product product;
    product.camera = chooseCamera(stage, options, firstTime(stage, options), console);
    if (product.camera.IsEmpty()) {
        return std::nullopt;
    }
    product.width = options.imageWidth;
    product.dataWindow = options.crop;
    std::vector<std::string> aovs = options.aovs;
    if (options.denoise && std::find(aovs.begin(), aovs.end(), "denoised") == aovs.end()) {
        aovs.push_back("denoised");
    }
    for (const std::string& name : aovs) {
        for (const std::string& aov : aovsOf(name)) {
            product.vars.push_back({aov, aov, {}});
        }
    }
    return product;
}

/// Renders and writes product after product, frame after frame.
class Recorder {
public:
    Recorder(const Options& options, const UsdStageRefPtr& stage, Host& host, Console& console)
        : options_(options), stage_(stage), host_(host), console_(console) {}

    ExitCode run(const std::vector<Product>& products, const std::vector<std::string>& purposes) {
        for (const std::string& sentence : describeLeftOut(stage_, host_.delegate().GetSupportedRprimTypes(), purposes,
                                                           firstTime(stage_, options_))) {
            console_.message("error", sentence, true);
        }
        host_.populate(purposes, options_.refineLevel, options_.sceneIndices);
        ProductSettings settings(host_.delegate());
        severalProducts_ = products.size() > 1;
        for (const Product& product : products) {
            if (!product.name.empty() && !useProduct(product, settings)) {
                break;
            }
            product_ = product;
            height_ = 0;
            if (!recordFrames()) {
                break;
            }
        }
        finish();
        if (interrupted) {
            return Interrupted;
        }
        return written_ == 0 ? NothingRendered : console_.anyErrors() ? RenderedWithErrors : Rendered;
    }

private:
    /// Brings the settings and the camera's frame of a RenderProduct; what the command line says goes before it.
    bool useProduct(const Product& product, ProductSettings& settings) {
        for (const std::string& problem : settings.apply(product.settings)) {
            console_.message("error", product.name + ": " + problem, true);
        }
        std::string problem = applySettings(host_.delegate(), options_, UsdGeomGetStageMetersPerUnit(stage_));
        if (problem.empty()) {
            problem = setDataWindow(host_.delegate(), product.dataWindow);
        }
        if (!problem.empty()) {
            console_.message("error", product.name + ": " + problem, true);
            return false;
        }
        setAperture(stage_, product);
        host_.fillFrame(product.pixelAspectRatio);
        return true;
    }

    /// False where there is no use in going on.
    bool recordFrames() {
        const std::vector<double>& frames = options_.frames;
        if (frames.empty()) {
            return record(firstTime(stage_, options_),
                          stage_->HasAuthoredTimeCodeRange() ? stage_->GetStartTimeCode() : 0.0);
        }
        return std::all_of(frames.begin(), frames.end(),
                           [this](double frame) { return record(UsdTimeCode(frame), frame); });
    }

    /// False where there is no use in going on.
    bool record(UsdTimeCode time, double frame) {
        const int height =
            product_.height > 0 ? product_.height : imageHeight(stage_, product_.camera, time, product_.width);
        if (height != height_) {
            height_ = height;
            if (!bindOutputs()) {
                return false;
            }
        }
        std::string what = options_.frames.empty() ? "render" : TfStringPrintf("frame %g", frame);
        if (!product_.name.empty()) {
            what = product_.name + ": " + what;
        }
        const auto start = std::chrono::steady_clock::now();
        const bool complete = host_.render(product_.camera, time, [&] {
            const VtDictionary stats = host_.delegate().GetRenderStats();
            console_.progress(what, VtDictionaryGet<double>(stats, "fractionDone", VtDefault = 0.0),
                              VtDictionaryGet<std::string>(stats, "renderProgressAnnotation", VtDefault = ""));
            return interrupted == 0;
        });
        if (!complete) {
            console_.done(what + ": interrupted, nothing written");
            return false;
        }
        FrameStats stats = {options_.scene,
                            product_.name,
                            frame,
                            product_.width,
                            height,
                            secondsSince(start),
                            host_.delegate().GetRenderStats()};
        collectMessages(stats.delegate, console_);
        const bool ok = write(stats);
        stats_.push_back(std::move(stats));
        return ok;
    }

    bool bindOutputs() {
        HdStfWindow window = {0, 0, product_.width, height_};
        if (product_.dataWindow) {
            const auto& c = *product_.dataWindow;
            window = HdStfDataWindow(GfVec4f(c[0], c[1], c[2], c[3]), product_.width, height_);
        }
        if (window.IsEmpty()) {
            console_.message("error",
                             product_.name.empty() ? "--crop leaves no pixel of the frame"
                                                   : product_.name + ": dataWindowNDC leaves no pixel of the frame",
                             true);
            return false;
        }
        std::vector<std::string> aovs;
        for (const ProductVar& var : product_.vars) {
            if (std::find(aovs.begin(), aovs.end(), var.aov) == aovs.end()) {
                aovs.push_back(var.aov);
            }
        }
        const std::vector<std::string> unknown = host_.setOutputs(aovs, product_.width, height_, window);
        for (const std::string& aov : unknown) {
            console_.message("error", "the renderer has no AOV \"" + aov + "\"; it is left out", true);
        }
        return unknown.size() < aovs.size();
    }

    bool write(const FrameStats& stats) {
        Image image = host_.readImage();
        std::vector<std::string> problems;
        image.layers = productLayers(product_.vars, std::move(image.layers), problems);
        for (const std::string& problem : problems) {
            console_.message("error", problem, true);
        }
        image.metadata = {{"software", "stfrecord (hdStf)"},
                          {"hdStfVersion", HDSTF_VERSION},
                          {"openusdVersion", TfStringPrintf("%d.%02d", PXR_MINOR_VERSION, PXR_PATCH_VERSION)},
                          {"renderer", options_.renderer},
                          {"scene", options_.scene},
                          {"camera", product_.camera.GetString()},
                          {"frame", TfStringPrintf("%g", stats.frame)},
                          {"renderSettings", describeSettings(host_.delegate())},
                          {"renderSeconds", TfStringPrintf("%.3f", stats.seconds)}};
        if (!product_.name.empty()) {
            image.metadata.emplace_back("renderProduct", product_.name);
        }
        for (auto& entry : imageMetadata(stats, image)) {
            image.metadata.push_back(std::move(entry));
        }
        const bool several = options_.frames.size() > 1;
        const std::string pattern =
            options_.output.empty() ? product_.file : productPath(options_.output, product_.name, severalProducts_);
        const std::string path = framePath(pattern, stats.frame, several);
        try {
            writeExr(image, path);
            if (!options_.png.empty()) {
                writePng(image,
                         framePath(productPath(options_.png, product_.name, severalProducts_), stats.frame, several));
            }
        } catch (const std::exception& error) {
            console_.message("error", error.what(), true);
            return false;
        }
        ++written_;
        console_.done(TfStringPrintf("%s: %d x %d in %.2f s", path.c_str(), image.width, image.height, stats.seconds));
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
    Product product_;
    bool severalProducts_ = false;
    int height_ = 0;
    int written_ = 0;
    std::vector<FrameStats> stats_;
};

/// What is to be rendered: the products of render settings, or what the command line describes. Nothing, with a word,
/// where it does not say it rightly.
std::vector<Product> chooseProducts(const Options& options, const UsdStageRefPtr& stage,
                                    std::vector<std::string>& purposes, Console& console) {
    const auto fail = [&console](const std::string& text) {
        console.message("error", text, true);
        return std::vector<Product>();
    };
    std::string problem;
    const SdfPath settings =
        options.describesImage ? SdfPath() : findRenderSettings(stage, options.renderSettings, problem);
    if (!problem.empty()) {
        return fail(problem);
    }
    if (settings.IsEmpty()) {
        if (options.output.empty()) {
            return fail("the image has no name: give OUT, or render settings with products");
        }
        const std::optional<Product> product = productOf(options, stage, console);
        return product ? std::vector<Product>{*product} : std::vector<Product>();
    }
    RenderSettings read = readRenderSettings(stage, settings, firstTime(stage, options),
                                             [&](const std::string& text) { console.message("error", text, true); });
    if (!options.givesPurposes) {
        purposes = read.purposes;
    }
    if (read.products.empty()) {
        return fail(settings.GetString() + " has no product that can be rendered");
    }
    for (const Product& product : read.products) {
        if (options.output.empty() && product.file.empty()) {
            return fail(product.name + " has no productName; give OUT");
        }
    }
    return read.products;
}

int run(const Options& options, Console& console) {
    if (!foldersExist({options.output, options.png, options.stats}, console)) {
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
    std::vector<std::string> purposes = options.purposes;
    const std::vector<Product> products = chooseProducts(options, stage, purposes, console);
    if (products.empty()) {
        return BadUsage;
    }
    for (const Product& product : products) {
        if (options.output.empty() && !foldersExist({product.file}, console)) {
            return NothingRendered;
        }
    }
    std::signal(SIGINT, onInterrupt);
    return Recorder(options, stage, host, console).run(products, purposes);
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
