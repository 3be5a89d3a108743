// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/surface/refine_parts.h"

#include <algorithm>
#include <cstdint>
#include <unordered_map>

namespace stf {

namespace {

constexpr std::size_t kTogether = 4096; // faces, corners

/// Normal of a whole polygon (Newell); zero where degenerate.
Vec3d polygonNormal(const std::vector<Vec3d>& corners) {
    Vec3d sum;
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        sum += cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
    }
    return normalize(sum);
}

/// The faces of a mesh, each with where its face vertices and its triangles begin: two triangles fewer than corners,
/// holes have none.
class Faces {
public:
    struct Scratch {
        std::vector<Vec3d> corners;
        std::vector<Vec3i> triangles;
    };

    explicit Faces(const ControlMesh& mesh) : mesh_(mesh), hole_(mesh.holeIndices.empty() ? 0 : count(), 0) {
        for (int f : mesh.holeIndices) {
            hole_[std::size_t(f)] = 1;
        }
        for (std::size_t f = 0, vertex = 0; f < count(); ++f) {
            if (f % kTogether == 0) {
                starts_.push_back({vertex, triangles_});
            }
            vertex += cornersOf(f);
            triangles_ += trianglesOf(f);
        }
    }

    std::size_t count() const { return mesh_.faceVertexCounts.size(); }
    std::size_t triangles() const { return triangles_; }
    std::size_t trianglesOf(std::size_t f) const {
        return !hole_.empty() && hole_[f] ? 0 : cornersOf(f) - 2;
    } // 3 at least

    /// body(face, its first face vertex, its first triangle, scratch) on all threads; scratch has the corners' places.
    template<class Body>
    void forEach(const std::vector<Vec3f>& points, const Body& body) const {
        parallelFor(count(), kTogether, [&](std::size_t begin, std::size_t end) {
            Start at = starts_[begin / kTogether];
            Scratch scratch;
            for (std::size_t f = begin; f < end; ++f) {
                scratch.corners.clear();
                for (std::size_t i = at.vertex; i < at.vertex + cornersOf(f); ++i) {
                    scratch.corners.emplace_back(points[std::size_t(mesh_.faceVertexIndices[i])]);
                }
                body(f, at.vertex, at.triangle, scratch);
                at.vertex += cornersOf(f);
                at.triangle += trianglesOf(f);
            }
        });
    }

private:
    struct Start {
        std::size_t vertex, triangle;
    };
    std::size_t cornersOf(std::size_t f) const { return std::size_t(mesh_.faceVertexCounts[f]); }

    const ControlMesh& mesh_;
    std::vector<char> hole_;    // empty: none is
    std::vector<Start> starts_; // of every kTogether faces
    std::size_t triangles_ = 0;
};

/// Triangulates all faces but holes; `faceVertices`, where given, gets the face vertex of each corner, 3 per triangle.
void triangulate(const ControlMesh& mesh, const Faces& faces, RefinedSurface& surface,
                 std::vector<std::size_t>* faceVertices) {
    std::vector<int> uvIndices;
    if (!mesh.uvIndices.empty()) {
        weldUvs(mesh, surface.uvs, uvIndices);
    }
    surface.triangles.resize(faces.triangles());
    surface.triangleFace.resize(faces.triangles());
    surface.uvTriangles.resize(uvIndices.empty() ? 0 : faces.triangles());
    if (faceVertices) {
        faceVertices->resize(3 * faces.triangles());
    }
    faces.forEach(mesh.points, [&](std::size_t f, std::size_t vertex, std::size_t triangle, Faces::Scratch& scratch) {
        if (faces.trianglesOf(f) == 0) {
            return;
        }
        scratch.triangles.clear();
        triangulateFace(scratch.corners, scratch.triangles);
        for (const Vec3i& t : scratch.triangles) {
            const auto pick = [&](const std::vector<int>& from) {
                return Vec3i(from[vertex + std::size_t(t.x)], from[vertex + std::size_t(t.y)],
                             from[vertex + std::size_t(t.z)]);
            };
            surface.triangles[triangle] = pick(mesh.faceVertexIndices);
            surface.triangleFace[triangle] = int(f);
            if (!uvIndices.empty()) {
                surface.uvTriangles[triangle] = pick(uvIndices);
            }
            for (int c = 0; faceVertices && c < 3; ++c) {
                (*faceVertices)[3 * triangle + std::size_t(c)] = vertex + std::size_t(t[c]);
            }
            ++triangle;
        }
    });
}

/// Normal of each face for the mesh's points being at `points`; zero where it is degenerate.
std::vector<Vec3f> normalsOfFaces(const Faces& faces, const std::vector<Vec3f>& points) {
    std::vector<Vec3f> normals(faces.count());
    faces.forEach(points, [&](std::size_t f, std::size_t, std::size_t, const Faces::Scratch& scratch) {
        normals[f] = Vec3f(polygonNormal(scratch.corners));
    });
    return normals;
}

/// Normals of the triangles' corners: authored ones, where they are of the pose that the facets are in, else the
/// facets'.
std::vector<Vec3f> normalsOfCorners(const ControlMesh& mesh, const std::vector<Vec3f>& facets, bool authored,
                                    const std::vector<std::size_t>& faceVertices, const std::vector<int>& faces) {
    using Interpolation = ControlMesh::Interpolation;
    std::vector<Vec3f> normals(faceVertices.size());
    parallelFor(faceVertices.size(), kTogether, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t f = std::size_t(faces[i / 3]), corner = faceVertices[i];
            Vec3f n;
            if (authored && !mesh.normals.empty()) {
                const std::size_t which = mesh.normalInterpolation == Interpolation::Constant  ? 0
                                          : mesh.normalInterpolation == Interpolation::Uniform ? f
                                          : mesh.normalInterpolation == Interpolation::Vertex
                                              ? std::size_t(mesh.faceVertexIndices[corner])
                                              : corner;
                n = normalize(mesh.normals[which]);
            }
            // Authored normals that look away from their face are errors of export.
            normals[i] = dot(n, facets[f]) > 0.05f ? n : facets[f];
        }
    });
    return normals;
}

