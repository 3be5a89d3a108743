// SPDX-License-Identifier: Apache-2.0
#include "hdStf/settingTable.h"

#include "stfLib/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>

namespace stf {

namespace {

SettingRow atLeast(SettingRow row, double least) {
    row.least = least;
    row.outside = std::holds_alternative<int>(row.own) ? SettingRow::Outside::BroughtIn : SettingRow::Outside::Refused;
    return row;
}

SettingRow above(SettingRow row, double least) {
    row.least = least;
    row.aboveLeast = true;
    return row;
}

SettingRow within(SettingRow row, double least, double most) {
    row.least = least;
    row.most = most;
    return row;
}

SettingRow oneOf(SettingRow row, std::vector<std::string> choices) {
    row.choices = std::move(choices);
    return row;
}

SettingRow someOf(SettingRow row, std::vector<std::string> choices) {
    row = oneOf(std::move(row), std::move(choices));
    row.several = true;
    return row;
}

std::vector<SettingRow> makeTable() {
    const RenderSettings own;
    return {
        atLeast({"stf:samples", "Samples per pixel", own.samples, "HDSTF_SAMPLES", "samples per pixel"}, 1),
        atLeast({"stf:errorTarget", "Wanted error of a pixel (0 = off)", own.errorTarget, "HDSTF_ERROR_TARGET",
                 "wanted error of a pixel's luminance, relative to it (or to a quarter of the image's mean, where that "
                 "is more): pixels below it get no more samples, and rendering ends when all are; `stf:samples` is the "
                 "most. 0: all get the same"},
                0),
        {"stf:seed", "Seed", int(own.seed), "HDSTF_SEED",
         "seed of all random numbers; the same seed gives the same image on any number of threads"},
        above({"stf:quality", "Target error of the tables", own.quality, "HDSTF_QUALITY",
               "target relative error of the tables of meshes that do not say (`primvars:stf:quality`)"},
              0),
        {"stf:tableSeed", "Seed of the tables", int(own.tableSeed), "HDSTF_TABLE_SEED",
         "seed of the walks that tables are made from; another seed gives other tables, of the same error"},
        oneOf({"stf:transport", "Form of transport (dE1, classic)", own.transport, "HDSTF_TRANSPORT",
               "form of the tables of meshes that do not say (`primvars:stf:transport`)"},
              {"dE1", "classic"}),
        oneOf({"stf:integrator", "Integrator (stf, reference)", own.integrator, "HDSTF_INTEGRATOR",
               "`stf`, or `reference`: unbiased path tracing of the same object without tables, slow "
               "([reference.md](reference.md))"},
              {"stf", "reference"}),
        atLeast({"stf:maxDepth", "Bounces off surfaces without a shell", own.maxDepth, "HDSTF_MAX_DEPTH",
                 "bounces off surfaces without a shell along a path; 0: direct light alone, also that of meshes that "
                 "shine, and none from shell to shell"},
                0),
        atLeast({"stf:indirectClamp", "Most light of a bounced path (0 = no limit)", own.indirectClamp,
                 "HDSTF_INDIRECT_CLAMP",
                 "most that a path brings after a bounce (its largest channel); takes away rare bright dots, and light "
                 "with them. 0: no limit"},
                0),
        {"stf:regularize", "Blur what paths of bounces find too rarely", own.regularize, "HDSTF_REGULARIZE",
         "narrow lobes that a path meets after wide ones, and wide distant lights that it meets behind shells that "
         "bend rays or mirrored by them, are blurred: found as they are they would be rare bright dots. Light is kept, "
         "its place is not (how much of either in a picture is not measured). Off: sharp, with those dots"},
        oneOf({"stf:pixelFilter", "Pixel filter (box, triangle, gaussian, blackmanHarris)", own.pixelFilter,
               "HDSTF_PIXEL_FILTER",
               "how samples are spread over the image's plane; `gaussian` is cut at three deviations"},
              {"box", "triangle", "gaussian", "blackmanHarris"}),
        within({"stf:pixelFilterWidth", "Width of the pixel filter (0 = its own)", own.pixelFilterWidth,
                "HDSTF_PIXEL_FILTER_WIDTH", "width of the filter's support in pixels; 0: its own (1, 2, 3, 3)"},
               0, 64),
        {"stf:depthOfField", "Depth of field", own.depthOfField, "HDSTF_DEPTH_OF_FIELD",
         "off: every camera is a pinhole"},
        {"stf:irradianceCache", "Keep light between surfaces at samples of shells", own.irradianceCache,
         "HDSTF_IRRADIANCE_CACHE",
         "light that a shell gets from other surfaces is kept for samples of its surface and read between them; off: "
         "every path looks for it by a ray of its own, without that smoothing and with far more noise (light from "
         "shells is read where it is kept, either way)"},
        {"stf:motionBlur", "Motion blur", own.motionBlur, "HDSTF_MOTION_BLUR",
         "off: everything is where it is at the frame's time"},
        {"stf:denoise", "Denoise the finished colour", false, "HDSTF_DENOISE",
         "the finished `color` is denoised (below)"},
        someOf({"stf:exact", "Made finer, to measure errors", std::string(), "HDSTF_EXACT",
                "approximations that finer ones take the place of, for measuring what they cost "
                "([report.md](report.md)), names separated by commas: `levels`, samples are read at their finest from "
                "any distance; `step`, a quarter of the march's; `coreTree`, sums over a core to a tenth of their "
                "error; `voxels`, light is kept for voxels of half the edge; `directions`, tables have more of them"},
               {"levels", "step", "coreTree", "voxels", "directions"}),
        {"dataWindowNDC", "Data window (x and y from, to; shares of the frame)", std::array<float, 4>{0, 0, 1, 1}, "",
         "the part of the frame that the buffers hold: x and y from, x and y to, shares of the frame from its lower "
         "left; may reach beyond 0 to 1"},
        atLeast({"stf:threads", "Threads (0 = all cores)", own.threads, "HDSTF_THREADS",
                 "threads of the renderer; 0: all cores"},
                0),
        above({"stageMetersPerUnit", "Metres per scene unit", 0.01, "HDSTF_STAGE_METERS_PER_UNIT",
               "size of a scene unit; `stfrecord` takes it from the stage"},
              0),
    };
}

std::string numberText(double number) {
    std::ostringstream text;
    text << number;
    return text.str();
}

} // namespace

const std::vector<SettingRow>& settingTable() {
    static const std::vector<SettingRow> table = makeTable();
    return table;
}

const std::vector<VariableRow>& variableTable() {
    static const std::vector<VariableRow> table = {
        {"HDSTF_CACHE_DIR", "`$XDG_CACHE_HOME/hdstf`, else `~/.cache/hdstf`",
         "the folder of what is kept: tables are in `tables` below it, maps in `maps`, and what `./run` builds once "
         "beside "
         "them. Several machines and users may share one, also one that they can only read"},
        {"HDSTF_CACHE_MAX_MB", "4096",
         "limit of the size of either folder, `tables` and `maps`, in megabytes (10^6 bytes): beyond it, files not "
         "used "
         "for longest go, except the newest and those in use. 0: nothing is read or kept"},
        {"HDSTF_OIDN_LIBRARY", "the loader's usual places", "path of the library of Open Image Denoise"},
        {"HDSTF_PLAN_ONLY", "0",
         "1: nothing is rendered; the statistic `stf:plan` tells what would be done (`stf plan` does this)"},
        {"HDSTF_PYTHON", "`python3`", "the Python that `stf report` runs with"},
        {"HDSTF_JOBS", "number of cores", "how many compilers `./run` starts at a time"},
        {"HDSTF_TEST_MESHES", "", "tests: a folder of meshes to try"},
        {"HDSTF_TEST_OUTPUT", "", "tests: a folder to leave pictures in"},
        {"HDSTF_TEST_SIZE", "", "tests: the size of those pictures"},
        {"HDSTF_TEST_SCENE_INDICES", "", "tests: 1: stages come in by scene indices"},
        {"HDSTF_IMAGING_SCENES", "", "tests: a folder of USD files to render (docs/hosts.md)"},
    };
    return table;
}

std::vector<std::string> variableNames() {
    std::vector<std::string> names;
    for (const SettingRow& row : settingTable()) {
        if (!row.variable.empty()) {
            names.push_back(row.variable);
        }
    }
    for (const VariableRow& row : variableTable()) {
        names.push_back(row.name);
    }
    return names;
}

std::string settingType(const SettingValue& value) {
    static const char* const names[] = {"bool", "int", "float", "double", "string", "float4"};
    return names[value.index()];
}

std::string settingText(const SettingValue& value) {
    if (const bool* flag = std::get_if<bool>(&value)) {
        return *flag ? "on" : "off";
    }
    if (const int* number = std::get_if<int>(&value)) {
        return std::to_string(*number);
    }
    if (const float* number = std::get_if<float>(&value)) {
        return numberText(*number);
    }
    if (const double* number = std::get_if<double>(&value)) {
        return numberText(*number);
    }
    if (const std::string* text = std::get_if<std::string>(&value)) {
        return *text;
    }
    std::string text;
    for (const float number : std::get<std::array<float, 4>>(value)) {
        text += (text.empty() ? "" : " ") + numberText(number);
    }
    return text;
}

std::optional<bool> flagOfText(const std::string& text) {
    if (text == "on" || text == "true") {
        return true;
    }
    return text == "off" || text == "false" ? std::optional<bool>(false) : std::nullopt;
}

bool settingChooses(const SettingRow& row, const std::string& text) {
    const auto isChoice = [&](const std::string& word) {
        return std::count(row.choices.begin(), row.choices.end(), word) > 0;
    };
    if (row.choices.empty() || (row.several && text.empty())) {
        return true;
    }
    if (!row.several) {
        return isChoice(text);
    }
    std::istringstream words(text + ",");
    for (std::string word; std::getline(words, word, ',');) {
        if (!isChoice(word)) {
            return false;
        }
    }
    return true;
}

bool settingHolds(const SettingRow& row, double number) {
    return std::isfinite(number) && (row.aboveLeast ? number > row.least : number >= row.least) && number <= row.most;
}

bool settingTakes(const SettingRow& row, const std::string& text) {
    if (std::holds_alternative<std::string>(row.own)) {
        return settingChooses(row, text);
    }
    char* end = nullptr;
    const std::optional<bool> flag = flagOfText(text);
    const double number = flag ? double(*flag) : std::strtod(text.c_str(), &end);
    if (!flag && (text.empty() || end != text.c_str() + text.size())) {
        return false;
    }
    if (!std::isfinite(number)) {
        return false;
    }
    if (std::holds_alternative<bool>(row.own)) {
        return number > -1 && number < 2; // what is left of a fraction is 0 or 1
    }
    const double most = std::holds_alternative<int>(row.own)     ? std::numeric_limits<int>::max()
                        : std::holds_alternative<float>(row.own) ? std::numeric_limits<float>::max()
                                                                 : std::numeric_limits<double>::max();
    return std::abs(number) <= most && (settingHolds(row, number) || row.outside == SettingRow::Outside::BroughtIn);
}

std::string settingRange(const SettingRow& row) {
    std::string text;
    if (row.several) {
        text = "any of ";
    }
    for (const std::string& choice : row.choices) {
        text += (text.empty() || text.back() == ' ' ? "`" : ", `") + choice + "`";
    }
    if (std::isfinite(row.most)) {
        return numberText(row.least) + " to " + numberText(row.most);
    }
    if (std::isfinite(row.least)) {
        return (row.aboveLeast ? "above " : "at least ") + numberText(row.least);
    }
    return text;
}

} // namespace stf
