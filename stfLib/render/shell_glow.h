// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/light_set.h"
#include "stfLib/render/light_tree.h"
#include "stfLib/surface/ray_scene.h"

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace stf {

struct PreparedInstance;

/// Shells as lights of the surfaces around them: points of their surfaces, chosen by what leaves them as it is kept
/// (PreparedInstance::exitant) and by distance. Only shells that no light goes through, without a relief and at rest.
/// Immutable, shared by threads.
class ShellGlow {
public:
    /// The instances must outlive this.
    explicit ShellGlow(const std::vector<PreparedInstance>& instances);

    bool empty() const { return facets_.empty(); }
    bool holds(std::uint32_t instance) const { return parts_.count(instance) > 0; }
    /// A direction from a point with a normal (world) to one of them: the perpendicular irradiance that it brings over
    /// the chance, as LightSample. Black where the back of a shell was chosen. `pick` in [0, 1), `u` in [0, 1)^2.
    LightSample sample(const Vec3f& point, const Vec3f& normal, float pick, Vec2f u) const;
    /// Per solid angle, with which `sample` chooses the direction (unit) of a ray from the point that meets an instance
    /// at `hit`.
    float density(std::uint32_t instance, const RayHit& hit, const Vec3f& direction, const Vec3f& point,
                  const Vec3f& normal) const;

private:
    struct Facet {
        Vec3f corner, x, y; ///< world; x, y: to the other two
        Vec3f outward;      ///< as long as twice the area; world
        std::uint32_t triangle;
        float chance, upTo; ///< within its cluster; of those until there with it
        std::uint32_t cluster;
    };
    struct Cluster {
        const PreparedInstance* instance;
        std::uint32_t begin, end; ///< facets
    };
    static constexpr std::uint32_t kDark = 0xffffffff;
    void addInstance(const PreparedInstance& instance, std::vector<TreeLight>& lights);
    void addCluster(const PreparedInstance& instance, std::size_t begin, std::size_t end,
                    std::vector<TreeLight>& lights);

    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> parts_; ///< facet of each triangle of an instance
    std::vector<Facet> facets_;
    std::vector<Cluster> clusters_;
    LightTree tree_;
};

} // namespace stf