/// One direction per point, which the shell needs: the mean of its corners', which for smooth authored normals is just
/// those. Points that nothing gives a direction to (folded sheets) still get one.
std::vector<Vec3f> normalsOfPoints(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles,
                                   const std::vector<Vec3f>& cornerNormals) {
    std::vector<Vec3f> normals = angleWeightedNormals(points, triangles, cornerNormals);
    for (std::size_t i = 0; i < cornerNormals.size(); ++i) {
        Vec3f& n = normals[std::size_t(triangles[i / 3][int(i % 3)])];
        if (!(dot(n, n) > 0.5f)) {
            n = cornerNormals[i];
        }
        if (!(dot(n, n) > 0.5f)) {
            n = {0, 0, 1};
        }
    }
    return normals;
}

/// Whether the corners' normals say no more than the points'.
bool smooth(const std::vector<Vec3i>& triangles, const std::vector<Vec3f>& cornerNormals,
            const std::vector<Vec3f>& normals) {
    for (std::size_t i = 0; i < cornerNormals.size(); ++i) {
        if (!(dot(cornerNormals[i], normals[std::size_t(triangles[i / 3][int(i % 3)])]) > 0.9999f)) {
            return false;
        }
    }
    return true;
}

/// Numbers the midpoints of edges; a midpoint is shared by all triangles at its edge, so that no crack can open.
class Midpoints {
public:
    explicit Midpoints(std::size_t expected) { numbers_.reserve(expected); }

    /// Calls `make(a, b)` for a new edge, which has to append its midpoint to whatever is numbered.
    template<class Make>
    int get(int a, int b, int next, const Make& make) {
        const std::uint64_t key = std::uint64_t(std::min(a, b)) << 32 | std::uint32_t(std::max(a, b));
        const auto [it, added] = numbers_.try_emplace(key, next);
        if (added) {
            make(std::size_t(a), std::size_t(b));
        }
        return it->second;
    }

private:
    std::unordered_map<std::uint64_t, int> numbers_;
};

void appendQuarters(const Vec3i& t, const Vec3i& m, std::vector<Vec3i>& out) {
    out.push_back({t.x, m.x, m.z});
    out.push_back({m.x, t.y, m.y});
    out.push_back({m.z, m.y, t.z});
    out.push_back({m.x, m.y, m.z});
}

/// Corner normals of the four triangles that replace each.
std::vector<Vec3f> splitCornerNormals(const std::vector<Vec3f>& normals) {
    std::vector<Vec3f> out;
    out.reserve(4 * normals.size());
    for (std::size_t i = 0; i < normals.size(); i += 3) {
        const Vec3f* n = &normals[i];
        const Vec3f a = normalize(n[0] + n[1]), b = normalize(n[1] + n[2]), c = normalize(n[2] + n[0]);
        out.insert(out.end(), {n[0], a, c, a, n[1], b, c, b, n[2], a, b, c});
    }
    return out;
}

