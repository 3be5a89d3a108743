// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/split_edges.h"

#include "stfLib/base/parallel.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>

namespace stf {

namespace {

constexpr int maxRounds = 24;

/// Distinct edges of triangles given by three indices.
struct EdgeTable {
    std::vector<Vec3i> ofTriangle; ///< edge c runs from corner c to the next
    std::vector<std::pair<int, int>> ends;

    explicit EdgeTable(const std::vector<Vec3i>& triangles) : ofTriangle(triangles.size()) {
        struct Side {
            std::uint64_t key;
            std::uint32_t triangle;
            std::uint32_t corner;
        };
        // Sides in buckets of their lower end: each bucket holds a handful, so that sorting takes linear time.
        int top = 0;
        for (const Vec3i& t : triangles) {
            top = std::max(top, maxComponent(t));
        }
        std::vector<std::size_t> first(std::size_t(top) + 2, 0);
        const auto lower = [](const Vec3i& t, int c) { return std::size_t(std::min(t[c], t[(c + 1) % 3])); };
        for (const Vec3i& t : triangles) {
            for (int c = 0; c < 3; ++c) {
                ++first[lower(t, c) + 1];
            }
        }
        for (std::size_t i = 1; i < first.size(); ++i) {
            first[i] += first[i - 1];
        }
        std::vector<Side> sides(3 * triangles.size());
        std::vector<std::size_t> next(first.begin(), first.end() - 1);
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            for (int c = 0; c < 3; ++c) {
                const int a = triangles[t][c], b = triangles[t][(c + 1) % 3];
                sides[next[lower(triangles[t], c)]++] = {std::uint64_t(std::max(a, b)), std::uint32_t(t),
                                                         std::uint32_t(c)};
            }
        }
        for (std::size_t v = 0; v + 1 < first.size(); ++v) {
            const auto begin = sides.begin() + std::ptrdiff_t(first[v]),
                       end = sides.begin() + std::ptrdiff_t(first[v + 1]);
            std::sort(begin, end, [](const Side& a, const Side& b) {
                return a.key != b.key             ? a.key < b.key
                       : a.triangle != b.triangle ? a.triangle < b.triangle
                                                  : a.corner < b.corner;
            });
            for (auto s = begin; s != end; ++s) {
                if (s == begin || s->key != (s - 1)->key) {
                    ends.push_back({int(v), int(s->key)});
                }
                ofTriangle[s->triangle][int(s->corner)] = int(ends.size()) - 1;
            }
        }
    }
};

class Splitter {
public:
    Splitter(RefinedSurface& surface, SurfacePose* pose, double maxEdge, std::size_t maxTriangles)
        : s_(surface), pose_(pose), maxEdge_(maxEdge), maxTriangles_(maxTriangles) {}

    /// One round: false where nothing was left to split. Sets `full` where there was no room.
    bool round(bool& full) {
        const EdgeTable edges(s_.triangles);
        std::vector<char> marked(edges.ends.size(), 0);
        std::vector<double> length2(edges.ends.size());
        parallelFor(edges.ends.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
            for (std::size_t e = begin; e < end; ++e) {
                const Vec3d d = at(edges.ends[e].second) - at(edges.ends[e].first);
                length2[e] = dot(d, d);
                marked[e] = length2[e] > maxEdge_ * maxEdge_;
            }
        });
        if (std::find(marked.begin(), marked.end(), 1) == marked.end()) {
            return false;
        }
        // A triangle is first cut across its longest side; the neighbour behind that side is cut with it.
        std::vector<char> longest(s_.triangles.size());
        for (std::size_t t = 0; t < s_.triangles.size(); ++t) {
            const Vec3i& e = edges.ofTriangle[t];
            int c = 0;
            for (int k = 1; k < 3; ++k) {
                const double d = length2[std::size_t(e[k])] - length2[std::size_t(e[c])];
                c = d > 0 || (d == 0 && e[k] < e[c]) ? k : c;
            }
            longest[t] = char(c);
        }
        for (bool grew = true; grew;) {
            grew = false;
            for (std::size_t t = 0; t < s_.triangles.size(); ++t) {
                const Vec3i& e = edges.ofTriangle[t];
                char& l = marked[std::size_t(e[longest[t]])];
                if (!l && (marked[std::size_t(e.x)] || marked[std::size_t(e.y)] || marked[std::size_t(e.z)])) {
                    l = 1;
                    grew = true;
                }
            }
        }
        std::size_t pieces = 0;
        for (const Vec3i& e : edges.ofTriangle) {
            pieces += std::size_t(1 + marked[std::size_t(e.x)] + marked[std::size_t(e.y)] + marked[std::size_t(e.z)]);
        }
        if (pieces > maxTriangles_) {
            full = true;
            return false;
        }
        addMiddles(edges, marked);
        addUvMiddles(edges, marked);
        cut(edges, longest, pieces);
        return true;
    }

private:
    /// A piece of a triangle while it is cut: its corners by point, by uv vertex, and where they lie in the original.
    struct Piece {
        Vec3i point, uv;
        Vec3d weight[3];
    };

