// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shaped_emission.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {
constexpr float kPi = 3.14159265358979f;
}

ShapedEmission::ShapedEmission(const std::string& id, const LightShaping& shaping, const MessageSink& messages)
    : shaping_(shaping) {
    shaping_.focus = std::isfinite(shaping.focus) ? std::max(shaping.focus, 0.0f) : 0.0f;
    shaping_.coneAngle = std::isfinite(shaping.coneAngle) ? std::clamp(shaping.coneAngle, 0.0f, 180.0f) : 180.0f;
    cutoff_ = shaping_.coneAngle * kPi / 180;
    smoothStart_ = cutoff_ * (1 - std::clamp(shaping.coneSoftness, 0.0f, 1.0f));
    if (!shaping.iesFile.empty()) {
        try {
            profile_ = IesProfile::read(shaping.iesFile);
        } catch (const Error& e) {
            report(messages, Severity::Error, id + ": IES profile " + e.what() + "; the light shines without it");
        }
    }
    none_ = shaping_.focus == 0 && shaping_.coneAngle >= 180 && !profile_;
}

Rgb ShapedEmission::factor(const Vec3f& d) const {
    if (none_) {
        return Rgb(1.0f);
    }
    const float cosine = std::clamp(-d.z, -1.0f, 1.0f), angle = std::acos(cosine);
    Rgb out(1.0f);
    if (shaping_.focus > 0) {
        const float focused = std::pow(std::abs(cosine), shaping_.focus);
        out = shaping_.focusTint * (1 - focused) + Rgb(focused);
    }
    if (shaping_.coneAngle < 180) {
        if (angle > cutoff_) {
            return Rgb(0.0f);
        }
        if (angle > smoothStart_) {
            const float t = (angle - smoothStart_) / (cutoff_ - smoothStart_);
            out *= 1 - t * t * (3 - 2 * t);
        }
    }
    if (profile_) {
        const float scale = shaping_.iesAngleScale;
        const float vertical = scale > 0 ? angle / scale : scale < 0 ? (angle - kPi) / -scale + kPi : angle;
        const float candela = profile_->intensity(vertical, std::atan2(d.y, d.x));
        // Normalised, the profile has a mean of 1 over all directions: it moves light, it adds none.
        const double power = profile_->power();
        out *= !shaping_.iesNormalize ? candela : power > 0 ? float(double(candela) * 4 * double(kPi) / power) : 0.0f;
    }
    return out;
}

} // namespace stf
