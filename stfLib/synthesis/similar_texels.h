// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/synthesis/exemplar.h"

namespace stf {

/// The `k` texels most alike each texel (Tong et al. 2002, "k-coherence"; the jump maps of Zelinka & Garland 2004),
/// nearest first, apart from each other and from the texel itself by a twentieth of the tile, 4 to 8 texels, so
/// that they are k other places and not one. Texels that have fewer are padded with themselves. Result: k per texel.
std::vector<int> similarTexels(const AppearanceImage& image, int k);

/// Root mean square over all texels of the distance between the neighbourhood of a texel (itself and the 8 around) and
/// the nearest of those of its similar texels.
double ownNeighbourhoodError(const AppearanceImage& image, const std::vector<int>& similar, int k);

} // namespace stf
