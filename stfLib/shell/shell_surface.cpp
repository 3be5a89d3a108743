// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_surface.h"

#include "stfLib/base/parallel.h"
#include "stfLib/surface/ray_scene.h"

#include <cstdio>
#include <queue>

namespace stf {

namespace {

constexpr float curvatureShare = 0.9f;  ///< of the depth at which the offset folds over
constexpr float thicknessShare = 0.45f; ///< of the object's local thickness: two shells and a gap
constexpr float leastShare = 1e-3f;     ///< of the wanted thickness: prisms must not vanish
constexpr double largestMitre = 2;      ///< of the thickness, at sharp spikes
constexpr float largestSlope = 0.5f;    ///< of the thickness along the surface, beside clamped points

Vec3d at(const std::vector<Vec3f>& values, int i) {
    return Vec3d(values[std::size_t(i)]);
}

/// Outward, one per point, with a component of about 1 across the faces there: the normal on smooth surfaces, longer at
/// hard edges.
std::vector<Vec3f> offsetDirections(const RefinedSurface& surface) {
    std::vector<double> across(surface.points.size(), 0), angles(surface.points.size(), 0);
    for (const Vec3i& t : surface.triangles) {
        const Vec3d p[3] = {at(surface.points, t.x), at(surface.points, t.y), at(surface.points, t.z)};
        const Vec3d facet = normalize(cross(p[1] - p[0], p[2] - p[0]));
        for (int c = 0; c < 3; ++c) {
            const Vec3d a = p[(c + 1) % 3] - p[c], b = p[(c + 2) % 3] - p[c];
            const double angle = std::atan2(length(cross(a, b)), dot(a, b));
            across[std::size_t(t[c])] += angle * dot(at(surface.normals, t[c]), facet);
            angles[std::size_t(t[c])] += angle;
        }
    }
    std::vector<Vec3f> directions = surface.normals;
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const double stretch = angles[i] / std::max(across[i], angles[i] / largestMitre);
        // Facets of a smooth surface lean away from its normals a little; that is no edge.
        const double edge = std::clamp((stretch - 1.01) / 0.04, 0.0, 1.0);
        directions[i] *= float(angles[i] > 0 ? 1 + (stretch - 1) * edge : 1.0);
    }
    return directions;
}

/// Depth at which a triangle, moved along its corners' directions, first has no area or turns over; `limit` if later.
/// With corners P_i - d N_i the doubled area vector is a quadratic in d.
double foldDepth(const RefinedSurface& surface, const std::vector<Vec3f>& directions, const Vec3i& t, double limit) {
    const Vec3d e1 = at(surface.points, t.y) - at(surface.points, t.x);
    const Vec3d e2 = at(surface.points, t.z) - at(surface.points, t.x);
    const Vec3d m1 = at(directions, t.y) - at(directions, t.x);
    const Vec3d m2 = at(directions, t.z) - at(directions, t.x);
    const Vec3d n = normalize(at(directions, t.x) + at(directions, t.y) + at(directions, t.z));
    const double c = dot(cross(e1, e2), n);
    if (!(c > 0)) {
        return limit; // degenerate or already turned: nothing to learn from it
    }
    const double b = -(dot(cross(e1, m2), n) + dot(cross(m1, e2), n)), a = dot(cross(m1, m2), n);
    // a d^2 + b d + c = 0, the smallest positive root, by the form that does not cancel.
    const double discriminant = b * b - 4 * a * c;
    if (discriminant < 0) {
        return limit;
    }
    const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
    double depth = limit;
    for (double root : {q != 0 ? c / q : -1.0, a != 0 ? q / a : -1.0}) {
        if (root > 0) {
            depth = std::min(depth, root);
        }
    }
    return depth;
}

void limitByCurvature(const RefinedSurface& surface, const std::vector<Vec3f>& directions, float thickness,
                      std::vector<float>& limit) {
    for (const Vec3i& t : surface.triangles) {
        const double far = 2.0 * double(thickness) / double(curvatureShare);
        const float most = float(foldDepth(surface, directions, t, far) * double(curvatureShare));
        for (int c = 0; c < 3; ++c) {
            limit[std::size_t(t[c])] = std::min(limit[std::size_t(t[c])], most);
        }
    }
}

void limitByOppositeSide(const RefinedSurface& surface, const std::vector<Vec3f>& directions, float thickness,
                         std::vector<float>& limit) {
    const RayMesh mesh(surface.points, surface.triangles);
    std::vector<float> edge(surface.points.size(), 1e30f);
    for (const Vec3i& t : surface.triangles) {
        for (int c = 0; c < 3; ++c) {
            const int a = t[c], b = t[(c + 1) % 3];
            const float l = float(length(at(surface.points, a) - at(surface.points, b)));
            edge[std::size_t(a)] = std::min(edge[std::size_t(a)], l);
            edge[std::size_t(b)] = std::min(edge[std::size_t(b)], l);
        }
    }
    parallelFor(surface.points.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Ray ray;
            ray.origin = surface.points[i];
            ray.direction = -directions[i]; // so that hits are found at depths across the shell
            // Past the point's own triangles, but not past the other side of a thin part.
            ray.tNear = std::max(
                1e-2f * std::min(edge[i], thickness),
                4e-7f * maxComponent(Vec3f(std::abs(ray.origin.x), std::abs(ray.origin.y), std::abs(ray.origin.z))));
            ray.tFar = 1.01f * thickness / thicknessShare;
            RayHit hit;
            // Only a surface seen from within is the other side; others are parts that stand in one another.
            if (mesh.intersect(ray, hit, 1) && dot(hit.geometricNormal, ray.direction) > 0) {
                limit[i] = std::min(limit[i], thicknessShare * hit.t);
            }
        }
    });
}