    Vec3d at(int i) const { return Vec3d(s_.points[std::size_t(i)]); }

    /// Appends the middle of the points a and b.
    static void addMiddle(std::size_t a, std::size_t b, bool round, std::vector<Vec3f>& points,
                          std::vector<Vec3f>& normals) {
        const Vec3d na(normals[a]), nb(normals[b]), d = Vec3d(points[b]) - Vec3d(points[a]);
        Vec3d p = (Vec3d(points[a]) + Vec3d(points[b])) * 0.5;
        const double wa = dot(d, na), wb = -dot(d, nb);
        // Bends to different sides, or at one end only, are no arc but an inflection or a crease.
        if (round && wa * wb > 0) {
            const double w = std::copysign(std::min(std::abs(wa), std::abs(wb)), wa);
            p -= (na + nb) * (w / 8);
        }
        const Vec3d n = normalize(na + nb);
        points.push_back(Vec3f(p));
        normals.push_back(Vec3f(dot(n, n) > 0.5 ? n : na));
    }

    void addMiddles(const EdgeTable& edges, const std::vector<char>& marked) {
        middle_.assign(edges.ends.size(), -1);
        for (std::size_t e = 0; e < marked.size(); ++e) {
            if (!marked[e]) {
                continue;
            }
            const std::size_t a = std::size_t(edges.ends[e].first), b = std::size_t(edges.ends[e].second);
            middle_[e] = int(s_.points.size());
            addMiddle(a, b, s_.cornerNormals.empty(), s_.points, s_.normals);
            if (pose_) {
                addMiddle(a, b, pose_->cornerNormals.empty(), pose_->points, pose_->normals);
            }
            if (!s_.colors.empty()) {
                s_.colors.push_back((s_.colors[a] + s_.colors[b]) * 0.5f);
            }
            if (!s_.orientation.empty()) {
                s_.orientation.push_back(normalize(s_.orientation[a] + s_.orientation[b]));
            }
            s_.bounds.add(s_.points.back());
        }
    }

    void addUvMiddles(const EdgeTable& edges, const std::vector<char>& marked) {
        if (s_.uvs.empty()) {
            return;
        }
        const EdgeTable uvEdges(s_.uvTriangles);
        uvMiddle_.assign(uvEdges.ends.size(), -1);
        uvOf_ = uvEdges.ofTriangle;
        for (std::size_t t = 0; t < s_.triangles.size(); ++t) {
            for (int c = 0; c < 3; ++c) {
                const std::size_t e = std::size_t(uvEdges.ofTriangle[t][c]);
                if (marked[std::size_t(edges.ofTriangle[t][c])] && uvMiddle_[e] < 0) {
                    uvMiddle_[e] = int(s_.uvs.size());
                    s_.uvs.push_back(
                        (s_.uvs[std::size_t(uvEdges.ends[e].first)] + s_.uvs[std::size_t(uvEdges.ends[e].second)]) *
                        0.5f);
                }
            }
        }
    }

