// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/map_options.h"

#include "stfLib/base/error.h"

#include <cmath>

namespace stf {

namespace {

// Photons fall into this many batches, whose scatter is the error (map_walk.cpp): below it there is none.
constexpr double kMinPhotons = 64, kMaxPhotons = 1e13;
constexpr int kMaxSamples = 1 << 24;

[[noreturn]] void refuse(const std::string& text) {
    throw CLI::ValidationError(text);
}

Vec3f upward(const std::vector<double>& v, const char* option) {
    const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!std::isfinite(length) || !(v[2] >= 1e-6 * length) || !(length > 0)) {
        refuse(std::string(option) + " is not a direction above the tile (x,y,z with z > 0)");
    }
    return {float(v[0] / length), float(v[1] / length), float(v[2] / length)};
}

} // namespace

void MapArguments::addTo(CLI::App& c) {
    c.add_option("volume", given_.volume, "Base volume (.vdb) without relief, of index 1")->required();
    c.add_option("--light", light_, "Towards the distant light: x,y,z, z outward")->delimiter(',')->expected(3);
    c.add_option("--view", view_, "Towards the viewer: x,y,z")->delimiter(',')->expected(3);
    c.add_option("--method", method_,
                 "walk: photons through the true medium; stf: a transport table, written, read and marched as the "
                 "renderer does it");
    c.add_option("--form", form_, "Of --method stf: dE1 or classic");
    c.add_option("--quality", given_.quality, "Of --method stf: wanted relative error of the table");
    c.add_option("--photons", photons_, "Of --method walk");
    c.add_option("--samples", given_.samples, "Of --method stf: lines of sight of a column");
    c.add_option("--seed", given_.seed, "Other random numbers");
    c.add_option("--threads", given_.threads, "0: all cores; the result does not depend on it");
    c.add_flag("--reflectance", given_.reflectance, "Of --method walk: only the reflectance, which is quicker");
    c.add_option("--out", given_.out, "Float EXR with the layers radiance and stderr, a pixel for each column");
    c.add_flag("--json", json_, "Print a line of JSON");
}

MapOptions MapArguments::parse() const {
    MapOptions o = given_;
    o.towardsLight = upward(light_, "--light");
    o.towardsViewer = upward(view_, "--view");
    if (method_ != "walk" && method_ != "stf") {
        refuse("--method '" + method_ + "' is not walk or stf");
    }
    o.method = method_ == "stf" ? MapOptions::Method::Stf : MapOptions::Method::Walk;
    try {
        o.form = parseTransportForm(form_);
    } catch (const Error& e) {
        refuse(std::string("--form: ") + e.what());
    }
    if (!(o.quality > 0 && o.quality <= 1)) {
        refuse("--quality is not a relative error above 0");
    }
    if (!(photons_ >= kMinPhotons && photons_ <= kMaxPhotons) || photons_ != std::floor(photons_)) {
        refuse("--photons is not a whole number of 64 to 1e13");
    }
    o.photons = std::uint64_t(photons_);
    if (o.samples < 2 || o.samples > kMaxSamples) {
        refuse("--samples is not within 2 to 16777216");
    }
    if (o.threads < 0 || o.threads > 4096) {
        refuse("--threads is not within 0 to 4096");
    }
    if (o.reflectance && (o.method == MapOptions::Method::Stf || !o.out.empty())) {
        refuse("--reflectance goes with --method walk and makes no image");
    }
    return o;
}

} // namespace stf
