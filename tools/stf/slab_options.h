// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/optics/delta_eddington.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace stf {

/// One layer of a slab: optical depth, single scattering albedo and mean cosine of the true medium.
struct SlabLayer {
    double tau = 0, albedo = 0, g = 0;
};

/// What `stf slab` is asked for.
struct SlabOptions {
    std::vector<SlabLayer> layers; ///< from the top, at least one
    double ior = 1;                ///< of the slab; outside is 1
    enum class Incidence { Parallel, Diffuse } incidence = Incidence::Parallel;
    double mu = 1; ///< cosine of parallel light to the normal
    bool hasCore = false;
    double coreAlbedo = 0, coreG = 0; ///< of the half-infinite medium below, of the slab's index
    std::vector<double> profile;      ///< optical depths of the true medium
    std::vector<double> view;         ///< of Method::Stf: cosines at which radiance is told
    enum class Method { Walk, Stf } method = Method::Walk;
    TransportForm form = TransportForm::DE1; ///< of Method::Stf
    double quality = 0.01;                   ///< of its table
    std::uint64_t photons = 100'000, seed = 0;
    bool analog = false;
    int threads = 0; ///< 0: all cores

    double tau() const {
        double sum = 0;
        for (const SlabLayer& l : layers) {
            sum += l.tau;
        }
        return sum;
    }
};

/// The command line of `stf slab` before it is judged.
class SlabArguments {
public:
    void addTo(CLI::App& command);
    /// Throws CLI::ValidationError with one sentence that says what is wrong.
    SlabOptions parse() const;
    bool json() const { return json_; }

private:
    std::vector<double> tau_{1}, albedo_{0.9}, g_{0}, profile_, view_;
    double ior_ = 1, coreAlbedo_ = -1, coreG_ = 0, photons_ = 100'000, quality_ = 0.01;
    std::string incidence_ = "normal", method_ = "walk", form_ = "dE1";
    std::uint64_t seed_ = 0;
    int threads_ = 0;
    bool analog_ = false, json_ = false;
    CLI::Option *coreAlbedoGiven_ = nullptr, *coreGGiven_ = nullptr;
};

} // namespace stf
