// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/light_tree.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {
/// Of the importance, what is left to lights below the horizon: shells bend, and light enters beside the point.
constexpr float kBelowHorizon = 0.05f;
} // namespace

LightTree::LightTree(std::vector<TreeLight> lights) {
    if (!lights.empty()) {
        nodes_.reserve(2 * lights.size());
        build(lights, 0, lights.size());
        std::size_t most = 0;
        for (const TreeLight& l : lights) {
            most = std::max(most, l.index);
        }
        leaf_.assign(most + 1, -1);
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            const Node& n = nodes_[i];
            if (n.right < 0) {
                leaf_[n.index] = int(i);
            } else {
                nodes_[std::size_t(n.left)].above = nodes_[std::size_t(n.right)].above = int(i);
            }
        }
    }
}

int LightTree::build(std::vector<TreeLight>& lights, std::size_t begin, std::size_t end) {
    const int at = int(nodes_.size());
    nodes_.emplace_back();
    Node node;
    Box3f middles;
    for (std::size_t i = begin; i < end; ++i) {
        node.bounds.add(lights[i].bounds.lo);
        node.bounds.add(lights[i].bounds.hi);
        middles.add((lights[i].bounds.lo + lights[i].bounds.hi) * 0.5f);
        node.power += lights[i].power;
    }
    if (end - begin == 1) {
        node.index = lights[begin].index;
    } else {
        // Halves by number along the longest side: depth is logarithmic whatever the positions are.
        const Vec3f size = middles.hi - middles.lo;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const std::size_t middle = begin + (end - begin) / 2;
        std::nth_element(lights.begin() + std::ptrdiff_t(begin), lights.begin() + std::ptrdiff_t(middle),
                         lights.begin() + std::ptrdiff_t(end), [&](const TreeLight& a, const TreeLight& b) {
                             const float x = a.bounds.lo[axis] + a.bounds.hi[axis],
                                         y = b.bounds.lo[axis] + b.bounds.hi[axis];
                             return x != y ? x < y : a.index < b.index;
                         });
        node.left = build(lights, begin, middle);
        node.right = build(lights, middle, end);
    }
    nodes_[std::size_t(at)] = node;
    return at;
}

float LightTree::importance(const Node& n, const Vec3f& point, const Vec3f& normal) {
    float highest = 0; // of the box's corners over the point's plane
    for (int a = 0; a < 3; ++a) {
        highest += std::max((n.bounds.lo[a] - point[a]) * normal[a], (n.bounds.hi[a] - point[a]) * normal[a]);
    }
    // A light may be anywhere in its box: to its middle, and no nearer than half of its size.
    const Vec3f size = n.bounds.hi - n.bounds.lo, middle = (n.bounds.lo + n.bounds.hi) * 0.5f - point;
    const float square = std::max(std::max(dot(middle, middle), 0.25f * dot(size, size)), 1e-20f);
    const float cosine = std::clamp(highest / std::sqrt(square), kBelowHorizon, 1.0f);
    return n.power / square * cosine;
}

float LightTree::leftShare(const Node& n, const Vec3f& point, const Vec3f& normal) const {
    const float a = importance(nodes_[std::size_t(n.left)], point, normal),
                b = importance(nodes_[std::size_t(n.right)], point, normal);
    return a + b > 0 && std::isfinite(a + b) ? a / (a + b) : 0.5f;
}

float LightTree::chance(const Vec3f& point, const Vec3f& normal, std::size_t index) const {
    float chance = 1;
    for (int i = leaf_[index]; nodes_[std::size_t(i)].above >= 0; i = nodes_[std::size_t(i)].above) {
        const Node& above = nodes_[std::size_t(nodes_[std::size_t(i)].above)];
        const float share = leftShare(above, point, normal);
        chance *= above.left == i ? share : 1 - share;
    }
    return chance;
}

LightTree::Choice LightTree::choose(const Vec3f& point, const Vec3f& normal, float u) const {
    Choice out;
    if (nodes_.empty()) {
        return out;
    }
    const Node* n = &nodes_[0];
    float chance = 1;
    while (n->right >= 0) {
        const float share = leftShare(*n, point, normal);
        if (u < share) {
            u = std::min(u / share, 0.99999994f);
            chance *= share;
            n = &nodes_[std::size_t(n->left)];
        } else {
            u = std::min((u - share) / (1 - share), 0.99999994f);
            chance *= 1 - share;
            n = &nodes_[std::size_t(n->right)];
        }
    }
    return {n->index, chance};
}

bool LightTree::meets(const Box3f& box, const Vec3f& o, const Vec3f& d, float tMax) {
    float t0 = 0, t1 = tMax;
    for (int a = 0; a < 3; ++a) {
        if (std::abs(d[a]) < 1e-20f) {
            if (o[a] < box.lo[a] || o[a] > box.hi[a]) {
                return false;
            }
            continue;
        }
        const float inverse = 1 / d[a], near = (box.lo[a] - o[a]) * inverse, far = (box.hi[a] - o[a]) * inverse;
        t0 = std::max(t0, std::min(near, far) * (1 - 1e-6f));
        t1 = std::min(t1, std::max(near, far) * (1 + 1e-6f));
    }
    return t0 <= t1;
}

} // namespace stf
