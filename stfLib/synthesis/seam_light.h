// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/synthesis/heal_breaks.h"

namespace stf {

/// How much light that crosses seams changes reflectance: rms over the surface, relative to the sample's mean, of the
/// channel where it is most. 0 without seams.
///
/// The model: what leaves a place is the reflectance of columns, spread along the surface as diffusing light is:
/// R - l^2 laplace R = r, with the diffusion length l of the sample's mean coefficients and the columns' own
/// reflectances r. A renderer that looks light up in the sample shows R of the sample, which jumps at seams; on the
/// surface it would not. The difference solves the same equation without sources, but for what the jumps drive through
/// the links that seams cross. Light that spreads through depth by layers, single scattering and shading of a relief
/// are not in it: an estimate of the size of the error, not of its pattern. Lengths beyond half a tile count as that:
/// the sample knows nothing of longer ways.
double seamLight(const SurfaceGraph& graph, const SurfaceSteps& steps, const SurfaceCoords& coords,
                 const Exemplar& exemplar);

} // namespace stf
