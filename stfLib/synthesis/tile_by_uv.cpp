// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/exemplar_map.h"

#include <cstdint>
#include <cstdio>
#include <unordered_map>

namespace stf {

namespace {

/// How the texture coordinates of one triangle relate to the surface. All in object units.
struct UvFrame {
    double area = 0;
    double uvArea = 0;  ///< twice the signed area in uv
    Vec3d normal;       ///< unit normal of the facet
    Vec3d dPdu, dPdv;   ///< zero where the uv triangle is degenerate
    Vec3d gradU, gradV; ///< in the facet's plane; zero where degenerate
    bool degenerate = true;
};

Vec3d pointOf(const RefinedSurface& surface, std::size_t t, int c) {
    return Vec3d(surface.points[std::size_t(surface.triangles[t][c])]);
}

Vec2d uvOf(const RefinedSurface& surface, std::size_t t, int c) {
    const Vec2f uv = surface.uvs[std::size_t(surface.uvTriangles[t][c])];
    return {double(uv.x), double(uv.y)};
}

std::vector<UvFrame> uvFrames(const RefinedSurface& surface) {
    std::vector<UvFrame> frames(surface.triangles.size());
    double area = 0, uvArea = 0;
    for (std::size_t t = 0; t < frames.size(); ++t) {
        UvFrame& f = frames[t];
        const Vec3d e1 = pointOf(surface, t, 1) - pointOf(surface, t, 0);
        const Vec3d e2 = pointOf(surface, t, 2) - pointOf(surface, t, 0);
        const Vec2d d1 = uvOf(surface, t, 1) - uvOf(surface, t, 0), d2 = uvOf(surface, t, 2) - uvOf(surface, t, 0);
        const Vec3d n = cross(e1, e2);
        f.area = 0.5 * length(n);
        f.normal = normalize(n);
        f.uvArea = d1.x * d2.y - d1.y * d2.x;
        f.dPdu = e1 * d2.y - e2 * d1.y;
        f.dPdv = e2 * d1.x - e1 * d2.x;
        // Dual of the edges within the plane: gradients of the barycentric coordinates.
        const double nn = dot(n, n);
        if (nn > 0) {
            const Vec3d b1 = cross(e2, n) / nn, b2 = cross(n, e1) / nn;
            f.gradU = b1 * d1.x + b2 * d2.x;
            f.gradV = b1 * d1.y + b2 * d2.y;
        }
        area += f.area;
        uvArea += std::abs(f.uvArea);
    }
    const double density = area > 0 ? uvArea / area : 0;
    for (UvFrame& f : frames) {
        // Far below the usual density uv say nothing about directions: collapsed or unassigned coordinates.
        f.degenerate = !(f.area > 0 && std::abs(f.uvArea) > 1e-6 * density * f.area);
        if (f.degenerate) {
            f.gradU = f.gradV = f.dPdu = f.dPdv = {};
        } else {
            f.dPdu = f.dPdu / f.uvArea;
            f.dPdv = f.dPdv / f.uvArea;
        }
    }
    return frames;
}

/// Along which axes a seam joins coordinates that differ by a whole number, as where a turn closes. Points are compared
/// by position, since modellers also cut meshes open at the seam.
void findClosedTurns(const RefinedSurface& surface, bool closed[2]) {
    struct Key {
        std::int64_t x, y, z;
        bool operator==(const Key& k) const { return x == k.x && y == k.y && z == k.z; }
    };
    struct Hash {
        std::size_t operator()(const Key& k) const {
            return std::size_t(k.x) * 73856093u ^ std::size_t(k.y) * 19349663u ^ std::size_t(k.z) * 83492791u;
        }
    };
    const double cell = std::max(1e-30, 1e-6 * double(surface.bounds.diagonal()));
    std::unordered_map<Key, std::vector<int>, Hash> uvsAt;
    std::vector<char> seen(surface.uvs.size(), 0);
    uvsAt.reserve(surface.points.size());
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c) {
            const int uv = surface.uvTriangles[t][c];
            if (seen[std::size_t(uv)]) {
                continue;
            }
            seen[std::size_t(uv)] = 1;
            const Vec3d p = (pointOf(surface, t, c) - Vec3d(surface.bounds.lo)) / cell;
            uvsAt[{std::llround(p.x), std::llround(p.y), std::llround(p.z)}].push_back(uv);
        }
    }
    // A turn needs an edge, that is two points; one may be chance.
    int found[2] = {0, 0};
    for (const auto& [key, uvs] : uvsAt) {
        bool here[2] = {false, false};
        for (std::size_t i = 0; i < uvs.size() && i < 16; ++i) {
            for (std::size_t k = 0; k < i; ++k) {
                const Vec2f d = surface.uvs[std::size_t(uvs[i])] - surface.uvs[std::size_t(uvs[k])];
                const double du = std::abs(double(d.x)), dv = std::abs(double(d.y));
                const auto whole = [](double x) { return std::abs(x - std::round(x)) < 1e-3; };
                if (whole(du) && whole(dv)) {
                    here[0] = here[0] || std::round(du) >= 1;
                    here[1] = here[1] || std::round(dv) >= 1;
                }
            }
        }
        found[0] += here[0];
        found[1] += here[1];
    }
    closed[0] = found[0] >= 2;
    closed[1] = found[1] >= 2;
}

