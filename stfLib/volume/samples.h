// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to stfLib's sources: the samples of makeSample(), one file each.
#include "stfLib/volume/make_samples.h"

namespace stf {

/// White marble with rust-coloured veins: reduced albedo of marble (Jensen et al. 2001), veins of domain-warped ridged
/// noise. 38 x 38 x 8 mm.
BaseVolume makeMarble(const SampleOptions& options);
/// Warm wax whose top carries a raised pattern with the symmetry of the square, so that tiles fit along any edge.
/// 10 x 10 x 5 mm.
BaseVolume makeWax(const SampleOptions& options);
/// Green jade: felted clouds of pale and deep green, rusty stains along a healed crack, dark grains. 24 x 24 x 6 mm.
BaseVolume makeJade(const SampleOptions& options);
/// Skin: epidermis, dermis with vessels, subcutaneous fat, under the grooves and pores of its surface. 9.6 x 9.6 x 3
/// mm.
BaseVolume makeSkin(const SampleOptions& options);
/// A coral's skeleton, full of round holes that open at its surface. 16 x 16 x 6 mm.
BaseVolume makeCoral(const SampleOptions& options);
/// Glacier ice: clear blue ice with white bands of bubbles, larger bubbles and cracks. 240 x 240 x 72 mm.
BaseVolume makeIce(const SampleOptions& options);
/// Homogeneous, by the options.
BaseVolume makeUniform(const SampleOptions& options);
/// Voxels of independent log-uniform extinction, by the options.
BaseVolume makeRandom(const SampleOptions& options);

} // namespace stf
