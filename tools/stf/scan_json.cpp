// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/scan_json.h"

#include <cstdarg>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

using Json = nlohmann::json;

template<class T>
Json triple(const Vec3<T>& v) {
    return {v.x, v.y, v.z};
}
Json pair(const PeriodicityError& e) {
    return {e.x, e.y};
}

std::string line(const char* format, ...) {
    char text[400];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return text;
}

// A ramp between two materials passes one half in its middle: the thresholds in plain words.
std::vector<double> thresholdsOf(const AcquiredScan& s) {
    std::vector<double> values;
    for (std::size_t i = 0; i + 1 < s.transfer.size(); ++i) {
        if (s.transfer[i].fractions != s.transfer[i + 1].fractions) {
            values.push_back((s.transfer[i].value + s.transfer[i + 1].value) / 2);
        }
    }
    return values;
}

} // namespace

std::string scanJson(const ScanRecipe& recipe, const AcquiredScan& s, const std::string& path, double seconds) {
    Json classes = Json::array(), transfer = Json::array(), materials = Json::array();
    for (const ValueClass& c : s.classes) {
        classes.push_back({{"share", c.share}, {"mean", c.mean}, {"sigma", c.sigma}});
    }
    for (const TransferFunction::Point& p : s.transfer) {
        Json point = Json::array({p.value});
        for (const double f : p.fractions) {
            point.push_back(f);
        }
        transfer.push_back(point);
    }
    for (std::size_t m = 0; m < s.materials.size(); ++m) {
        materials.push_back(
            {{"name", s.materials[m]}, {"scanFraction", s.scanFractions[m]}, {"tileFraction", s.tileFractions[m]}});
    }
    const BaseVolume& v = s.volume;
    Json j{{"path", path},
           {"name", v.name},
           {"input",
            {{"path", recipe.input},
             {"format", s.header.format},
             {"type", nameOf(s.header.type)},
             {"size", triple(s.header.size)},
             {"spacingMm", triple(s.spacingMm)},
             {"crop", {triple(s.crop.lo), triple(s.crop.hi)}},
             {"range", {s.lowest, s.highest}},
             {"replaced", s.replaced}}},
           {"size", triple(v.size)},
           {"voxelMm", triple(v.voxelMm)},
           {"extentMm", triple(v.extentMm())},
           {"classes", classes},
           {"thresholds", thresholdsOf(s)},
           {"transfer", transfer},
           {"materials", materials},
           {"scanSigmaA", triple(s.scanSigmaA)},
           {"scanSigmaS", triple(s.scanSigmaS)},
           {"tileSigmaA", triple(s.tileSigmaA)},
           {"tileSigmaS", triple(s.tileSigmaS)},
           {"topLayer", s.firstLayer},
           {"overlap", {s.overlap.x, s.overlap.y}},
           {"periodicityError", {{"before", pair(s.before)}, {"after", pair(s.after)}}},
           {"surface", !v.surface.empty()},
           {"insideShare", s.insideShare},
           {"memoryMB", s.memoryBytes / 1e6},
           {"hash", v.contentHash()},
           {"seconds", seconds}};
    if (s.cut) {
        j["periodicityError"]["cut"] = pair(*s.cut);
    }
    j["iso"] = s.iso ? Json(*s.iso) : Json();
    return j.dump();
}

std::string scanText(const AcquiredScan& s, const std::string& path, double seconds) {
    const BaseVolume& v = s.volume;
    const Vec3d mm = v.extentMm();
    std::string text = line("%s: %s, %d x %d x %d voxels, %.3g x %.3g x %.3g mm, %.1f s\n", path.c_str(),
                            v.name.c_str(), v.size.x, v.size.y, v.size.z, mm.x, mm.y, mm.z, seconds);
    text += line("from       %s, %s voxels of %.4g x %.4g x %.4g mm, values %.5g to %.5g\n", s.header.format.c_str(),
                 sizeText(s.header.size).c_str(), s.spacingMm.x, s.spacingMm.y, s.spacingMm.z, s.lowest, s.highest);
    for (std::size_t m = 0; m < s.materials.size(); ++m) {
        text += line("%-10s %.3f %% of the scan, %.3f %% of the tile", s.materials[m].c_str(), 100 * s.scanFractions[m],
                     100 * s.tileFractions[m]);
        text += m < s.classes.size() ? line(", values %.5g +- %.3g\n", s.classes[m].mean, s.classes[m].sigma) : "\n";
    }
    text += "thresholds";
    for (const double t : thresholdsOf(s)) {
        text += line(" %.5g", t);
    }
    text += line("\nsides      differ %.2f, %.2f times as much as neighbours inside", s.after.x, s.after.y);
    if (s.overlap.x > 0) {
        text += line(" (%.2f, %.2f before)", s.before.x, s.before.y);
    }
    if (s.cut) {
        text += line("; the cuts %.2f, %.2f times", s.cut->x, s.cut->y);
    }
    if (s.iso) {
        text += line("\nsurface    at %.5g, %.2f %% of the tile inside", *s.iso, 100 * s.insideShare);
    }
    return text;
}

} // namespace stf
