// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <string>

namespace stf {

/// The medium that multiply scattered light sees.
///
/// `DE1`, the delta-Eddington medium: the share `f` of a forward scattering event that hardly turns the light counts as
/// not scattered, the rest scatters with mean cosine g' (Joseph, Wiscombe & Weinman 1976, "The Delta-Eddington
/// Approximation for Radiative Flux Transfer", J. Atmos. Sci. 33). Single scattering keeps the true phase function and
/// coefficients in its source, attenuated in the scaled medium (the TMS correction of Nakajima & Tanaka 1988,
/// "Algorithms for Radiative Intensity Calculations in Moderately Thick Atmospheres Using a Truncation Approximation",
/// JQSRT 40).
///
/// `Classic`: the true medium, with isotropic multiple scattering at the end; the published Shell Texture Functions.
enum class TransportForm { DE1, Classic };

/// "dE1" or "classic".
const char* name(TransportForm form);
/// The form of a name; throws Error that tells the known ones.
TransportForm parseTransportForm(const std::string& text);

/// How a form changes Henyey-Greenstein scattering of mean cosine g.
struct DeltaScale {
    float f = 0;    ///< share of scattering that counts as unscattered
    float g = 0;    ///< mean cosine g' of what remains, |g'| <= |g|
    float keep = 1; ///< 1 - f, kept because it may be tiny
};

/// |g| < 1. For forward scattering f = g^2, the second Legendre moment of Henyey-Greenstein, and g' = g / (1 + g),
/// which keeps the first: f + (1 - f) g' = g. Backward scattering has no forward peak and stays as it is.
inline DeltaScale deltaScale(TransportForm form, float g) {
    if (form == TransportForm::Classic || !(g > 0)) {
        return {0, g, 1};
    }
    return {g * g, g / (1 + g), (1 - g) * (1 + g)};
}

namespace detail {
// 1 - a f, from 1 - a and 1 - f: keeps all digits where both a and f are near 1.
constexpr float oneMinusProduct(float a, const DeltaScale& s) {
    return (1 - a) + a * s.keep;
}
} // namespace detail

/// kappa' = kappa (1 - a f), 1/mm, per channel.
inline Rgb scaledExtinction(const Rgb& extinction, const Rgb& albedo, const DeltaScale& s) {
    return extinction * Rgb(detail::oneMinusProduct(albedo.x, s), detail::oneMinusProduct(albedo.y, s),
                            detail::oneMinusProduct(albedo.z, s));
}

/// a' = a (1 - f) / (1 - a f), 0 to 1, per channel; 1 exactly where a is 1.
inline Rgb scaledAlbedo(const Rgb& albedo, const DeltaScale& s) {
    const auto scaled = [&](float a) { return a * s.keep / detail::oneMinusProduct(a, s); };
    return {scaled(albedo.x), scaled(albedo.y), scaled(albedo.z)};
}

/// 1 - a' = (1 - a) / (1 - a f), per channel, with all the digits that 1 - scaledAlbedo() has lost where a' is near 1.
/// Absorption is that of the true medium: kappa' (1 - a') = kappa (1 - a).
inline Rgb scaledCoalbedo(const Rgb& albedo, const DeltaScale& s) {
    const auto scaled = [&](float a) { return (1 - a) / detail::oneMinusProduct(a, s); };
    return {scaled(albedo.x), scaled(albedo.y), scaled(albedo.z)};
}

} // namespace stf
