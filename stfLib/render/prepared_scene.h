// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/motion.h"
#include "stfLib/render/indirect_light.h"
#include "stfLib/render/light_set.h"
#include "stfLib/render/plain_material.h"
#include "stfLib/render/shell_object.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace stf {

class ShellGlow;

/// A mesh ready for rendering: a shell where a base volume is bound, else a surface with its displayColor.
struct PreparedMesh {
    std::shared_ptr<const RefinedSurface> surface;
    std::shared_ptr<const RayMesh> rayMesh;
    std::shared_ptr<const ShellObject> shell; ///< null for a plain surface
};

struct PreparedInstance {
    std::shared_ptr<const PreparedMesh> mesh;
    Transform objectToWorld, worldToObject;        ///< world relative to the scene's origin; in the exposure's middle
    std::vector<Transform> motion;                 ///< objectToWorld in steps over the exposure; empty: at rest
    std::uint32_t index = 0;                       ///< in the scene
    std::shared_ptr<const PlainMaterial> material; ///< of a plain surface; null: its displayColor
    std::int32_t primId = -1, instanceId = -1;
    std::uint32_t objectId = 0; ///< of its name, for cryptomattes
    std::uint64_t links = 0;    ///< light and shadow links that it belongs to (LightSet::linksOf)
    Box3f bounds;               ///< world
    bool overlapped = false;    ///< another instance's bounds overlap: its surfaces may lie inside this shell
    std::vector<Rgb> core;      ///< radiance leaving the core, per sample of the shell's grid; empty for a black one
    IndirectLight indirect;     ///< on a shell; empty: none
    std::vector<Rgb> exitant;   ///< radiance leaving a shell, mean by the cosine, per point; empty: no shell sees it

    /// A normal of object space in the world, unit: what a map does to normals is the transpose of its inverse.
    Vec3f worldNormal(const Vec3f& n) const { return normalize(Vec3f(worldToObject.transposed(Vec3d(n)))); }
    /// And the other way.
    Vec3f objectNormal(const Vec3f& n) const { return normalize(Vec3f(objectToWorld.transposed(Vec3d(n)))); }
    Vec3f worldPoint(const Vec3f& p) const { return Vec3f(objectToWorld.point(Vec3d(p))); }
    /// A direction of object space, unit.
    Vec3f worldDirection(const Vec3f& d) const { return normalize(Vec3f(objectToWorld.vector(Vec3d(d)))); }
    Vec3f objectDirection(const Vec3f& d) const { return normalize(Vec3f(worldToObject.vector(Vec3d(d)))); }
};

/// Everything a camera ray meets. Immutable while a pass runs.
struct PreparedScene {
    std::vector<PreparedInstance> instances;
    std::unique_ptr<const RayScene> rays;
    LightSet lights;
    Vec3d origin{0, 0, 0};      ///< the scene's middle: everything here is relative to it, in single precision
    float shadowOffset = 1e-5f; ///< world units, for rays that leave a plain surface
    float rounding = 0;         ///< world units: what a position may be off by its representation
    Rgb clearColor{0.0f};
    float clearAlpha = 0;
    std::vector<std::uint32_t> aroundCamera; ///< instances of shells that the camera may be in
    bool clearSurfaces = false;              ///< some surface is not opaque: shadow rays have to look at what they meet
    bool clearShells = false;                ///< some shell does not bend rays: light goes straight through it
    bool surfacesBounce = false;             ///< some plain surface sends light on
    bool shellsSeeOthers = false;            ///< some surface sends light to shells
    bool keepsDomes = false;                 ///< in `indirect` of instances there is the light of smooth domes, too
    std::shared_ptr<const ShellGlow> glow;   ///< what leaves shells, as lights for plain surfaces; null: none
    bool irradianceCache = true;             ///< shells read that light where it is kept; else paths look for it
    int maxDepth = 0;                        ///< bounces off plain surfaces along a path
    bool regularize = true;                  ///< light_path.h
    float indirectClamp = 0; ///< most of light that a bounced path brings, its largest channel; 0: no limit
};

} // namespace stf
