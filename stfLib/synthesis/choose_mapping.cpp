// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/choose_mapping.h"

#include "stfLib/synthesis/stochastic_sample.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace stf {

namespace {

constexpr double kUnusableShare = 0.05; ///< of the surface
constexpr double kLargestAspect = 8;    ///< longer stretch of a texel over the shorter
constexpr double kLargestSpread = 30;   ///< texel's area against the median, either way

/// Why texture coordinates cannot be used; empty where they can.
std::string flawOfUvs(const RefinedSurface& s) {
    if (s.uvs.empty() || s.uvTriangles.size() != s.triangles.size()) {
        return "no texture coordinates";
    }
    struct Texel {
        double density, aspect, area;
    };
    std::vector<Texel> texels;
    double total = 0, collapsed = 0;
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        const auto point = [&](int c) { return Vec3d(s.points[std::size_t(s.triangles[t][c])]); };
        const auto uv = [&](int c) { return s.uvs[std::size_t(s.uvTriangles[t][c])]; };
        const Vec3d e1 = point(1) - point(0), e2 = point(2) - point(0), n = cross(e1, e2);
        const double area = 0.5 * length(n);
        if (!(area > 0)) {
            continue;
        }
        total += area;
        const Vec2f d1 = uv(1) - uv(0), d2 = uv(2) - uv(0);
        // Gradient of uv in the triangle's plane, and its singular values.
        const Vec3d x = normalize(e1), y = cross(normalize(n), x);
        const double a = length(e1), b = dot(e2, x), c = dot(e2, y);
        const double ux = double(d1.x) / a, vx = double(d1.y) / a;
        const double uy = (double(d2.x) - ux * b) / c, vy = (double(d2.y) - vx * b) / c;
        const double p = std::hypot(ux + vy, vx - uy) / 2, q = std::hypot(ux - vy, vx + uy) / 2;
        const double hi = p + q, lo = std::abs(p - q);
        if (!(lo > 1e-6 * hi) || !std::isfinite(hi)) {
            collapsed += area;
        } else {
            texels.push_back({hi * lo, hi / lo, area});
        }
    }
    char text[160];
    if (texels.empty()) {
        return "texture coordinates without area";
    }
    if (collapsed > kUnusableShare * total) {
        std::snprintf(text, sizeof text, "texture coordinates collapsed on %.0f %% of the surface",
                      100 * collapsed / total);
        return text;
    }
    // The median density by area.
    std::sort(texels.begin(), texels.end(), [](const Texel& a, const Texel& b) { return a.density < b.density; });
    double below = 0, median = texels.back().density;
    for (const Texel& t : texels) {
        below += t.area;
        if (below >= 0.5 * (total - collapsed)) {
            median = t.density;
            break;
        }
    }
    double aspect = 0, spread = 0;
    for (const Texel& t : texels) {
        aspect += t.aspect > kLargestAspect ? t.area : 0;
        spread += t.density > kLargestSpread * median || t.density * kLargestSpread < median ? t.area : 0;
    }
    if (aspect > kUnusableShare * total || spread > kUnusableShare * total) {
        std::snprintf(text, sizeof text, "texture coordinates stretched more than %.0f-fold on %.0f %% of the surface",
                      kLargestAspect, 100 * std::max(aspect, spread) / total);
        return text;
    }
    return "";
}

} // namespace

MappingChoice chooseMapping(const std::string& mapping, const RefinedSurface& surface, const BaseVolume& volume) {
    const bool uniform = volume.laterallyUniform();
    if (mapping == "uv") {
        return {Mapping::Uv, "mapping is uv"};
    }
    if (mapping == "synthesize" && !uniform) {
        return {Mapping::Synthesize, "mapping is synthesize"};
    }
    if (mapping == "blend" && !uniform) {
        return volume.hasRelief()
                   ? MappingChoice{Mapping::Synthesize, "mapping is blend, but a relief cannot be blended"}
               : !volume.emission.empty()
                   ? MappingChoice{Mapping::Synthesize, "mapping is blend, but emission cannot be blended"}
                   : MappingChoice{Mapping::Blend, "mapping is blend"};
    }
    const std::string flaw = flawOfUvs(surface);
    if (mapping != "synthesize" && mapping != "blend" && flaw.empty()) {
        return {Mapping::Uv, "mapping is auto and texture coordinates are usable"};
    }
    if (uniform) {
        return {Mapping::Anywhere, "the sample is the same everywhere"};
    }
    const Randomness sample = judgeRandomness(volume);
    return {sample.stochastic ? Mapping::Blend : Mapping::Synthesize,
            "mapping is auto, there are " + flaw + ", and of the sample " + sample.why};
}

ExemplarMap mapAnywhere(const RefinedSurface& surface, const Vec2d& tileMm, double unitsPerMm) {
    if (!(unitsPerMm > 0 && std::isfinite(unitsPerMm))) {
        throw Error("the scale of the tile is not positive");
    }
    ExemplarMap map;
    map.tileMm = tileMm;
    map.description = "any place of the sample, it is the same everywhere";
    const double mmPerUnit = 1 / unitsPerMm;
    for (const Vec3i& t : surface.triangles) {
        const Vec3d p(surface.points[std::size_t(t.x)]);
        const Vec3d e1 = Vec3d(surface.points[std::size_t(t.y)]) - p, e2 = Vec3d(surface.points[std::size_t(t.z)]) - p;
        Vec3d n = normalize(cross(e1, e2));
        n = dot(n, n) > 0.5 ? n : Vec3d(surface.normals[std::size_t(t.x)]);
        Vec3d x, y;
        orthonormalBasis(n, x, y);
        for (int c = 0; c < 3; ++c) {
            const Vec3d d = Vec3d(surface.points[std::size_t(t[c])]) - p;
            map.cornerCoords.push_back({float(dot(d, x) * mmPerUnit), float(dot(d, y) * mmPerUnit)});
            map.gradientX.push_back(Vec3f(x * mmPerUnit));
            map.gradientY.push_back(Vec3f(y * mmPerUnit));
        }
    }
    return map;
}

} // namespace stf
