// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shell_glow.h"

#include "stfLib/render/surfel.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {

constexpr std::size_t kClusterFacets = 32;
constexpr std::size_t kMostFacets = 2'000'000; // of all shells; those beyond are found by bounces alone

bool shinesEvenly(const PreparedInstance& i) {
    const ShellObject* const shell = i.mesh->shell.get();
    return shell && !i.exitant.empty() && i.motion.empty() && !shell->medium->hasSurface() &&
           shell->grid->report().rimEdges == 0;
}

} // namespace

ShellGlow::ShellGlow(const std::vector<PreparedInstance>& instances) {
    std::vector<TreeLight> lights;
    for (const PreparedInstance& i : instances) {
        if (shinesEvenly(i) && facets_.size() + i.mesh->surface->triangles.size() <= kMostFacets) {
            addInstance(i, lights);
        }
    }
    tree_ = LightTree(std::move(lights));
}

void ShellGlow::addInstance(const PreparedInstance& instance, std::vector<TreeLight>& lights) {
    const RefinedSurface& s = *instance.mesh->surface;
    const std::size_t first = facets_.size();
    const bool mirrored = instance.objectToWorld.determinant() < 0;
    for (std::uint32_t t = 0; t < s.triangles.size(); ++t) {
        const auto corner = [&](int c) {
            return instance.objectToWorld.point(Vec3d(s.points[std::size_t(s.triangles[t][c])]));
        };
        const Vec3d a = corner(0), x = corner(1) - a, y = corner(2) - a, across = cross(x, y);
        const float power = float(length(across)) * average(exitantAt(instance, t, 1.0f / 3, 1.0f / 3));
        if (power > 0 && std::isfinite(power)) {
            facets_.push_back({Vec3f(a), Vec3f(x), Vec3f(y), Vec3f(mirrored ? -across : across), t, power, 0, 0});
        }
    }
    // Halves along the longest side, until they are small.
    const auto middle = [](const Facet& f, int axis) { return f.corner[axis] + (f.x[axis] + f.y[axis]) / 3; };
    std::vector<std::pair<std::size_t, std::size_t>> open{{first, facets_.size()}};
    while (!open.empty()) {
        const auto [begin, end] = open.back();
        open.pop_back();
        if (end - begin <= kClusterFacets) {
            addCluster(instance, begin, end, lights);
            continue;
        }
        Box3f box;
        for (std::size_t i = begin; i < end; ++i) {
            box.add({middle(facets_[i], 0), middle(facets_[i], 1), middle(facets_[i], 2)});
        }
        const Vec3f size = box.hi - box.lo;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const std::size_t half = begin + (end - begin) / 2;
        const auto at = [&](std::size_t i) { return facets_.begin() + std::ptrdiff_t(i); };
        std::nth_element(at(begin), at(half), at(end), [&](const Facet& a, const Facet& b) {
            const float x = middle(a, axis), y = middle(b, axis);
            return x != y ? x < y : a.triangle < b.triangle;
        });
        open.push_back({begin, half});
        open.push_back({half, end});
    }
    std::vector<std::uint32_t>& facetOf = parts_[instance.index];
    facetOf.assign(s.triangles.size(), kDark);
    for (std::size_t i = first; i < facets_.size(); ++i) {
        facetOf[facets_[i].triangle] = std::uint32_t(i);
    }
}

void ShellGlow::addCluster(const PreparedInstance& instance, std::size_t begin, std::size_t end,
                           std::vector<TreeLight>& lights) {
    if (begin == end) {
        return;
    }
    TreeLight light;
    light.index = clusters_.size();
    for (std::size_t i = begin; i < end; ++i) {
        const Facet& f = facets_[i];
        light.power += f.chance; // its power until now
        light.bounds.add(f.corner);
        light.bounds.add(f.corner + f.x);
        light.bounds.add(f.corner + f.y);
    }
    float sum = 0;
    for (std::size_t i = begin; i < end; ++i) {
        Facet& f = facets_[i];
        f.chance /= light.power;
        f.upTo = sum += f.chance;
        f.cluster = std::uint32_t(clusters_.size());
    }
    clusters_.push_back({&instance, std::uint32_t(begin), std::uint32_t(end)});
    lights.push_back(light);
}

LightSample ShellGlow::sample(const Vec3f& point, const Vec3f& normal, float pick, Vec2f u) const {
    LightSample s;
    const LightTree::Choice choice = tree_.choose(point, normal, pick);
    if (!(choice.chance > 0)) {
        return s;
    }
    const Cluster& c = clusters_[choice.index];
    std::uint32_t i = c.begin;
    while (i + 1 < c.end && facets_[i].upTo <= u.x) {
        ++i;
    }
    const Facet& f = facets_[i];
    // What is left of the number is as good as a new one.
    const float root = std::sqrt(std::clamp((u.x - (f.upTo - f.chance)) / f.chance, 0.0f, 1.0f));
    const float v = root * u.y, w = root * (1 - u.y); // of the third and the second corner
    const Vec3f to = f.corner - point + f.x * w + f.y * v;
    const float square = dot(to, to), facing = -dot(to, f.outward);
    if (!(square > 0) || !(facing > 0)) {
        return s; // its back
    }
    s.distance = std::sqrt(square);
    s.towards = to / s.distance;
    const float solidAngle = 0.5f * facing / (square * s.distance);
    s.density = choice.chance * f.chance / solidAngle;
    s.irradiance = exitantAt(*c.instance, f.triangle, w, v) / s.density;
    s.onMesh = true;
    s.point = point + to;
    return s;
}

float ShellGlow::density(std::uint32_t instance, const RayHit& hit, const Vec3f& direction, const Vec3f& point,
                         const Vec3f& normal) const {
    const auto it = parts_.find(instance);
    if (it == parts_.end() || it->second[hit.triangle] == kDark) {
        return 0;
    }
    const Facet& f = facets_[it->second[hit.triangle]];
    const float solidAngle = 0.5f * std::abs(dot(direction, f.outward)) / (hit.t * hit.t);
    return solidAngle > 0 ? tree_.chance(point, normal, f.cluster) * f.chance / solidAngle : 0.0f;
}

} // namespace stf
