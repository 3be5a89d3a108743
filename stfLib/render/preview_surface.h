// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <array>
#include <optional>
#include <string>

namespace stf {

/// An image that drives an input of a material: UsdUVTexture behind a reader of texture coordinates and, where there
/// is one, a UsdTransform2d.
struct TextureMap {
    enum class Wrap { Black, Clamp, Repeat, Mirror };
    /// Auto: images of 8 bits with three or four channels are sRGB, any other is linear.
    enum class ColorSpace { Auto, Raw, Srgb };
    using Rgba = std::array<float, 4>;

    std::string file;         ///< resolved path
    std::string authoredPath; ///< as the scene names it, for messages
    Wrap wrapS = Wrap::Black, wrapT = Wrap::Black;
    ColorSpace colorSpace = ColorSpace::Auto;
    Rgba scale{1, 1, 1, 1}, bias{0, 0, 0, 0}; ///< value = texel * scale + bias
    Rgba fallback{0, 0, 0, 1};                ///< where the file cannot be read
    int channel = -1;                         ///< 0 to 3: r, g, b, a for all of the input; -1: rgb
    /// uv' = rotation * (scale * uv) + translation, the angle in degrees counter-clockwise.
    Vec2f uvScale{1, 1}, uvTranslation{0, 0};
    float uvRotation = 0;

    bool operator==(const TextureMap& t) const {
        return file == t.file && authoredPath == t.authoredPath && wrapS == t.wrapS && wrapT == t.wrapT &&
               colorSpace == t.colorSpace && scale == t.scale && bias == t.bias && fallback == t.fallback &&
               channel == t.channel && uvScale == t.uvScale && uvTranslation == t.uvTranslation &&
               uvRotation == t.uvRotation;
    }
};

/// An input of a material: a value, or an image in its place.
template<class T>
struct SurfaceInput {
    T value{};
    std::optional<TextureMap> texture;
    SurfaceInput() = default;
    SurfaceInput(const T& v) : value(v) {}
    bool operator==(const SurfaceInput& i) const { return value == i.value && texture == i.texture; }
};

/// UsdPreviewSurface, with the names and defaults of its specification. Displacement and occlusion are left out.
struct PreviewSurface {
    SurfaceInput<Rgb> diffuseColor{Rgb(0.18f)};
    SurfaceInput<Rgb> emissiveColor{Rgb(0.0f)}; ///< radiance
    bool useSpecularWorkflow = false;
    SurfaceInput<Rgb> specularColor{Rgb(0.0f)};
    SurfaceInput<float> metallic{0.0f};
    SurfaceInput<float> roughness{0.5f};
    SurfaceInput<float> clearcoat{0.0f};
    SurfaceInput<float> clearcoatRoughness{0.01f};
    SurfaceInput<float> opacity{1.0f};
    float opacityThreshold = 0;     ///< above 0: whole where opacity reaches it, a hole elsewhere
    bool opacityIsPresence = false; ///< what is not opaque has no reflection either
    SurfaceInput<float> ior{1.5f};
    SurfaceInput<Vec3f> normal{Vec3f(0, 0, 1)}; ///< tangent space
    bool diffuseIsDisplayColor = false;         ///< diffuseColor reads the mesh's displayColor

    bool operator==(const PreviewSurface& s) const {
        return diffuseColor == s.diffuseColor && emissiveColor == s.emissiveColor &&
               useSpecularWorkflow == s.useSpecularWorkflow && specularColor == s.specularColor &&
               metallic == s.metallic && roughness == s.roughness && clearcoat == s.clearcoat &&
               clearcoatRoughness == s.clearcoatRoughness && opacity == s.opacity &&
               opacityThreshold == s.opacityThreshold && opacityIsPresence == s.opacityIsPresence && ior == s.ior &&
               normal == s.normal && diffuseIsDisplayColor == s.diffuseIsDisplayColor;
    }
};

} // namespace stf
