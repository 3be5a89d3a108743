// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"
#include "stfLib/render/area_shape.h"
#include "stfLib/render/dome_light.h"
#include "stfLib/render/light_tree.h"
#include "stfLib/render/mesh_shape.h"
#include "stfLib/render/shaped_emission.h"
#include "stfLib/surface/ray_scene.h"

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

namespace stf {

/// A direction towards a light, and what it brings: the estimate of the perpendicular irradiance of all directions of
/// that light (radiance over density). Zero where nothing comes from there.
struct LightSample {
    Vec3f towards{0, 0, 1};
    Rgb irradiance{0.0f};
    float density = 0; ///< per solid angle, of the direction; 0: only a sample finds the light, no ray meets it
    float distance = std::numeric_limits<float>::infinity(); ///< other geometry beyond it throws no shadow
    bool shadows = true;                                     ///< false: nothing throws a shadow
    bool onMesh = false;                                     ///< of a mesh that shines, which rays meet as geometry,
    Vec3f point;                                             ///< at this point
    std::uint64_t lit = 0;     ///< links of which one lets a prim get this light; 0: all do
    std::uint64_t shading = 0; ///< links of which one lets a prim throw its shadow; 0: all do
};

/// From a point to just before the light.
inline Ray shadowRay(const Vec3f& origin, const LightSample& light) {
    Ray r;
    r.origin = origin;
    r.direction = light.towards;
    float distance = light.distance;
    if (light.onMesh) {
        // From wherever the ray starts to that very point, else the mesh itself would be in its way.
        const Vec3f way = light.point - origin;
        distance = length(way);
        r.direction = distance > 0 ? way / distance : light.towards;
    }
    r.tFar = distance * (1 - 1e-4f);
    return r;
}

/// A light that a path takes part of, and by how much more it counts for those that it does not.
struct LightPick {
    std::size_t light = 0;
    float weight = 1;
};

/// A mesh that shines by itself: everywhere the same, to both sides, opaque, and at rest.
struct MeshEmitter {
    std::shared_ptr<const RefinedSurface> surface;
    Transform objectToWorld; ///< world relative to the scene's origin
    Rgb radiance{0.0f};
    std::uint32_t instance = 0; ///< its number in the scene
};

/// All lights that give light, ready for sampling. Immutable but for `place`, shared by threads.
class LightSet {
public:
    LightSet() = default;
    /// Lights that are invisible or black are left out; unreadable textures and profiles are reported, the light shines
    /// without them.
    LightSet(const std::map<std::string, Light>& lights, const MessageSink& messages);
    /// Gives a distant light a larger angle (degrees), of the same irradiance.
    static void widen(Light& light, float angle);
    /// Points are relative to a world position from now on (the scene's middle, so that single precision is enough),
    /// and these meshes are lights too.
    void place(const Vec3d& origin, const std::vector<MeshEmitter>& meshes = {});

    /// The bits of links by their names; names that no light has count for nothing.
    std::uint64_t linksOf(const std::vector<std::string>& names) const;

    std::size_t count() const { return lights_.size(); }
    /// How many of them are meshes.
    std::size_t meshCount() const { return emitters_.size(); }
    /// At most `most` lights for a point: all, where there are no more; else some, so that the sum of what each brings
    /// times its weight has the right expectation. Lights with an area are chosen by their power and distance, at a
    /// cost logarithmic in their number. Returns how many. `u` in [0, 1).
    int choose(const Vec3f& point, const Vec3f& normal, float u, int most, LightPick* picks) const;
    /// What a light brings to a point with a normal (a dome is sampled by its cosine).
    LightSample sample(std::size_t light, const Vec3f& point, const Vec3f& normal, Vec2f u) const;
    /// Whether `sample` reads its numbers: a distant light without a disc has one direction.
    bool hasExtent(std::size_t light) const {
        return lights_[light].type != Light::Type::Distant || lights_[light].cosAngle < 1;
    }
    /// How many directions towards a light are worth while on one path.
    bool isDome(std::size_t light) const { return lights_[light].type == Light::Type::Dome; }

