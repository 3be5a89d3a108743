// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/core/dipole.h"

#include <cstdint>
#include <vector>

namespace stf {

/// A tree of boxes over points with areas, for sums of a kernel that falls with distance (Jensen & Buhler 2002). A node
/// stands for its points only where the kernel's least and greatest value over its box, at the farthest and the nearest
/// place of it, are close enough: the error has a bound, whatever the light. Totals of nodes are exact sums.
class SampleTree {
public:
    SampleTree() = default;
    SampleTree(const std::vector<Vec3f>& positions, const std::vector<float>& areas);

    /// Terms of a sum: `item` names a node, or a point by its number plus `nodeCount()`.
    struct Term {
        std::uint32_t item = 0;
        Rgb kernel{0.0f};
    };
    struct Kernels {
        const Dipole* dipoles = nullptr;      ///< of each channel
        float soften2[3] = {0, 0, 0};         ///< mm^2, added to squared distances
        bool present[3] = {true, true, true}; ///< channels that are asked for
    };
    /// The terms of the sum at a place. With T = sum of kernel * area over all points and E their mean irradiance,
    /// R sum(kernel * flux) / sum(kernel * area) over the terms differs from that over the points by at most
    /// `epsilon` (B + R E), B being the latter. 0: all points. `total` receives sum(kernel * area) of the terms.
    void terms(const Vec3f& place, const Kernels& kernels, float epsilon, std::vector<Term>& out, Vec3d& total) const;

    /// Per item: sums of area * value; of a node over its points, in a fixed order.
    std::vector<Rgb> itemSums(const std::vector<Rgb>& values) const;
    float itemArea(std::uint32_t item) const;
    std::size_t nodeCount() const { return nodes_.size(); }
    std::size_t pointCount() const { return areas_.size(); }

private:
    struct Node {
        Box3f box;
        Vec3f centre;      ///< of area
        float spread2 = 0; ///< mean squared distance from the centre, by area
        float area = 0;
        std::uint32_t begin = 0, end = 0, right = 0; ///< points; the left child follows, right == 0: a leaf
    };
    void build(std::uint32_t begin, std::uint32_t end);

    std::vector<Vec3f> positions_;
    std::vector<float> areas_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
    double area_ = 0;
};

} // namespace stf