/// Tile millimetres per unit of u and v.
Vec2d uvScale(const RefinedSurface& surface, const std::vector<UvFrame>& frames, const Vec2d& tileMm, double unitsPerMm,
              std::string& description) {
    double area = 0, lengthU = 0, lengthV = 0;
    for (const UvFrame& f : frames) {
        if (!f.degenerate) {
            area += f.area;
            lengthU += f.area * length(f.dPdu);
            lengthV += f.area * length(f.dPdv);
        }
    }
    if (!(area > 0)) {
        throw Error("the texture coordinates have no area");
    }
    double scale[2] = {lengthU / area / unitsPerMm, lengthV / area / unitsPerMm};
    const double tile[2] = {tileMm.x, tileMm.y};
    bool closed[2];
    findClosedTurns(surface, closed);
    char text[160];
    for (int axis = 0; axis < 2; ++axis) {
        const double tiles = scale[axis] / tile[axis];
        const char name = axis == 0 ? 'u' : 'v';
        if (closed[axis]) {
            const double whole = std::max(1.0, std::round(tiles));
            std::snprintf(text, sizeof text, "; %c closes: %.0f tiles per unit of %c, stretched %+.1f %%", name, whole,
                          name, (tiles / whole - 1) * 100);
            scale[axis] = whole * tile[axis];
        } else {
            std::snprintf(text, sizeof text, "; %.4g tiles per unit of %c", tiles, name);
        }
        description += text;
    }
    return {scale[0], scale[1]};
}

/// Gradients at the corners, smooth over triangles that share a uv vertex and are not mirrored to one another: across a
/// mirror line the mean would cancel.
class SmoothGradients {
public:
    SmoothGradients(const RefinedSurface& surface, const std::vector<UvFrame>& frames)
        : surface_(surface), frames_(frames) {
        for (std::vector<Sum>& side : sums_) {
            side.resize(surface.uvs.size());
        }
        for (std::size_t t = 0; t < frames.size(); ++t) {
            const UvFrame& f = frames[t];
            if (!f.degenerate) {
                for (int c = 0; c < 3; ++c) {
                    sums_[f.uvArea < 0][std::size_t(surface.uvTriangles[t][c])].add({f.gradU, f.gradV, f.area});
                }
            }
        }
    }

