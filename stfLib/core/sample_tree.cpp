// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/sample_tree.h"

#include <algorithm>
#include <numeric>

namespace stf {

namespace {
constexpr std::uint32_t kLeafPoints = 4;

// Squared distances from a place to the nearest and the farthest point of a box.
Vec2f distances2(const Box3f& box, const Vec3f& p) {
    float near = 0, far = 0;
    for (int a = 0; a < 3; ++a) {
        const float below = box.lo[a] - p[a], above = p[a] - box.hi[a];
        const float out = std::max(0.0f, std::max(below, above)), away = std::max(-below, -above);
        near += out * out;
        far += away * away;
    }
    return {near, far};
}
} // namespace

SampleTree::SampleTree(const std::vector<Vec3f>& positions, const std::vector<float>& areas)
    : positions_(positions), areas_(areas), order_(positions.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    for (float a : areas_) {
        area_ += double(a);
    }
    if (!positions_.empty()) {
        build(0, std::uint32_t(positions_.size()));
    }
}

void SampleTree::build(std::uint32_t begin, std::uint32_t end) {
    const std::size_t self = nodes_.size();
    nodes_.emplace_back();
    Node node;
    node.begin = begin;
    node.end = end;
    Vec3d centre(0.0);
    double area = 0;
    for (std::uint32_t k = begin; k < end; ++k) {
        const std::uint32_t i = order_[k];
        node.box.add(positions_[i]);
        centre += Vec3d(positions_[i]) * double(areas_[i]);
        area += double(areas_[i]);
    }
    node.area = float(area);
    node.centre = area > 0 ? Vec3f(centre / area) : (node.box.lo + node.box.hi) * 0.5f;
    double spread = 0;
    for (std::uint32_t k = begin; k < end; ++k) {
        const Vec3d d = Vec3d(positions_[order_[k]]) - Vec3d(node.centre);
        spread += dot(d, d) * double(areas_[order_[k]]);
    }
    node.spread2 = area > 0 ? float(spread / area) : 0.0f;
    if (end - begin > kLeafPoints) {
        const Vec3f size = node.box.hi - node.box.lo;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const std::uint32_t middle = (begin + end) / 2;
        std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                         [&](std::uint32_t a, std::uint32_t b) {
                             const float x = positions_[a][axis], y = positions_[b][axis];
                             return x != y ? x < y : a < b;
                         });
        build(begin, middle);
        node.right = std::uint32_t(nodes_.size());
        build(middle, end);
    }
    nodes_[self] = node;
}

void SampleTree::terms(const Vec3f& place, const Kernels& kernels, float epsilon, std::vector<Term>& out,
                       Vec3d& total) const {
    out.clear();
    total = Vec3d(0.0);
    if (nodes_.empty()) {
        return;
    }
    // Numerator and denominator each err by a share e of themselves and, together, of T E: the quotient then by
    // 3 e / (1 - 2 e) of B + R E, which is at most epsilon.
    const float e = epsilon / (3 + 2 * epsilon);
    const auto kernelAt = [&](float r2) {
        Rgb k(0.0f);
        for (int c = 0; c < 3; ++c) {
            k[c] = kernels.present[c] ? kernels.dipoles[c].tabulated(r2 + kernels.soften2[c]) : 0.0f;
        }
        return k;
    };
    const auto take = [&](std::uint32_t item, const Rgb& k, float area) {
        out.push_back({item, k});
        total += Vec3d(k) * double(area);
    };
    std::uint32_t stack[64];
    int waiting = 0;
    stack[waiting++] = 0;
    while (waiting > 0) {
        const std::uint32_t at = stack[--waiting];
        const Node& n = nodes_[at];
        const Vec2f r2 = distances2(n.box, place);
        bool far = e > 0;
        if (far) {
            const Rgb high = kernelAt(r2.x), low = kernelAt(r2.y);
            for (int c = 0; c < 3 && far; ++c) {
                // Nearer nodes come first: what they have summed is less than the total.
                const float difference = high[c] - low[c];
                far = difference <= e * low[c] || double(difference) * area_ <= double(e) * total[c];
            }
        }
        if (far) {
            // The mean squared distance of the node's area, so that the first order of its extent drops out.
            const Vec3f d = n.centre - place;
            const float mean = std::min(std::max(dot(d, d) + n.spread2, r2.x), r2.y);
            take(at, kernelAt(mean), n.area);
        } else if (n.right == 0) {
            for (std::uint32_t k = n.begin; k < n.end; ++k) {
                const std::uint32_t i = order_[k];
                const Vec3f d = positions_[i] - place;
                take(std::uint32_t(nodes_.size()) + i, kernelAt(dot(d, d)), areas_[i]);
            }
        } else {
            const bool leftFirst = distances2(nodes_[at + 1].box, place).x <= distances2(nodes_[n.right].box, place).x;
            stack[waiting++] = leftFirst ? n.right : at + 1;
            stack[waiting++] = leftFirst ? at + 1 : n.right;
        }
    }
}

std::vector<Rgb> SampleTree::itemSums(const std::vector<Rgb>& values) const {
    std::vector<Rgb> sums(nodes_.size() + areas_.size());
    for (std::size_t i = 0; i < areas_.size(); ++i) {
        sums[nodes_.size() + i] = values[i] * areas_[i];
    }
    for (std::size_t k = nodes_.size(); k-- > 0;) { // children come after their parents
        const Node& n = nodes_[k];
        if (n.right != 0) {
            sums[k] = sums[k + 1] + sums[n.right];
            continue;
        }
        Vec3d sum(0.0);
        for (std::uint32_t p = n.begin; p < n.end; ++p) {
            sum += Vec3d(values[order_[p]]) * double(areas_[order_[p]]);
        }
        sums[k] = Rgb(sum);
    }
    return sums;
}

float SampleTree::itemArea(std::uint32_t item) const {
    return item < nodes_.size() ? nodes_[item].area : areas_[item - nodes_.size()];
}

} // namespace stf
