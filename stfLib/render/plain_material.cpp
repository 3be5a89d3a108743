// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/plain_material.h"

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
/// Surfaces that hardly reflect when faced do not at grazing angles either: below this reflectance F90 fades to zero.
constexpr float kFadingF0 = 0.02f;

TextureMap::Rgba lookUp(const TextureMap& map, const Texture* texture, Vec2f uv) {
    if (!texture) {
        return map.fallback;
    }
    const Vec2f scaled(uv.x * map.uvScale.x, uv.y * map.uvScale.y);
    const float angle = map.uvRotation * kPi / 180, c = std::cos(angle), s = std::sin(angle);
    const Vec2f at = Vec2f(c * scaled.x - s * scaled.y, s * scaled.x + c * scaled.y) + map.uvTranslation;
    TextureMap::Rgba value = texture->at(at, map);
    for (std::size_t i = 0; i < value.size(); ++i) {
        value[i] = value[i] * map.scale[i] + map.bias[i];
    }
    return value;
}

float within(float v, float lo, float hi) {
    return v > lo ? std::min(v, hi) : lo; // also not a number
}
Rgb within(const Rgb& c, float lo, float hi) {
    return {within(c.x, lo, hi), within(c.y, lo, hi), within(c.z, lo, hi)};
}

} // namespace

template<class T>
PlainMaterial::Held PlainMaterial::hold(const std::string& id, const SurfaceInput<T>& input, TextureStore& textures,
                                        const MessageSink& messages) {
    if (!input.texture) {
        return nullptr;
    }
    ++textured_;
    const TextureMap& map = *input.texture;
    if (map.file.empty()) {
        report(messages, Severity::Error, id + ": texture " + map.authoredPath + " is not found; its fallback is used");
        return nullptr;
    }
    try {
        return textures.get(map.file);
    } catch (const std::exception& e) {
        report(messages, Severity::Error, id + ": texture " + e.what() + "; its fallback is used");
        return nullptr;
    }
}

PlainMaterial::PlainMaterial(const std::string& id, const PreviewSurface& surface, TextureStore& textures,
                             const MessageSink& messages)
    : surface_(surface) {
    const auto held = [&](const auto& input) { return hold(id, input, textures, messages); };
    diffuse_ = held(surface_.diffuseColor);
    emissive_ = held(surface_.emissiveColor);
    if (surface_.useSpecularWorkflow) {
        specular_ = held(surface_.specularColor);
    } else {
        metallic_ = held(surface_.metallic);
        ior_ = held(surface_.ior);
    }
    roughness_ = held(surface_.roughness);
    clearcoat_ = held(surface_.clearcoat);
    clearcoatRoughness_ = held(surface_.clearcoatRoughness);
    opacity_ = held(surface_.opacity);
    normal_ = held(surface_.normal);
    opaque_ = !surface_.opacity.texture && surface_.opacity.value >= std::max(surface_.opacityThreshold, 1e-6f) &&
              (surface_.opacityThreshold > 0 || surface_.opacity.value >= 1);
}

Rgb PlainMaterial::color(const SurfaceInput<Rgb>& input, const Held& held, Vec2f uv) const {
    if (!input.texture) {
        return input.value;
    }
    const TextureMap::Rgba v = lookUp(*input.texture, held.get(), uv);
    const int c = input.texture->channel;
    return c < 0 ? Rgb(v[0], v[1], v[2]) : Rgb(v[std::size_t(c)]);
}

float PlainMaterial::number(const SurfaceInput<float>& input, const Held& held, Vec2f uv) const {
    return input.texture ? lookUp(*input.texture, held.get(), uv)[std::size_t(std::max(0, input.texture->channel))]
                         : input.value;
}

Rgb PlainMaterial::emission() const {
    return within(surface_.emissiveColor.value, 0, 1e30f);
}

PreviewPoint PlainMaterial::at(Vec2f uv, const Rgb& displayColor) const {
    PreviewPoint p;
    const PreviewSurface& s = surface_;
    const Rgb base = within(s.diffuseIsDisplayColor ? displayColor : color(s.diffuseColor, diffuse_, uv), 0, 1);
    p.emission = within(color(s.emissiveColor, emissive_, uv), 0, 1e30f);
    if (s.useSpecularWorkflow) {
        p.f0 = within(color(s.specularColor, specular_, uv), 0, 1);
        p.f90 = Rgb(std::min(1.0f, maxComponent(p.f0) / kFadingF0));
        p.diffuse = base;
    } else {
        const float metallic = within(number(s.metallic, metallic_, uv), 0, 1);
        const float ior = within(number(s.ior, ior_, uv), 0, 1e6f), ratio = (1 - ior) / (1 + ior);
        const float dielectric = ratio * ratio;
        p.f0 = Rgb(dielectric * (1 - metallic)) + base * metallic;
        p.f90 = Rgb(std::min(1.0f, dielectric / kFadingF0) * (1 - metallic)) + base * metallic;
        p.diffuse = base * (1 - metallic);
    }
    p.roughness = within(number(s.roughness, roughness_, uv), 0, 1);
    p.clearcoat = within(number(s.clearcoat, clearcoat_, uv), 0, 1);
    p.clearcoatRoughness = within(number(s.clearcoatRoughness, clearcoatRoughness_, uv), 0, 1);
    p.opacity = within(number(s.opacity, opacity_, uv), 0, 1);
    p.presence = s.opacityIsPresence || s.opacityThreshold > 0;
    if (s.opacityThreshold > 0) {
        p.opacity = p.opacity >= s.opacityThreshold ? 1.0f : 0.0f;
    }
    return p;
}

Vec3f PlainMaterial::normalAt(Vec2f uv) const {
    if (!normal_) {
        return {0, 0, 1};
    }
    const TextureMap::Rgba v = lookUp(*surface_.normal.texture, normal_.get(), uv);
    const Vec3f n(v[0], v[1], v[2]);
    return isFinite(n) && n.z > 0 ? normalize(n) : Vec3f(0, 0, 1);
}

} // namespace stf