    void cut(const EdgeTable& edges, const std::vector<char>& longest, std::size_t pieces) {
        const bool uv = !s_.uvs.empty();
        std::vector<Vec3i> triangles, uvTriangles;
        std::vector<int> faces;
        std::vector<Vec3f> cornerNormals, posedNormals;
        const auto blendNormals = [](const std::vector<Vec3f>& from, std::size_t t, const Piece& piece,
                                     std::vector<Vec3f>& to) {
            for (int c = 0; c < 3 && !from.empty(); ++c) {
                Vec3d n;
                for (int k = 0; k < 3; ++k) {
                    n += Vec3d(from[3 * t + std::size_t(k)]) * piece.weight[c][k];
                }
                to.push_back(Vec3f(normalize(n)));
            }
        };
        triangles.reserve(pieces);
        faces.reserve(pieces);
        for (std::size_t t = 0; t < s_.triangles.size(); ++t) {
            const Vec3i& e = edges.ofTriangle[t];
            Piece whole{s_.triangles[t], uv ? s_.uvTriangles[t] : Vec3i(), {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
            Piece out[4];
            int count = 0;
            const int l = longest[t];
            if (middle_[std::size_t(e[l])] < 0) {
                out[count++] = whole;
            } else {
                // Across the longest side, then each half across the side it has of the whole.
                const Piece first = half(whole, l, t, e, 0), second = half(whole, l, t, e, 1);
                for (const auto& [piece, side] : {std::pair(first, (l + 2) % 3), std::pair(second, (l + 1) % 3)}) {
                    if (middle_[std::size_t(e[side])] < 0) {
                        out[count++] = piece;
                    } else {
                        out[count++] = half(piece, side, t, e, 0);
                        out[count++] = half(piece, side, t, e, 1);
                    }
                }
            }
            for (int i = 0; i < count; ++i) {
                triangles.push_back(out[i].point);
                faces.push_back(s_.triangleFace.empty() ? 0 : s_.triangleFace[t]);
                if (uv) {
                    uvTriangles.push_back(out[i].uv);
                }
                blendNormals(s_.cornerNormals, t, out[i], cornerNormals);
                if (pose_) {
                    blendNormals(pose_->cornerNormals, t, out[i], posedNormals);
                }
            }
        }
        s_.triangles = std::move(triangles);
        s_.uvTriangles = std::move(uvTriangles);
        s_.triangleFace = std::move(faces);
        s_.cornerNormals = std::move(cornerNormals);
        if (pose_) {
            pose_->cornerNormals = std::move(posedNormals);
        }
    }

    /// The half of `piece` on one side of the line from the middle of side `side` to the opposite corner. Corner
    /// numbers are those of the whole triangle: a half keeps the numbers of the two corners it keeps.
    Piece half(const Piece& piece, int side, std::size_t t, const Vec3i& e, int second) const {
        Piece h = piece;
        const int replaced = second ? side : (side + 1) % 3;
        h.point[replaced] = middle_[std::size_t(e[side])];
        if (!s_.uvs.empty()) {
            h.uv[replaced] = uvMiddle_[std::size_t(uvOf_[t][side])];
        }
        h.weight[replaced] = (piece.weight[side] + piece.weight[(side + 1) % 3]) * 0.5;
        return h;
    }

    RefinedSurface& s_;
    SurfacePose* pose_;
    double maxEdge_;
    std::size_t maxTriangles_;
    std::vector<int> middle_, uvMiddle_; ///< of each edge; -1: not split
    std::vector<Vec3i> uvOf_;
};

} // namespace

RefinedSurface splitLongEdges(RefinedSurface surface, double maxEdge, std::size_t maxTriangles,
                              const MessageSink& messages, SurfacePose* pose) {
    if (!(maxEdge > 0) || !std::isfinite(maxEdge)) {
        throw Error("the wanted edge length is not positive");
    }
    Splitter splitter(surface, pose, maxEdge, maxTriangles);
    bool full = false;
    for (int i = 0; i < maxRounds && splitter.round(full); ++i) {
    }
    if (full) {
        char text[160];
        std::snprintf(
            text, sizeof text,
            "the surface is sampled by %zu triangles; edges of %.3g units would need more than the %zu allowed",
            surface.triangles.size(), maxEdge, maxTriangles);
        report(messages, Severity::Warning, text);
    }
    return surface;
}

} // namespace stf
