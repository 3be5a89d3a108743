// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/posed_shell.h"

#include "stfLib/base/parallel.h"
#include "stfLib/shell/shell_prism.h"
#include "stfLib/surface/surface_graph.h"

#include <algorithm>

namespace stf {

namespace {

constexpr int kMostHops = 256;        ///< triangles from one place to the next
constexpr int kMostSteps = 12;        ///< of Newton's method
constexpr double kElsewhere = 3;      ///< barycentric: so far off, only the direction to go is asked for
constexpr double kOnEdge = 1e-6;      ///< barycentric: of either triangle
constexpr double kBetweenTwo = 1e-2;  ///< prisms of an edge that both disown a point, by rounding or a bend
constexpr double kPrecision = 1e-7;   ///< barycentric, and of the thickness
constexpr double kSlackOutside = 0.5; ///< of the thickness above the surface and below the inner boundary

} // namespace

ShellBoundary offsetPosed(const RefinedSurface& posed, float thickness, const ShellBoundary& rest) {
    ShellBoundary boundary = offsetInward(posed, thickness, {});
    if (rest.thickness.size() != boundary.thickness.size()) {
        throw Error("the rest pose has other points than the pose");
    }
    for (std::size_t i = 0; i < boundary.thickness.size(); ++i) {
        float& t = boundary.thickness[i];
        if (rest.thickness[i] < t) {
            const Vec3d p(posed.points[i]);
            boundary.inner[i] = Vec3f(p + (Vec3d(boundary.inner[i]) - p) * double(rest.thickness[i] / t));
            t = rest.thickness[i];
        }
    }
    return boundary;
}

PosedShell::Neighbours PosedShell::neighboursOf(const RefinedSurface& surface) {
    // Points that modellers doubled along a cut are one here.
    const std::vector<Vec3i> triangles = surfaceGraph(surface).triangles;
    struct Side {
        int low, high;
        std::uint32_t triangle;
        int corner;
    };
    std::vector<Side> sides;
    sides.reserve(3 * triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c) {
            const int a = triangles[t][c], b = triangles[t][(c + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), std::uint32_t(t), c});
        }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
    });
    Neighbours neighbours(triangles.size(), Vec3i(-1));
    for (std::size_t i = 0, next; i < sides.size(); i = next) {
        next = i + 1;
        while (next < sides.size() && sides[next].low == sides[i].low && sides[next].high == sides[i].high) {
            ++next;
        }
        if (next == i + 2) {
            neighbours[sides[i].triangle][sides[i].corner] = int(sides[i + 1].triangle);
            neighbours[sides[i + 1].triangle][sides[i + 1].corner] = int(sides[i].triangle);
        }
    }
    return neighbours;
}

PosedShell::PosedShell(Shape rest, Shape posed, std::shared_ptr<const Neighbours> neighbours)
    : rest_(std::move(rest)), posed_(std::move(posed)), neighbours_(std::move(neighbours)) {
    if (rest_.surface->triangles != posed_.surface->triangles ||
        neighbours_->size() != rest_.surface->triangles.size()) {
        throw Error("the pose has other triangles than the rest pose");
    }
}

