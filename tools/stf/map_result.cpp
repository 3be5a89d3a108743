// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/map_result.h"

#include "tools/stfrecord/image.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

nlohmann::json triple(const Vec3d& v) {
    return {v.x, v.y, v.z};
}
nlohmann::json triple(const Vec3f& v) {
    return {v.x, v.y, v.z};
}

bool byTable(const MapOptions& o) {
    return o.method == MapOptions::Method::Stf;
}

// Root mean square over columns of their errors.
Vec3d columnError(const MapResult& r) {
    Vec3d squares{0, 0, 0};
    for (const Measured& m : r.columns) {
        squares += m.error * m.error;
    }
    const double n = std::max(1.0, double(r.columns.size()));
    return {std::sqrt(squares.x / n), std::sqrt(squares.y / n), std::sqrt(squares.z / n)};
}

} // namespace

std::string mapJson(const MapOptions& o, const MapResult& r) {
    nlohmann::json j{{"volume", o.volume},
                     {"method", byTable(o) ? "stf" : "walk"},
                     {"light", triple(o.towardsLight)},
                     {"seed", o.seed},
                     {"photons", r.photons},
                     {"collisions", r.collisions},
                     {"lost", r.lost},
                     {"seconds", r.seconds}};
    if (!r.columns.empty()) {
        j["size"] = {r.width, r.height};
        j["view"] = triple(o.towardsViewer);
        j["mean"] = triple(r.mean.value);
        j["meanStderr"] = triple(r.mean.error);
        j["columnStderr"] = triple(columnError(r));
    }
    if (byTable(o)) {
        j["form"] = name(o.form);
        j["samples"] = o.samples;
        j["tableError"] = r.tableError;
        j["precomputeSeconds"] = r.precomputeSeconds;
        j["marchSeconds"] = r.marchSeconds;
    } else {
        j["R"] = {{"total", triple(r.reflectance.value)}, {"stderr", triple(r.reflectance.error)}};
    }
    return j.dump();
}

std::string mapText(const MapOptions& o, const MapResult& r) {
    std::string out;
    const auto line = [&](const char* format, auto... values) {
        char text[256];
        std::snprintf(text, sizeof text, format, values...);
        out += text;
    };
    const auto row = [&](const char* name, const Measured& m) {
        line("%-14s %10.6f %10.6f %10.6f  +- %.1e\n", name, m.value.x, m.value.y, m.value.z, maxComponent(m.error));
    };
    if (!r.columns.empty()) {
        row("mean radiance", r.mean);
        line("%-14s %.1e\n", "column stderr", maxComponent(columnError(r)));
    }
    if (byTable(o)) {
        line("table error %.2f %%, %.2f s of walks, %.2f s of marching\n", 100 * r.tableError, r.precomputeSeconds,
             r.marchSeconds);
    } else {
        row("reflectance", r.reflectance);
    }
    line("%llu photons, %llu collisions, %.2f s\n", static_cast<unsigned long long>(r.photons),
         static_cast<unsigned long long>(r.collisions), r.seconds);
    return out;
}

void writeMap(const MapResult& r, const std::string& path) {
    stfrecord::Image image;
    image.width = r.width;
    image.height = r.height;
    stfrecord::Layer radiance{"radiance", 3, {}, {}}, error{"stderr", 3, {}, {}};
    for (const Measured& m : r.columns) {
        for (int c = 0; c < 3; ++c) {
            radiance.floats.push_back(float(m.value[c]));
            error.floats.push_back(float(m.error[c]));
        }
    }
    image.layers = {radiance, error};
    stfrecord::writeExr(image, path);
}

} // namespace stf