/// Replaces every triangle by four.
void split(RefinedSurface& s, SurfacePose* pose) {
    const std::size_t count = s.triangles.size();
    Midpoints pointMids(count * 3 / 2), uvMids(s.uvs.empty() ? 0 : count * 3 / 2);
    const auto makePoint = [&](std::size_t a, std::size_t b) {
        const auto halve = [&](std::vector<Vec3f>& points, std::vector<Vec3f>& normals) {
            points.push_back((points[a] + points[b]) * 0.5f);
            const Vec3f n = normals[a] + normals[b];
            normals.push_back(length(n) > 1e-3f ? normalize(n) : normals[a]);
        };
        halve(s.points, s.normals);
        if (pose) {
            halve(pose->points, pose->normals);
        }
        if (!s.colors.empty()) {
            s.colors.push_back((s.colors[a] + s.colors[b]) * 0.5f);
        }
        if (!s.orientation.empty()) {
            s.orientation.push_back((s.orientation[a] + s.orientation[b]) * 0.5f);
        }
    };
    const auto makeUv = [&](std::size_t a, std::size_t b) { s.uvs.push_back((s.uvs[a] + s.uvs[b]) * 0.5f); };

    std::vector<Vec3i> triangles, uvTriangles;
    std::vector<int> faces;
    triangles.reserve(4 * count);
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3i t = s.triangles[i];
        Vec3i m;
        for (int c = 0; c < 3; ++c) {
            m[c] = pointMids.get(t[c], t[(c + 1) % 3], int(s.points.size()), makePoint);
        }
        appendQuarters(t, m, triangles);
        faces.insert(faces.end(), 4, s.triangleFace[i]);
        if (!s.uvTriangles.empty()) {
            const Vec3i u = s.uvTriangles[i];
            for (int c = 0; c < 3; ++c) {
                m[c] = uvMids.get(u[c], u[(c + 1) % 3], int(s.uvs.size()), makeUv);
            }
            appendQuarters(u, m, uvTriangles);
        }
    }
    s.triangles.swap(triangles);
    s.uvTriangles.swap(uvTriangles);
    s.cornerNormals = splitCornerNormals(s.cornerNormals);
    if (pose) {
        pose->cornerNormals = splitCornerNormals(pose->cornerNormals);
    }
    s.triangleFace.swap(faces);
}

int splitLevels(const RefinedSurface& surface, const RefineOptions& options, const MessageSink& messages) {
    if (!(options.targetEdge > 0)) {
        return 0;
    }
    std::vector<double> longest;
    longest.reserve(surface.triangles.size());
    for (const Vec3i& t : surface.triangles) {
        double edge = 0;
        for (int c = 0; c < 3; ++c) {
            edge = std::max(edge, length(Vec3d(surface.points[std::size_t(t[(c + 1) % 3])]) -
                                         Vec3d(surface.points[std::size_t(t[c])])));
        }
        longest.push_back(edge);
    }
    const double typical = typicalLargest(longest);
    int level = 0;
    while (level < options.maxLevel && typical / double(1u << level) > double(options.targetEdge)) {
        ++level;
    }
    const int wanted = level;
    while (level > 0 && (surface.triangles.size() << (2 * level)) > options.maxTriangles) {
        --level;
    }
    if (level < wanted) {
        report(messages, Severity::Warning,
               "the mesh is split " + std::to_string(level) + " instead of " + std::to_string(wanted) +
                   " times to stay below " + std::to_string(options.maxTriangles) + " triangles");
    }
    return level;
}

} // namespace

RefinedSurface refinePolygons(const ControlMesh& mesh, const RefineOptions& options, const MessageSink& messages,
                              SurfacePose* pose) {
    RefinedSurface surface;
    surface.points = mesh.points;
    surface.colors = controlPointValues(mesh, mesh.colors, mesh.colorInterpolation);
    surface.orientation = controlPointValues(mesh, mesh.orientation, mesh.orientationInterpolation);
    const Faces faces(mesh);
    if (!options.pointNormals && !pose && mesh.normals.empty() && !(options.targetEdge > 0)) {
        triangulate(mesh, faces, surface, nullptr);
        surface.faceNormals = normalsOfFaces(faces, mesh.points);
        normalizeOrientation(surface.orientation);
        return surface;
    }
    std::vector<std::size_t> faceVertices;
    triangulate(mesh, faces, surface, &faceVertices);
    const auto shade = [&](const std::vector<Vec3f>& points, bool authored, std::vector<Vec3f>& normals,
                           std::vector<Vec3f>& cornerNormals) {
        cornerNormals =
            normalsOfCorners(mesh, normalsOfFaces(faces, points), authored, faceVertices, surface.triangleFace);
        normals = normalsOfPoints(points, surface.triangles, cornerNormals);
        if (smooth(surface.triangles, cornerNormals, normals)) {
            cornerNormals.clear();
        }
    };
    // Authored normals are those of the pose in which the mesh is given.
    shade(surface.points, !pose, surface.normals, surface.cornerNormals);
    if (pose) {
        shade(pose->points, true, pose->normals, pose->cornerNormals);
        if (pose->cornerNormals.empty()) {
            surface.cornerNormals.clear(); // what is smooth in one pose is so in the other
        }
    }
    for (int level = splitLevels(surface, options, messages); level > 0; --level) {
        split(surface, pose);
    }
    normalizeOrientation(surface.orientation);
    return surface;
}

} // namespace stf
