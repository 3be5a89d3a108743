// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/options.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <map>
#include <sstream>

namespace stfrecord {
namespace {

constexpr std::size_t maxFrames = 1000000;

bool parseNumber(const std::string& text, double& number) {
    char* end = nullptr;
    number = std::strtod(text.c_str(), &end);
    return !text.empty() && end == text.c_str() + text.size() && std::isfinite(number);
}

bool appendRange(const std::string& text, std::vector<double>& frames) {
    const std::size_t colon = text.find(':');
    double first = 0, last = 0, step = 0;
    if (colon == std::string::npos) {
        if (!parseNumber(text, first)) {
            return false;
        }
        frames.push_back(first);
        return true;
    }
    const std::size_t cross = text.find('x', colon);
    const std::string lastText =
        text.substr(colon + 1, cross == std::string::npos ? std::string::npos : cross - colon - 1);
    if (!parseNumber(text.substr(0, colon), first) || !parseNumber(lastText, last)) {
        return false;
    }
    step = last < first ? -1 : 1;
    if (cross != std::string::npos && !parseNumber(text.substr(cross + 1), step)) {
        return false;
    }
    const double count = step == 0 ? -1 : std::floor((last - first) / step + 1e-9) + 1;
    if (!(count >= 1) || count > double(maxFrames)) {
        return false;
    }
    for (int i = 0; i < int(count); ++i) {
        frames.push_back(first + i * step);
    }
    return true;
}

std::optional<std::array<float, 4>> parseCrop(const std::string& text) {
    std::array<float, 4> crop{};
    std::istringstream parts(text);
    std::string part;
    std::size_t count = 0;
    for (double number = 0; std::getline(parts, part, ','); ++count) {
        if (count == 4 || !parseNumber(part, number)) {
            return std::nullopt;
        }
        crop[count] = float(number);
    }
    const bool ordered = count == 4 && crop[0] < crop[2] && crop[1] < crop[3];
    return ordered ? std::make_optional(crop) : std::nullopt;
}

std::string beforeExtension(const std::string& pattern, const std::string& part) {
    const std::size_t slash = pattern.find_last_of('/');
    std::size_t dot = pattern.find_last_of('.');
    if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) {
        dot = pattern.size();
    }
    return pattern.substr(0, dot) + "." + part + pattern.substr(dot);
}

std::string frameNumber(double frame, int digits) {
    char text[64];
    double whole = 0;
    const double fraction = std::modf(std::fabs(frame), &whole);
    std::snprintf(text, sizeof(text), "%s%0*.0f", frame < 0 ? "-" : "", digits, whole);
    std::string result = text;
    if (fraction > 1e-9) {
        std::snprintf(text, sizeof(text), "%.3f", fraction);
        result += text + 1; // without the leading zero
    }
    return result;
}

bool splitSetting(const std::string& text, std::pair<std::string, std::string>& setting) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
        return false;
    }
    setting = {text.substr(0, equals), text.substr(equals + 1)};
    return true;
}

} // namespace

std::vector<double> parseFrames(const std::string& text, std::string& error) {
    std::vector<double> frames;
    std::istringstream parts(text);
    std::string part;
    while (std::getline(parts, part, ',')) {
        if (!appendRange(part, frames) || frames.size() > maxFrames) {
            error =
                "frames \"" + text + "\": \"" + part + "\" is not A, A:B or A:BxS with a step that leads from A to B";
            return {};
        }
    }
    if (frames.empty()) {
        error = "frames \"" + text + "\" name no frame";
    }
    return frames;
}

std::string framePath(const std::string& pattern, double frame, bool several) {
    const std::size_t last = pattern.find_last_of('#');
    if (last != std::string::npos) {
        std::size_t first = last;
        while (first > 0 && pattern[first - 1] == '#') {
            --first;
        }
        return pattern.substr(0, first) + frameNumber(frame, int(last - first + 1)) + pattern.substr(last + 1);
    }
    if (!several) {
        return pattern;
    }
    return beforeExtension(pattern, frameNumber(frame, 4));
}

std::string productPath(const std::string& pattern, const std::string& product, bool several) {
    return several && !pattern.empty() ? beforeExtension(pattern, product) : pattern;
}

