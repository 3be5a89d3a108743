// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_tree.h"

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::size_t kLeaf = 6;
// A node further away than this many radii counts as its dipole; what is left is of the next order, a ninth of a solid
// angle that is itself small. mesh_tree_test measures the error.
constexpr double kFar = 3;

/// Signed solid angle of a triangle from the origin (Van Oosterom and Strackee 1983).
double solidAngle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const double la = length(a), lb = length(b), lc = length(c);
    const double numerator = dot(a, cross(b, c));
    const double denominator = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    return numerator == 0 ? 0.0 : 2 * std::atan2(numerator, denominator);
}

/// Square of the distance from p to a triangle (Ericson 2005, "Real-time collision detection", 5.1.5).
double squaredDistance(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const auto squared = [](const Vec3d& v) { return dot(v, v); };
    const Vec3d ab = b - a, ac = c - a, ap = p - a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) {
        return squared(ap);
    }
    const Vec3d bp = p - b;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) {
        return squared(bp);
    }
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) {
        return squared(ap - ab * (d1 / (d1 - d3)));
    }
    const Vec3d cp = p - c;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) {
        return squared(cp);
    }
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) {
        return squared(ap - ac * (d2 / (d2 - d6)));
    }
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && (d4 - d3) + (d5 - d6) > 0) {
        return squared(bp - (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
    }
    const double sum = va + vb + vc;
    // Without an area the edges above have had their turn; rounding may still lead here.
    return sum > 0 ? squared(ap - ab * (vb / sum) - ac * (vc / sum))
                   : std::min({squared(ap), squared(bp), squared(cp)});
}

} // namespace

TriangleTree::TriangleTree(const TriangleMesh& mesh) {
    triangles_.reserve(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        triangles_.push_back({mesh.corner(i, 0), mesh.corner(i, 1), mesh.corner(i, 2)});
    }
    if (!triangles_.empty()) {
        nodes_.reserve(triangles_.size());
        build(0, triangles_.size());
    }
}

void TriangleTree::build(std::size_t first, std::size_t count) {
    const std::size_t self = nodes_.size();
    nodes_.emplace_back();
    Node node;
    node.first = first;
    node.count = count;
    double area = 0;
    Vec3d mean;
    for (std::size_t i = first; i < first + count; ++i) {
        const Corners& t = triangles_[i];
        node.box.add(t.a);
        node.box.add(t.b);
        node.box.add(t.c);
        const Vec3d vector = cross(t.b - t.a, t.c - t.a) * 0.5;
        node.dipole += vector;
        area += length(vector);
        mean += (t.a + t.b + t.c) * (length(vector) / 3);
    }
    node.centre = area > 0 ? mean / area : node.box.middle();
    for (int k = 0; k < 8; ++k) {
        const Vec3d corner((k & 1) ? node.box.hi.x : node.box.lo.x, (k & 2) ? node.box.hi.y : node.box.lo.y,
                           (k & 4) ? node.box.hi.z : node.box.lo.z);
        node.radius = std::max(node.radius, length(corner - node.centre));
    }
    if (count > kLeaf) {
        const Vec3d size = node.box.size();
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const auto begin = triangles_.begin() + std::ptrdiff_t(first);
        const std::size_t half = count / 2;
        std::nth_element(begin, begin + std::ptrdiff_t(half), begin + std::ptrdiff_t(count),
                         [axis](const Corners& s, const Corners& t) {
                             return s.a[axis] + s.b[axis] + s.c[axis] < t.a[axis] + t.b[axis] + t.c[axis];
                         });
        build(first, half);
        node.right = nodes_.size();
        build(first + half, count - half);
    }
    nodes_[self] = node;
}

double TriangleTree::distance(const Vec3d& p, double bound, std::size_t& hint) const {
    if (nodes_.empty()) {
        return bound;
    }
    double best = bound * bound;
    const auto look = [&](std::size_t i) {
        const double d = squaredDistance(p, triangles_[i].a, triangles_[i].b, triangles_[i].c);
        if (d < best) {
            best = d;
            hint = i;
        }
    };
    look(hint);
    struct Visit {
        std::size_t node;
        double squares; ///< of the distance to its box
    };
    Visit stack[64] = {{0, 0.0}};
    for (int top = 1; top > 0;) {
        const Visit visit = stack[--top];
        if (visit.squares >= best) {
            continue;
        }
        const Node& node = nodes_[visit.node];
        if (!node.right) {
            for (std::size_t i = node.first; i < node.first + node.count; ++i) {
                look(i);
            }
            continue;
        }
        const Visit left{visit.node + 1, nodes_[visit.node + 1].box.squaredDistance(p)};
        const Visit right{node.right, nodes_[node.right].box.squaredDistance(p)};
        // The nearer child comes first.
        const bool swap = right.squares < left.squares;
        stack[top++] = swap ? left : right;
        stack[top++] = swap ? right : left;
    }
    return std::sqrt(best);
}

double TriangleTree::windingNumber(const Vec3d& p) const {
    if (nodes_.empty()) {
        return 0;
    }
    double sum = 0;
    std::size_t stack[64] = {0};
    for (int top = 1; top > 0;) {
        const std::size_t index = stack[--top];
        const Node& node = nodes_[index];
        const Vec3d away = node.centre - p;
        const double squares = dot(away, away), reach = kFar * node.radius;
        if (squares > reach * reach) {
            sum += dot(node.dipole, away) / (squares * std::sqrt(squares));
        } else if (node.right) {
            stack[top++] = node.right;
            stack[top++] = index + 1;
        } else {
            for (std::size_t i = node.first; i < node.first + node.count; ++i) {
                sum += solidAngle(triangles_[i].a - p, triangles_[i].b - p, triangles_[i].c - p);
            }
        }
    }
    return sum / (4 * kPi);
}

} // namespace stf
