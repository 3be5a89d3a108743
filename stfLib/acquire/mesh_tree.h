// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_triangles.h"

namespace stf {

/// A tree of boxes over triangles: distances, and generalised winding numbers (Jacobson et al. 2013) in the
/// hierarchical form of Barill et al. 2018, "Fast winding numbers for soups and clouds". Copies the triangles.
/// Immutable, queries from any number of threads.
class TriangleTree {
public:
    explicit TriangleTree(const TriangleMesh& mesh);

    bool empty() const { return triangles_.empty(); }
    /// From p to the nearest triangle; `bound` where none is nearer than that. `hint` is a triangle that may be near (0
    /// to begin with), which shortens the search; it becomes the nearest one.
    double distance(const Vec3d& p, double bound, std::size_t& hint) const;
    double distance(const Vec3d& p, double bound = 1e300) const {
        std::size_t hint = 0;
        return distance(p, bound, hint);
    }
    /// Sum of the signed solid angles of the triangles over 4 pi: 1 inside a closed mesh that faces outward, 0 outside,
    /// in between where holes let the outside in. What is far away is taken as a dipole: error below 0.01.
    double windingNumber(const Vec3d& p) const;

private:
    struct Corners {
        Vec3d a, b, c;
    };
    struct Node {
        Box3d box;
        Vec3d centre, dipole; ///< mean of the triangles by area, sum of their area vectors
        double radius = 0;    ///< about `centre`
        std::size_t first = 0, count = 0;
        std::size_t right = 0; ///< second child, the first one follows its parent; 0: a leaf
    };
    void build(std::size_t first, std::size_t count);

    std::vector<Corners> triangles_;
    std::vector<Node> nodes_;
};

} // namespace stf