bool PosedShell::locate(const Vec3f& point, Place& place) const {
    ShellPrism prism;
    std::uint32_t triangle = place.triangle, last = triangle;
    ShellPrism::Point at{place.b1, place.b2, place.depth, false};
    for (int hop = 0; hop < kMostHops; ++hop) {
        if (!prism.set(*posed_.surface, *posed_.boundary, triangle)) {
            return false;
        }
        const Vec3d w = Vec3d(point) - prism.p0;
        const double thick = prism.largestThickness();
        bool converged = false, away = false;
        for (int i = 0; i < kMostSteps && !converged && !away; ++i) {
            Vec3d step;
            if (!prism.newton(w, at, step) || !std::isfinite(at.b1) || !std::isfinite(at.b2) || !std::isfinite(at.d)) {
                return false;
            }
            converged =
                std::abs(step.x) < kPrecision && std::abs(step.y) < kPrecision && std::abs(step.z) < kPrecision * thick;
            away = std::max(std::abs(at.b1 - 0.5), std::abs(at.b2 - 0.5)) > kElsewhere;
        }
        const double b[3] = {1 - at.b1 - at.b2, at.b1, at.b2};
        // Towards the side beyond which the point lies farthest; where the surface ends there, the next farthest.
        int order[3] = {0, 1, 2};
        std::sort(order, order + 3, [&](int i, int j) { return b[i] < b[j]; });
        const double outside = -b[order[0]];
        int next = -1;
        for (int k = 0; k < 3 && next < 0 && b[order[k]] < -kOnEdge; ++k) {
            next = (*neighbours_)[triangle][(order[k] + 1) % 3];
        }
        const bool here = outside <= kOnEdge || (outside < kBetweenTwo && (next < 0 || std::uint32_t(next) == last));
        if (converged && here) {
            if (at.folded || at.d < -kSlackOutside * thick || at.d > (1 + kSlackOutside) * thick) {
                return false;
            }
            place = {triangle, at.b1, at.b2, at.d};
            return true;
        }
        if (next < 0) {
            return false;
        }
        last = triangle;
        triangle = std::uint32_t(next);
        at = {1.0 / 3, 1.0 / 3, std::clamp(at.d, 0.0, thick), false};
    }
    return false;
}

Vec3f PosedShell::atRest(const Place& place) const {
    ShellPrism prism;
    prism.set(*rest_.surface, *rest_.boundary, place.triangle);
    return Vec3f(prism.at({place.b1, place.b2, place.depth, false}));
}

void PosedShell::carry(const Place& place, ShellLookup& lookup) const {
    const ShellPrism::Point at{place.b1, place.b2, place.depth, false};
    ShellPrism rest, posed;
    if (rest.set(*rest_.surface, *rest_.boundary, place.triangle) &&
        posed.set(*posed_.surface, *posed_.boundary, place.triangle)) {
        const Vec3d c1 = posed.column(0, at), c2 = posed.column(1, at), c3 = posed.column(2, at);
        const Vec3d dual[3] = {cross(c2, c3), cross(c3, c1), cross(c1, c2)};
        const double det = dot(c1, dual[0]);
        // A gradient is a covector: what it says along each edge and along depth stays.
        for (Vec3f* g : {&lookup.gradX, &lookup.gradY}) {
            Vec3d carried;
            for (int i = 0; i < 3; ++i) {
                carried += dual[i] * (dot(Vec3d(*g), rest.column(i, at)) / det);
            }
            if (isFinite(carried)) {
                *g = Vec3f(carried);
            }
        }
    }
    const RefinedSurface& s = *posed_.surface;
    const Vec3i& t = s.triangles[place.triangle];
    const double b[3] = {1 - place.b1 - place.b2, place.b1, place.b2};
    Vec3d normal;
    for (int c = 0; c < 3; ++c) {
        normal += b[c] * Vec3d(s.cornerNormals.empty() ? s.normals[std::size_t(t[c])]
                                                       : s.cornerNormals[3 * place.triangle + std::size_t(c)]);
    }
    lookup.normal = Vec3f(normalize(normal));
}

void ShellProbe::enter(std::uint32_t triangle) {
    place_ = {triangle};
    const Vec3i& t = surface_.triangles[triangle];
    const Vec3f& p = surface_.points[std::size_t(t.x)];
    accessor_.prefer(normalize(cross(surface_.points[std::size_t(t.y)] - p, surface_.points[std::size_t(t.z)] - p)));
}

bool ShellProbe::lookup(const Vec3f& point, ShellLookup& out, const Rgb* core, int level) {
    if (!pose_) {
        return accessor_.lookup(point, out, core, level);
    }
    if (!pose_->locate(point, place_) || !accessor_.lookup(pose_->atRest(place_), out, core, level)) {
        return false;
    }
    pose_->carry(place_, out);
    return true;
}

} // namespace stf