std::optional<int> parseOptions(int argc, char** argv, Options& options) {
    CLI::App app(
        "Renders a USD scene through a Hydra delegate, without GPU and window, all AOVs into one EXR per frame.",
        "stfrecord");
    std::string frames, crop, aovs, purposes, complexity = "high";
    std::vector<std::string> settings;
    const std::map<std::string, int> levels = {{"low", 0}, {"medium", 1}, {"high", 2}, {"veryhigh", 3}};

    app.add_option("IN", options.scene, "USD file")->required();
    app.add_option("OUT", options.output,
                   "EXR file; #### stands for the frame number (default: as the scene's render products are named)");
    CLI::Option* product =
        app.add_option("--settings", options.renderSettings,
                       "path of a RenderSettings prim whose products are rendered (default: the stage's own)");
    CLI::Option* camera =
        app.add_option("--camera", options.camera, "path or name of a camera (default: the scene's first)");
    CLI::Option* imageWidth =
        app.add_option("--imageWidth", options.imageWidth, "width in pixels; the height follows from the camera (960)")
            ->check(CLI::Range(1, 32768));
    CLI::Option* cropped = app.add_option(
        "--crop", crop,
        "XMIN,YMIN,XMAX,YMAX: the part of the frame to render, shares from its lower left; beyond 0..1: overscan");
    app.add_option("--frames", frames, "A, A:B, A:BxS, and such separated by commas");
    app.add_option("--samples", options.samples, "samples per pixel")->check(CLI::Range(1, 1 << 24));
    app.add_option("--seed", options.seed, "seed of all random numbers");
    app.add_option("--threads", options.threads, "threads (0 = all cores)")->check(CLI::Range(0, 4096));
    CLI::Option* listed = app.add_option("--aov", aovs, "comma-separated AOVs (color)");
    app.add_option("--set", settings, "KEY=VALUE, a render setting; may be repeated")->allow_extra_args(false);
    app.add_option("--renderer", options.renderer, "display name or plugin id of the delegate (Stf)");
    app.add_option("--purposes", purposes, "comma-separated: default, render, proxy, guide (default,render)");
    app.add_option("--complexity", complexity, "low, medium, high, veryhigh: subdivision level 0 to 3 (high)")
        ->check(CLI::IsMember({"low", "medium", "high", "veryhigh"}));
    app.add_flag("--sceneIndices", options.sceneIndices,
                 "bring the stage in by UsdImaging's scene indices in place of its scene delegate (OpenUSD 23.11 on)");
    app.add_option("--png", options.png, "also write the colour as 8-bit sRGB");
    app.add_option("--stats", options.stats, "write statistics as JSON");
    app.add_flag("--denoise", options.denoise, "also the denoised colour, as AOV denoised");
    app.add_flag("--plan", options.plan, "print which stages ran, which were left out, and why");
    app.add_flag("--quiet", options.quiet, "print errors only");

    for (CLI::Option* option : {camera, imageWidth, cropped, listed}) {
        product->excludes(option); // they are the products' to say
    }

    const auto usage = [](const std::string& message) {
        std::cerr << "stfrecord: " << message << "\nstfrecord --help lists the options.\n";
        return int(BadUsage);
    };
    const auto splitList = [](const std::string& text) {
        std::vector<std::string> list;
        std::istringstream parts(text);
        for (std::string part; std::getline(parts, part, ',');) {
            if (!part.empty()) {
                list.push_back(part);
            }
        }
        return list;
    };
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        std::cout << app.help();
        return int(Rendered);
    } catch (const CLI::ParseError& error) {
        return usage(error.what());
    }

    options.describesImage = *camera || *imageWidth || *cropped || *listed || options.denoise;
    options.givesPurposes = !purposes.empty();
    if (!crop.empty()) {
        options.crop = parseCrop(crop);
        if (!options.crop) {
            return usage("--crop \"" + crop + "\" is not XMIN,YMIN,XMAX,YMAX with the first below the others");
        }
    }
    if (!frames.empty()) {
        std::string error;
        options.frames = parseFrames(frames, error);
        if (options.frames.empty()) {
            return usage(error);
        }
    }
    if (!aovs.empty()) {
        options.aovs = splitList(aovs);
        std::vector<std::string> unique;
        for (const std::string& aov : options.aovs) {
            if (std::find(unique.begin(), unique.end(), aov) == unique.end()) {
                unique.push_back(aov);
            }
        }
        options.aovs = unique;
    }
    if (options.aovs.empty()) {
        return usage("--aov names no AOV");
    }
    if (!purposes.empty()) {
        options.purposes = splitList(purposes);
        for (const std::string& purpose : options.purposes) {
            if (purpose != "default" && purpose != "render" && purpose != "proxy" && purpose != "guide") {
                return usage("purpose \"" + purpose + "\" is none of default, render, proxy, guide");
            }
        }
    }
    options.refineLevel = levels.at(complexity);
    for (const std::string& text : settings) {
        std::pair<std::string, std::string> setting;
        if (!splitSetting(text, setting)) {
            return usage("--set \"" + text + "\" is not KEY=VALUE");
        }
        options.settings.push_back(setting);
    }
    return std::nullopt;
}

} // namespace stfrecord
