// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/preview_bsdf.h"
#include "stfLib/render/texture.h"

namespace stf {

/// A PreviewSurface with its images, ready to be looked up. Immutable, shared by threads.
class PlainMaterial {
public:
    /// Images that cannot be read are reported as `id`'s; the input has the texture's fallback then.
    PlainMaterial(const std::string& id, const PreviewSurface& surface, TextureStore& textures,
                  const MessageSink& messages);

    const PreviewSurface& surface() const { return surface_; }
    /// At texture coordinates of a mesh whose displayColor is `displayColor` there.
    PreviewPoint at(Vec2f uv, const Rgb& displayColor) const;
    bool hasNormalMap() const { return surface_.normal.texture.has_value(); }
    /// Unit, tangent space.
    Vec3f normalAt(Vec2f uv) const;
    /// Whether light passes anywhere.
    bool opaque() const { return opaque_; }
    bool emits() const { return surface_.emissiveColor.texture || maxComponent(surface_.emissiveColor.value) > 0; }
    /// Radiance, where no texture gives it.
    Rgb emission() const;
    bool usesUvs() const { return textured_ > 0; }
    int textures() const { return textured_; }

private:
    using Held = std::shared_ptr<const Texture>;
    template<class T>
    Held hold(const std::string& id, const SurfaceInput<T>& input, TextureStore& textures, const MessageSink& messages);
    Rgb color(const SurfaceInput<Rgb>& input, const Held& held, Vec2f uv) const;
    float number(const SurfaceInput<float>& input, const Held& held, Vec2f uv) const;

    PreviewSurface surface_;
    Held diffuse_, emissive_, specular_, metallic_, roughness_, clearcoat_, clearcoatRoughness_, opacity_, ior_,
        normal_;
    bool opaque_ = true;
    int textured_ = 0;
};

} // namespace stf