/// Lowers values beside low ones so that none exceeds a neighbour by more than the slope allows.
class Spread {
public:
    explicit Spread(const RefinedSurface& surface) : surface_(surface), first_(surface.points.size() + 1, 0) {
        for (const Vec3i& t : surface.triangles) {
            for (int c = 0; c < 3; ++c) {
                first_[std::size_t(t[c]) + 1] += 2;
            }
        }
        for (std::size_t i = 1; i < first_.size(); ++i) {
            first_[i] += first_[i - 1];
        }
        neighbours_.resize(first_.back());
        std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
        for (const Vec3i& t : surface.triangles) {
            for (int c = 0; c < 3; ++c) {
                neighbours_[next[std::size_t(t[c])]++] = t[(c + 1) % 3];
                neighbours_[next[std::size_t(t[c])]++] = t[(c + 2) % 3];
            }
        }
    }

    void apply(float wanted, std::vector<float>& values) const {
        using Item = std::pair<float, int>;
        std::priority_queue<Item, std::vector<Item>, std::greater<Item>> queue;
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (values[i] < wanted) {
                queue.push({values[i], int(i)});
            }
        }
        while (!queue.empty()) {
            const auto [value, i] = queue.top();
            queue.pop();
            if (value > values[std::size_t(i)]) {
                continue;
            }
            for (std::size_t k = first_[std::size_t(i)]; k < first_[std::size_t(i) + 1]; ++k) {
                const int j = neighbours_[k];
                const float l = float(length(at(surface_.points, j) - at(surface_.points, i)));
                const float most = value + largestSlope * l;
                if (most < values[std::size_t(j)]) {
                    values[std::size_t(j)] = most;
                    queue.push({most, j});
                }
            }
        }
    }

private:
    const RefinedSurface& surface_;
    std::vector<std::size_t> first_; ///< neighbours of point i: from first_[i] to first_[i + 1]
    std::vector<int> neighbours_;
};

void offset(const RefinedSurface& surface, const std::vector<Vec3f>& directions, ShellBoundary& boundary) {
    boundary.inner.resize(surface.points.size());
    for (std::size_t i = 0; i < surface.points.size(); ++i) {
        boundary.inner[i] = Vec3f(Vec3d(surface.points[i]) - Vec3d(directions[i]) * double(boundary.thickness[i]));
    }
}

/// Triangles that turned over although each point alone would not: different thicknesses at their corners.
bool lowerTurned(const RefinedSurface& surface, float least, ShellBoundary& boundary, std::vector<char>& turned) {
    std::vector<float> factor(surface.points.size(), 1.0f);
    bool any = false;
    for (const Vec3i& t : surface.triangles) {
        const Vec3d outer =
            cross(at(surface.points, t.y) - at(surface.points, t.x), at(surface.points, t.z) - at(surface.points, t.x));
        const Vec3d inner =
            cross(at(boundary.inner, t.y) - at(boundary.inner, t.x), at(boundary.inner, t.z) - at(boundary.inner, t.x));
        if (dot(outer, inner) < 0) {
            for (int c = 0; c < 3; ++c) {
                any = any || boundary.thickness[std::size_t(t[c])] > least;
                factor[std::size_t(t[c])] = 0.7f;
                turned[std::size_t(t[c])] = 1;
            }
        }
    }
    for (std::size_t i = 0; i < factor.size(); ++i) {
        boundary.thickness[i] = std::max(least, factor[i] * boundary.thickness[i]);
    }
    return any;
}

