// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/renderer.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace stf {

/// A line of the plan of work that has not begun.
struct ForecastEntry {
    PlanEntry entry;                        ///< its seconds are 0
    std::optional<double> estimatedSeconds; ///< none where nothing says how long it takes
};

/// Whether a table is kept from an earlier run, so that it will be read.
using TableKept = std::function<bool(const BaseVolume& volume, const TransportOptions& options)>;

/// What Renderer::prepare would do for a scene from nothing, and why, without doing it: base volumes are read and
/// meshes refined coarsely, to judge them. Times of tables are extrapolated from a pilot of few photons. What is wrong
/// with an object is told in its entry. Throws Cancelled.
std::vector<ForecastEntry> foresee(const Scene& scene, const RenderSettings& settings, const TableKept& kept,
                                   Progress& progress);

} // namespace stf
