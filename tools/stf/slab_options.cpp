// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/slab_options.h"

#include "stfLib/base/error.h"

#include <cmath>
#include <cstdlib>
#include <sstream>

namespace stf {

namespace {

constexpr std::size_t kMaxLayers = 10'000;
constexpr double kMaxTau = 1e6, kMaxPhotons = 1e13;

[[noreturn]] void refuse(const std::string& text) {
    throw CLI::ValidationError(text);
}

// One sentence about a value out of its range; NaN is out of every range.
void require(bool good, const char* option, double value, const char* rule) {
    if (!good) {
        std::ostringstream s;
        s << option << " " << value << " is not " << rule;
        refuse(s.str());
    }
}

// The value of a layer: one for all or one each.
double ofLayer(const std::vector<double>& values, std::size_t layer) {
    return values.size() == 1 ? values[0] : values[layer];
}

} // namespace

void SlabArguments::addTo(CLI::App& c) {
    c.add_option("--tau", tau_, "Optical depth of the slab, or of each layer from the top: t1,t2,...")->delimiter(',');
    c.add_option("--albedo", albedo_, "Single scattering albedo, one or one per layer")->delimiter(',');
    c.add_option("--g", g_, "Mean cosine of the phase function, one or one per layer")->delimiter(',');
    c.add_option("--ior", ior_, "Index of refraction of the slab (outside is 1 on both faces), 1 to 2.5");
    c.add_option("--incidence", incidence_, "normal, diffuse or the cosine of parallel light to the normal");
    c.add_option("--profile", profile_, "Report the fluence at these optical depths: t1,t2,...")->delimiter(',');
    c.add_option("--view", view_,
                 "Of --method stf: report the reflectance factor (pi radiance / flux) towards these cosines: m1,m2,...")
        ->delimiter(',');
    coreAlbedoGiven_ =
        c.add_option("--core-albedo", coreAlbedo_, "Put the slab on a half-infinite core of this albedo and its index");
    coreGGiven_ = c.add_option("--core-g", coreG_, "Mean cosine of the core");
    c.add_option("--method", method_,
                 "walk: photons through the true medium, the same walks as tables are made of; stf: a transport table, "
                 "written, read and evaluated by the renderer's own code");
    c.add_option("--form", form_, "Of --method stf: dE1 or classic");
    c.add_option("--quality", quality_, "Of --method stf: wanted relative error of the table");
    c.add_option("--photons", photons_, "Photons, or exit directions of --method stf");
    c.add_option("--seed", seed_, "Other random numbers");
    c.add_option("--threads", threads_, "0: all cores; the result does not depend on it");
    c.add_flag("--analog", analog_, "Photons die instead of losing weight: R + T + A is 1 exactly, with more noise");
    c.add_flag("--json", json_, "Print a line of JSON");
}

SlabOptions SlabArguments::parse() const {
    SlabOptions o;
    const std::size_t layers = std::max({tau_.size(), albedo_.size(), g_.size()});
    const auto count = [&](const char* option, const std::vector<double>& values) {
        if (values.size() != 1 && values.size() != layers) {
            refuse(std::string(option) + " has " + std::to_string(values.size()) + " values for " +
                   std::to_string(layers) + " layers: give one, or one per layer");
        }
    };
    count("--tau", tau_);
    count("--albedo", albedo_);
    count("--g", g_);
    if (layers > kMaxLayers) {
        refuse("more than " + std::to_string(kMaxLayers) + " layers");
    }
    for (std::size_t i = 0; i < layers; ++i) {
        const SlabLayer l{ofLayer(tau_, i), ofLayer(albedo_, i), ofLayer(g_, i)};
        require(l.tau >= 0 && l.tau <= kMaxTau, "--tau", l.tau, "an optical depth of 0 to 1e6");
        require(l.albedo >= 0 && l.albedo <= 1, "--albedo", l.albedo, "within 0 to 1");
        require(std::abs(float(l.g)) < 1, "--g", l.g, "between -1 and 1");
        o.layers.push_back(l);
    }
    require(ior_ >= 1 && ior_ <= 2.5, "--ior", ior_, "within 1 to 2.5");
    o.ior = ior_;

    if (incidence_ == "diffuse") {
        o.incidence = SlabOptions::Incidence::Diffuse;
    } else if (incidence_ != "normal") {
        char* end = nullptr;
        o.mu = std::strtod(incidence_.c_str(), &end);
        if (incidence_.empty() || *end != 0) {
            refuse("--incidence '" + incidence_ + "' is not normal, diffuse or a cosine");
        }
        require(o.mu >= 1e-6 && o.mu <= 1, "--incidence", o.mu, "a cosine of 1e-6 to 1");
    }

    o.hasCore = coreAlbedoGiven_->count() > 0;
    if (!o.hasCore && coreGGiven_->count() > 0) {
        refuse("--core-g needs --core-albedo");
    }
    if (o.hasCore) {
        require(coreAlbedo_ >= 0 && coreAlbedo_ <= 1, "--core-albedo", coreAlbedo_, "within 0 to 1");
        require(std::abs(float(coreG_)) < 1, "--core-g", coreG_, "between -1 and 1");
        o.coreAlbedo = coreAlbedo_;
        o.coreG = coreG_;
    }
    const double tau = o.tau();
    for (double t : profile_) {
        require(t >= 0 && t <= tau * (1 + 1e-12), "--profile", t, "an optical depth within the slab");
        o.profile.push_back(std::min(t, tau));
    }

    if (method_ != "walk" && method_ != "stf") {
        refuse("--method '" + method_ + "' is not walk or stf");
    }
    o.method = method_ == "stf" ? SlabOptions::Method::Stf : SlabOptions::Method::Walk;
    try {
        o.form = parseTransportForm(form_);
    } catch (const Error& e) {
        refuse(std::string("--form: ") + e.what());
    }
    for (double mu : view_) {
        require(mu >= 1e-6 && mu <= 1, "--view", mu, "a cosine of 1e-6 to 1");
        o.view.push_back(mu);
    }
    if (!o.view.empty() && o.method == SlabOptions::Method::Walk) {
        refuse("--view is of --method stf; walks tell the same by reciprocity: diffuse light seen at a cosine is the "
               "reflectance of --incidence at that cosine");
    }
    require(quality_ > 0 && quality_ <= 1, "--quality", quality_, "a relative error above 0");
    o.quality = quality_;
    require(photons_ >= 1 && photons_ <= kMaxPhotons && photons_ == std::floor(photons_), "--photons", photons_,
            "a whole number of 1 to 1e13");
    o.photons = std::uint64_t(photons_);
    if (threads_ < 0 || threads_ > 4096) {
        refuse("--threads is not within 0 to 4096");
    }
    o.threads = threads_;
    o.seed = seed_;
    o.analog = analog_;
    return o;
}

} // namespace stf
