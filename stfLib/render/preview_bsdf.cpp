// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/preview_bsdf.h"

#include "stfLib/base/hemisphere.h"

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
constexpr float kLeastAlpha = 1e-3f;
constexpr float kCoatF0 = 0.04f; // of index 1.5

float schlickWeight(float cosine) {
    const float m = std::clamp(1 - cosine, 0.0f, 1.0f);
    return m * m * m * m * m;
}
Rgb schlick(const Rgb& f0, const Rgb& f90, float cosine) {
    return f0 + (f90 - f0) * schlickWeight(cosine);
}
float coatFresnel(float cosine) {
    return kCoatF0 + (1 - kCoatF0) * schlickWeight(cosine);
}

// Distribution of normals; by the sine rather than 1 - cosine^2, which would cancel for smooth surfaces.
float ggx(const Vec3f& h, float alpha) {
    const float d = h.z * h.z * alpha * alpha + h.x * h.x + h.y * h.y;
    return alpha * alpha / (kPi * d * d);
}
// Smith's Lambda.
float masking(const Vec3f& w, float alpha) {
    const float tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
    return 0.5f * (std::sqrt(1 + alpha * alpha * tan2) - 1);
}
// Without Fresnel.
float lobe(const Vec3f& out, const Vec3f& in, const Vec3f& h, float alpha) {
    return ggx(h, alpha) / ((1 + masking(out, alpha) + masking(in, alpha)) * 4 * out.z * in.z);
}
float lobeDensity(const Vec3f& out, const Vec3f& h, float alpha) {
    return ggx(h, alpha) / ((1 + masking(out, alpha)) * 4 * out.z);
}

Vec3f sampleLobe(const Vec3f& out, Vec2f u, float alpha) {
    const Vec3f stretched = normalize(Vec3f(out.x * alpha, out.y * alpha, out.z));
    const float z = (1 - u.y) * (1 + stretched.z) - stretched.z, r = std::sqrt(std::clamp(1 - z * z, 0.0f, 1.0f)),
                phi = 2 * kPi * u.x;
    const Vec3f cap = Vec3f(r * std::cos(phi), r * std::sin(phi), z) + stretched;
    const Vec3f h = normalize(Vec3f(cap.x * alpha, cap.y * alpha, std::max(cap.z, 0.0f)));
    return normalize(h * (2 * dot(out, h)) - out);
}

float alphaOf(float roughness) {
    return std::max(kLeastAlpha, roughness * roughness);
}

} // namespace

PreviewBsdf::PreviewBsdf(const PreviewPoint& point)
    : p_(point), alpha_(alphaOf(point.roughness)), coatAlpha_(alphaOf(point.clearcoatRoughness)) {}

Rgb PreviewBsdf::evaluate(const Vec3f& out, const Vec3f& in) const {
    if (!(out.z > 0) || !(in.z > 0)) {
        return Rgb(0.0f);
    }
    const Rgb shown = p_.diffuse * ((p_.presence ? 1.0f : p_.opacity) / kPi);
    if (p_.isLambert()) {
        return shown;
    }
    const Rgb one(1.0f);
    const Vec3f h = normalize(out + in);
    const float cosine = dot(out, h);
    Rgb sum = shown * (one - schlick(p_.f0, p_.f90, out.z)) * (one - schlick(p_.f0, p_.f90, in.z));
    sum += schlick(p_.f0, p_.f90, cosine) * lobe(out, in, h, alpha_);
    if (p_.clearcoat > 0) {
        sum *= (1 - p_.clearcoat * coatFresnel(out.z)) * (1 - p_.clearcoat * coatFresnel(in.z));
        sum += Rgb(p_.clearcoat * coatFresnel(cosine) * lobe(out, in, h, coatAlpha_));
    }
    return sum;
}

PreviewBsdf::Chances PreviewBsdf::chances(const Vec3f& out) const {
    const Rgb f = schlick(p_.f0, p_.f90, out.z);
    const float under = 1 - p_.clearcoat * coatFresnel(out.z);
    const float specular = under * average(f), coat = p_.clearcoat * coatFresnel(out.z);
    const float diffuse = under * average(p_.diffuse * (Rgb(1.0f) - f)) * (p_.presence ? 1.0f : p_.opacity);
    const float sum = diffuse + specular + coat;
    return sum > 0 ? Chances{diffuse / sum, specular / sum, coat / sum} : Chances{1, 0, 0};
}

float PreviewBsdf::density(const Vec3f& out, const Vec3f& in) const {
    if (!(out.z > 0) || !(in.z > 0)) {
        return 0;
    }
    const Chances c = chances(out);
    float sum = c.diffuse * in.z / kPi;
    if (c.specular > 0 || c.coat > 0) {
        const Vec3f h = normalize(out + in);
        sum += c.specular * lobeDensity(out, h, alpha_);
        sum += c.coat > 0 ? c.coat * lobeDensity(out, h, coatAlpha_) : 0.0f;
    }
    return sum;
}

PreviewBsdf::Sample PreviewBsdf::sample(const Vec3f& out, float pick, Vec2f u) const {
    Sample s;
    if (!(out.z > 0)) {
        return s;
    }
    const Chances c = chances(out);
    if (pick < c.diffuse) {
        s.in = cosineHemisphere(u);
        s.spread = 0.5f;
    } else {
        const float alpha = pick < c.diffuse + c.specular ? alpha_ : coatAlpha_;
        s.in = sampleLobe(out, u, alpha);
        s.spread = std::min(0.5f, alpha);
    }
    s.density = density(out, s.in);
    if (s.in.z > 0 && s.density > 0 && std::isfinite(s.density)) {
        s.weight = evaluate(out, s.in) * (s.in.z / s.density);
    }
    return s;
}

Rgb PreviewBsdf::through(const Vec3f& direction) const {
    const float clear = 1 - p_.opacity;
    if (p_.presence || !(clear > 0)) {
        return Rgb(clear);
    }
    // The same light is not both reflected and let through.
    const float cosine = std::abs(direction.z);
    return (Rgb(1.0f) - schlick(p_.f0, p_.f90, cosine)) * (clear * (1 - p_.clearcoat * coatFresnel(cosine)));
}

} // namespace stf
