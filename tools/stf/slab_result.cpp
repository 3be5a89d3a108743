// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/slab_result.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

const char* methodName(const SlabOptions& o) {
    return o.method == SlabOptions::Method::Walk ? "walk" : "stf";
}

std::string incidenceName(const SlabOptions& o) {
    if (o.incidence == SlabOptions::Incidence::Diffuse) {
        return "diffuse";
    }
    char text[32];
    std::snprintf(text, sizeof text, "mu %g", o.mu);
    return o.mu == 1 ? "normal" : text;
}

} // namespace

std::string slabJson(const SlabOptions& o, const SlabResult& r) {
    nlohmann::json layers = nlohmann::json::array(), profile = nlohmann::json::array();
    for (const SlabLayer& l : o.layers) {
        layers.push_back({{"tau", l.tau}, {"albedo", l.albedo}, {"g", l.g}});
    }
    for (const SlabProfileRow& p : r.profile) {
        const double worst = std::max({p.singleError, p.multipleError, p.sumError, p.backlightError});
        profile.push_back({{"depth", p.depth},
                           {"I_s", p.single},
                           {"I_m", p.multiple},
                           {"I_b", p.backlight},
                           {"stderr", worst},
                           {"stderr_I_s", p.singleError},
                           {"stderr_I_m", p.multipleError},
                           {"stderr_sum", p.sumError},
                           {"stderr_I_b", p.backlightError}});
    }
    nlohmann::json j{{"R", {{"total", r.r}, {"specular", r.specular}, {"stderr", r.rError}}},
                     {"T", {{"total", r.t}, {"unscattered", r.unscattered}, {"stderr", r.tError}}},
                     {"A", {{"total", r.a}, {"stderr", r.aError}}},
                     {"photons", r.photons},
                     {"seconds", r.seconds},
                     {"profile", profile},
                     {"method", methodName(o)},
                     {"layers", layers},
                     {"ior", o.ior},
                     {"incidence", incidenceName(o)},
                     {"collisions", r.collisions},
                     {"lost", r.lost},
                     {"notes", r.notes}};
    if (o.hasCore) {
        j["core"] = {{"albedo", o.coreAlbedo}, {"g", o.coreG}};
        if (r.coreDepth > 0) {
            j["coreDepth"] = r.coreDepth;
        }
    }
    if (o.method == SlabOptions::Method::Stf) {
        j["form"] = name(o.form);
        for (const SlabResult::View& v : r.view) {
            j["view"].push_back({{"mu", v.mu}, {"factor", v.factor}, {"stderr", v.error}});
        }
        j["tileLayers"] = r.layers;
        j["tableError"] = r.tableError;
    }
    return j.dump();
}

std::string slabText(const SlabOptions& o, const SlabResult& r) {
    std::string out;
    const auto line = [&](const char* format, auto... values) {
        char text[256];
        std::snprintf(text, sizeof text, format, values...);
        out += text;
    };
    line("%-14s %10s %10s\n", "", "share", "stderr");
    line("%-14s %10.6f %10.1e\n", "reflected", r.r, r.rError);
    line("%-14s %10.6f\n", "  specular", r.specular);
    line("%-14s %10.6f %10.1e\n", "transmitted", r.t, r.tError);
    line("%-14s %10.6f\n", "  unscattered", r.unscattered);
    line("%-14s %10.6f %10.1e\n", "absorbed", r.a, r.aError);
    line("%-14s %10.6f\n", "sum", r.r + r.t + r.a);
    if (!r.profile.empty()) {
        line("\n%10s %12s %12s %12s %10s\n", "depth", "I_s", "I_m", "I_b / 2 pi", "stderr");
        for (const SlabProfileRow& p : r.profile) {
            line("%10.6g %12.6f %12.6f %12.6f %10.1e\n", p.depth, p.single, p.multiple, p.backlight,
                 std::max({p.singleError, p.multipleError, p.sumError, p.backlightError}));
        }
    }
    if (!r.view.empty()) {
        line("\n%10s %12s %10s\n", "view", "factor", "stderr");
        for (const SlabResult::View& v : r.view) {
            line("%10.6g %12.6f %10.1e\n", v.mu, v.factor, v.error);
        }
    }
    line("\n%s, %s light, %llu photons, %llu collisions, %.2f s\n", methodName(o), incidenceName(o).c_str(),
         static_cast<unsigned long long>(r.photons), static_cast<unsigned long long>(r.collisions), r.seconds);
    for (const std::string& note : r.notes) {
        out += note + "\n";
    }
    return out;
}

} // namespace stf
