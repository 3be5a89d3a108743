// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/ies_profile.h"
#include "stfLib/render/light.h"

#include <optional>

namespace stf {

/// A light's shaping, ready to be evaluated: the factor of its radiance by direction (formulas of UsdLuxShapingAPI, the
/// documentation of OpenUSD's schema). Immutable.
class ShapedEmission {
public:
    ShapedEmission() = default;
    /// A profile that cannot be read is reported as `id`'s and left out.
    ShapedEmission(const std::string& id, const LightShaping& shaping, const MessageSink& messages);

    bool none() const { return none_; }
    /// `direction`: unit, in light space, away from the light.
    Rgb factor(const Vec3f& direction) const;

private:
    bool none_ = true;
    LightShaping shaping_;
    float cutoff_ = 0, smoothStart_ = 0; ///< radians
    std::optional<IesProfile> profile_;
};

} // namespace stf