    /// A dome without bright spots: its light can be kept like that of surfaces.
    bool isSmoothDome(std::size_t light) const {
        const Prepared& l = lights_[light];
        return isDome(light) && l.shadows && l.lit == 0 && l.shading == 0 && l.dome.smooth();
    }
    /// Radiance of what lies behind everything, in a direction. `links`: of who gets that light; the camera sees all.
    Rgb background(const Vec3f& direction, std::uint64_t links = kAllLinks) const;
    /// Of the smooth domes alone.
    Rgb smoothBackground(const Vec3f& direction) const;
    bool hasDome() const;
    /// Whether some prims throw no shadow of some light.
    bool linksShadows() const { return linksShadows_; }
    /// Radiance of the lights with an area, and of wide distant ones, that a mirrored ray meets between `tNear` and
    /// `tMax`. Rays of the camera do not see them, as in other renderers. `blur`: least half angle, radians, of the
    /// discs of those distant lights, which give the same light all in all. `links`: of who gets it.
    Rgb mirrored(const Vec3f& origin, const Vec3f& direction, float tNear, float tMax, float blur = 0,
                 std::uint64_t links = kAllLinks) const;
    /// What is left of a ray on its way to a light at a distance of which only prims with one of the links `shading`
    /// throw a shadow.
    using Reach = std::function<Rgb(std::uint64_t shading, float distance)>;
    /// How a ray's direction was chosen where `sample` was asked as well.
    struct Chosen {
        Vec3f normal;    ///< of the surface that the ray leaves
        float density;   ///< of its direction, per solid angle
        int domeSamples; ///< for each dome; of any other light there was one
        /// Lights that not everything throws a shadow of are met as well, which samples find behind whatever is there.
        bool shadowless;
        std::uint64_t links = kAllLinks; ///< of the surface
        const Reach* reach = nullptr;    ///< needed where `linksShadows()`
    };
    /// The same as `mirrored` and, where nothing is met, the domes, for such a ray: their shares by the balance
    /// heuristic (Veach 1997).
    Rgb met(const Vec3f& origin, const Vec3f& direction, float tNear, float tMax, const Chosen& chosen) const;

    /// The density per solid angle with which `sample` finds a point of an instance that is a light, where it is met at
    /// a distance, at an angle to its normal; 0 for any other instance.
    float emitterDensity(std::uint32_t instance, float distance, float cosine) const;

private:
    struct Prepared {
        std::shared_ptr<const MeshShape> mesh; ///< of a mesh that shines; rays meet it as geometry
        Light::Type type = Light::Type::Distant;
        Rgb emission{0.0f};  ///< distant: irradiance; area: radiance
        Vec3f axis{0, 0, 1}; ///< distant: towards the light
        float cosAngle = 1;  ///< distant: of half the angle
        DomeLight dome;
        // With an area.
        Light light;
        AreaShape shape;
        ShapedEmission shaping;
        Transform worldToLight;
        LatLongImage image; ///< of a rectangle
        bool shadows = true;
        std::uint64_t lit = 0, shading = 0; ///< links; 0: all
        bool reaches(std::uint64_t links) const { return lit == 0 || (lit & links) != 0; }
        Rgb radiance(const Vec3f& direction, const Vec3f& at) const;
        bool seenAlong() const;
        bool behindThings() const { return !shadows || shading != 0; }
    };
    struct Way {
        Vec3f origin, direction;
        float tNear, tMax;
        bool sampled, shadowless; ///< sampled: lights `behindThings` are met wherever they are, if `shadowless`
        float blur;               ///< half angle
        std::uint64_t links;
    };
    /// Calls visit(light, radiance, distance) for what lies on a way.
    template<class Visit>
    void along(const Way& way, Visit&& visit) const;
    bool prepareArea(const std::string& id, Prepared& light, const MessageSink& messages) const;

    std::uint64_t linkBit(const std::string& id, const std::string& name, const MessageSink& messages);

    std::map<std::string, std::uint64_t> links_;
    std::vector<Prepared> lights_;                            ///< meshes last
    std::size_t hostLights_ = 0;                              ///< those before the meshes
    std::unordered_map<std::uint32_t, std::size_t> emitters_; ///< light by instance
    std::vector<std::size_t> far_;                            ///< distant lights and domes
    LightTree tree_;                                          ///< of the others
    bool anyBehindThings_ = false, linksShadows_ = false;
    std::size_t areaCount_ = 0;
};

} // namespace stf
