// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"
#include "stfLib/optics/delta_eddington.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace stf {

/// What `stf map` is asked for.
struct MapOptions {
    std::string volume, out;                             ///< no `out`: only the numbers
    Vec3f towardsLight{0, 0, 1}, towardsViewer{0, 0, 1}; ///< unit, tile frame, z outward
    enum class Method { Walk, Stf } method = Method::Walk;
    TransportForm form = TransportForm::DE1; ///< of Method::Stf
    double quality = 0.01;                   ///< of its table
    std::uint64_t photons = 1'000'000;       ///< of Method::Walk
    int samples = 256;                       ///< of Method::Stf: lines of sight of a column
    std::uint64_t seed = 0;
    int threads = 0;          ///< 0: all cores
    bool reflectance = false; ///< of Method::Walk: only the reflectance, no map
};

/// The command line of `stf map` before it is judged.
class MapArguments {
public:
    void addTo(CLI::App& command);
    /// Throws CLI::ValidationError with one sentence that says what is wrong.
    MapOptions parse() const;
    bool json() const { return json_; }

private:
    MapOptions given_;
    std::vector<double> light_{0, 0, 1}, view_{0, 0, 1};
    double photons_ = 1e6;
    std::string method_ = "walk", form_ = "dE1";
    bool json_ = false;
};

} // namespace stf
