// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <vector>

namespace stf {

/// A light for the tree: where it is and how much it sends out.
struct TreeLight {
    Box3f bounds;
    float power = 0; ///< radiance times area, mean of the channels
    std::size_t index = 0;
};

/// Chooses one of many lights with a chance near its share of the light at a point, in logarithmic time: a binary tree
/// of boxes, descended by power over squared distance (Estevez & Kulla 2018, "Importance Sampling of Many Lights with
/// Adaptive Tree Splitting", without orientation cones). Immutable.
class LightTree {
public:
    LightTree() = default;
    explicit LightTree(std::vector<TreeLight> lights);

    bool empty() const { return nodes_.empty(); }
    struct Choice {
        std::size_t index = 0;
        float chance = 0; ///< 0: none
    };
    /// `u` in [0, 1).
    Choice choose(const Vec3f& point, const Vec3f& normal, float u) const;
    /// With which `choose` takes the light of that index (TreeLight::index; below the number of lights).
    float chance(const Vec3f& point, const Vec3f& normal, std::size_t index) const;

    /// Calls visit(index) for lights whose bounds a ray (unit direction) meets before `tMax`.
    template<class Visit>
    void along(const Vec3f& origin, const Vec3f& direction, float tMax, Visit&& visit) const {
        std::vector<int> stack;
        if (!nodes_.empty()) {
            stack.push_back(0);
        }
        while (!stack.empty()) {
            const Node& n = nodes_[std::size_t(stack.back())];
            stack.pop_back();
            if (!meets(n.bounds, origin, direction, tMax)) {
                continue;
            }
            if (n.right < 0) {
                visit(n.index);
            } else {
                stack.push_back(n.right);
                stack.push_back(n.left);
            }
        }
    }

private:
    struct Node {
        Box3f bounds;
        float power = 0;
        int left = -1, right = -1; ///< right < 0: a light
        int above = -1;
        std::size_t index = 0;
    };
    /// Of the left one of a node's two.
    float leftShare(const Node& node, const Vec3f& point, const Vec3f& normal) const;
    int build(std::vector<TreeLight>& lights, std::size_t begin, std::size_t end);
    static float importance(const Node& node, const Vec3f& point, const Vec3f& normal);
    static bool meets(const Box3f& box, const Vec3f& origin, const Vec3f& direction, float tMax);

    std::vector<Node> nodes_;
    std::vector<int> leaf_; ///< node by index of the light
};

} // namespace stf
