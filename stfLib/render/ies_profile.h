// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"

#include <string>
#include <vector>

namespace stf {

/// Luminous intensity of a luminaire by direction, type C of ANSI/IES LM-63: vertical angle 0 is straight down (a
/// light's -z), horizontal angles turn from its x axis towards its y axis. Immutable.
class IesProfile {
public:
    /// Parses the text of a file (editions 1986 to 2019). Throws Error with the reason: not a profile, a tilt table
    /// (unsupported), photometry of type A or B, numbers that are missing, not finite, negative or not ascending.
    static IesProfile parse(const std::string& text);
    /// Throws Error naming the file.
    static IesProfile read(const std::string& path);

    /// Candela, linear between the file's angles; 0 beyond its vertical ones. Angles in radians.
    float intensity(float vertical, float horizontal) const;
    /// Integral of the intensity over all directions, lumen.
    double power() const { return power_; }

private:
    std::vector<float> vertical_, horizontal_; ///< degrees, ascending
    std::vector<float> candela_;               ///< [horizontal][vertical]
    double power_ = 0;
};

} // namespace stf