    /// False where neither the triangle nor its neighbours know a direction.
    bool at(std::size_t t, int c, Vec3d& gradU, Vec3d& gradV) const {
        const Vec3i& uv = surface_.uvTriangles[t];
        Sum sum = sums_[frames_[t].uvArea < 0][std::size_t(uv[c])];
        if (frames_[t].degenerate) {
            sum = larger(std::size_t(uv[c]));
        }
        // A corner that belongs to collapsed triangles only takes what the other corners say.
        for (int k = 0; k < 3 && !(sum.area > 0); ++k) {
            sum = larger(std::size_t(uv[k]));
        }
        gradU = sum.gradU / sum.area;
        gradV = sum.gradV / sum.area;
        return sum.area > 0;
    }

private:
    /// Gradients times area, and area.
    struct Sum {
        Vec3d gradU, gradV;
        double area = 0;
        void add(const Sum& s) {
            gradU += s.gradU * s.area;
            gradV += s.gradV * s.area;
            area += s.area;
        }
    };
    const Sum& larger(std::size_t uv) const { return sums_[sums_[1][uv].area > sums_[0][uv].area][uv]; }

    const RefinedSurface& surface_;
    const std::vector<UvFrame>& frames_;
    std::vector<Sum> sums_[2]; ///< per uv vertex; the second of mirrored triangles
};

Vec3d tangential(const Vec3d& v, const Vec3d& normal) {
    return v - normal * dot(v, normal);
}

} // namespace

ExemplarMap tileByUv(const RefinedSurface& surface, const Vec2d& tileMm, double unitsPerMm,
                     const MessageSink& messages) {
    if (surface.uvs.empty() || surface.uvTriangles.size() != surface.triangles.size()) {
        throw Error("the mesh has no texture coordinates");
    }
    if (!(tileMm.x > 0 && tileMm.y > 0 && std::isfinite(tileMm.x) && std::isfinite(tileMm.y))) {
        throw Error("the tile has no size");
    }
    if (!(unitsPerMm > 0 && std::isfinite(unitsPerMm))) {
        throw Error("the scale of the tile is not positive");
    }
    const std::vector<UvFrame> frames = uvFrames(surface);
    ExemplarMap map;
    map.tileMm = tileMm;
    map.description = "tiled by texture coordinates";
    const Vec2d scale = uvScale(surface, frames, tileMm, unitsPerMm, map.description);

    const SmoothGradients gradients(surface, frames);
    const std::size_t corners = 3 * surface.triangles.size();
    map.cornerCoords.resize(corners);
    map.gradientX.resize(corners);
    map.gradientY.resize(corners);
    std::size_t collapsed = 0;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        collapsed += frames[t].degenerate;
        Vec2d mm[3];
        for (int c = 0; c < 3; ++c) {
            const Vec2d uv = uvOf(surface, t, c);
            mm[c] = {uv.x * scale.x, uv.y * scale.y};
        }
        // Whole tiles are taken off per triangle: float then keeps its digits for the place within the tile.
        const Vec2d origin{std::floor(mm[0].x / tileMm.x) * tileMm.x, std::floor(mm[0].y / tileMm.y) * tileMm.y};
        for (int c = 0; c < 3; ++c) {
            const std::size_t i = 3 * t + std::size_t(c);
            map.cornerCoords[i] = {float(mm[c].x - origin.x), float(mm[c].y - origin.y)};
            const Vec3d n(surface.normals[std::size_t(surface.triangles[t][c])]);
            Vec3d gradU, gradV;
            if (gradients.at(t, c, gradU, gradV)) {
                map.gradientX[i] = Vec3f(tangential(gradU * scale.x, n));
                map.gradientY[i] = Vec3f(tangential(gradV * scale.y, n));
            }
            if (!(dot(map.gradientX[i], map.gradientX[i]) > 0) || !(dot(map.gradientY[i], map.gradientY[i]) > 0)) {
                // Any frame at the wanted scale: there is no direction to keep.
                Vec3d x, y;
                orthonormalBasis(n, x, y);
                map.gradientX[i] = Vec3f(x / unitsPerMm);
                map.gradientY[i] = Vec3f(y / unitsPerMm);
            }
        }
    }
    if (collapsed) {
        const std::string text = std::to_string(collapsed) + " of " + std::to_string(surface.triangles.size()) +
                                 " triangles have collapsed texture coordinates: the sample is smeared there";
        report(messages, Severity::Warning, text);
        map.description += "; " + std::to_string(collapsed) + " triangles with collapsed uv";
    }
    return map;
}

} // namespace stf