/// A third of the area of its triangles, for each point.
std::vector<double> areas(const RefinedSurface& surface) {
    std::vector<double> out(surface.points.size(), 0);
    for (const Vec3i& t : surface.triangles) {
        const Vec3d p = at(surface.points, t.x);
        const double area = length(cross(at(surface.points, t.y) - p, at(surface.points, t.z) - p)) / 6;
        for (int c = 0; c < 3; ++c) {
            out[std::size_t(t[c])] += std::isfinite(area) ? area : 0.0;
        }
    }
    return out;
}

/// What each limit did; the lowest counts.
ShellClamping explain(const RefinedSurface& surface, float thickness, const std::vector<float>& byCurvature,
                      const std::vector<float>& byThinParts, const std::vector<char>& turned, ShellBoundary& boundary) {
    ShellClamping out;
    out.lowest = thickness;
    const std::vector<double> area = areas(surface);
    double all = 0;
    for (std::size_t i = 0; i < area.size(); ++i) {
        const float t = boundary.thickness[i];
        all += area[i];
        out.lowest = std::min(out.lowest, t);
        if (!(t < thickness * (1 - 1e-5f))) {
            continue;
        }
        ++boundary.clampedPoints;
        const float limit = std::min(byCurvature[i], byThinParts[i]);
        double& cause = turned[i]                            ? out.turned
                        : !(limit < thickness * (1 - 1e-5f)) ? out.beside
                        : byThinParts[i] <= byCurvature[i]   ? out.thinParts
                                                             : out.curvature;
        cause += area[i];
    }
    for (double* share : {&out.curvature, &out.thinParts, &out.turned, &out.beside}) {
        *share = all > 0 ? *share / all : 0;
    }
    return out;
}

} // namespace

ShellBoundary offsetInward(const RefinedSurface& surface, float thickness, const MessageSink& messages) {
    if (!(thickness > 0) || !std::isfinite(thickness)) {
        throw Error("the shell's thickness is not positive");
    }
    if (surface.normals.size() != surface.points.size()) {
        throw Error("the surface has no normals");
    }
    ShellBoundary boundary;
    boundary.thickness.assign(surface.points.size(), thickness);
    const std::vector<Vec3f> directions = offsetDirections(surface);
    std::vector<float> byCurvature = boundary.thickness, byThinParts = boundary.thickness;
    limitByCurvature(surface, directions, thickness, byCurvature);
    limitByOppositeSide(surface, directions, thickness, byThinParts);
    for (std::size_t i = 0; i < byCurvature.size(); ++i) {
        boundary.thickness[i] = std::min(byCurvature[i], byThinParts[i]);
    }

    const float least = leastShare * thickness;
    for (float& t : boundary.thickness) {
        t = std::max(least, t); // NaN: least
    }
    const Spread spread(surface);
    spread.apply(thickness, boundary.thickness);
    offset(surface, directions, boundary);
    std::vector<char> turned(surface.points.size(), 0);
    for (int round = 0; round < 8 && lowerTurned(surface, least, boundary, turned); ++round) {
        spread.apply(thickness, boundary.thickness);
        offset(surface, directions, boundary);
    }

    boundary.clamping = explain(surface, thickness, byCurvature, byThinParts, turned, boundary);
    if (boundary.clampedPoints) {
        const ShellClamping& c = boundary.clamping;
        char text[400];
        std::snprintf(
            text, sizeof text,
            "the shell is thinner than wanted at %d of %zu points (down to %.3g of %.3g units), on %.2g %% of "
            "the surface where it would fold over, %.2g %% where it would meet the other side, %.2g %% where "
            "triangles would turn over and %.2g %% beside those",
            boundary.clampedPoints, surface.points.size(), double(c.lowest), double(thickness), 100 * c.curvature,
            100 * c.thinParts, 100 * c.turned, 100 * c.beside);
        report(messages, Severity::Warning, text);
    }
    return boundary;
}

} // namespace stf
