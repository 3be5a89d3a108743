// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/control_mesh.h"
#include "stfLib/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <initializer_list>

namespace stf {

namespace {

// Beyond this the square of a length is no float any more.
constexpr float largestCoordinate = 1e18f;

bool usable(const Vec3f& p) {
    return std::abs(p.x) < largestCoordinate && std::abs(p.y) < largestCoordinate && std::abs(p.z) < largestCoordinate;
}

bool usable(Vec2f p) {
    return std::abs(p.x) < largestCoordinate && std::abs(p.y) < largestCoordinate;
}

template<class T, class Index>
void pick(std::vector<T>& values, const std::vector<Index>& which) {
    std::vector<T> kept;
    kept.reserve(which.size());
    for (const Index i : which) {
        kept.push_back(values[std::size_t(i)]);
    }
    values.swap(kept);
}

/// How faces and face vertices of the result follow from the given ones.
struct Selection {
    bool all = false;                 ///< as they are: the lists stay empty
    std::vector<int> faces;           ///< kept faces, by their given number
    std::vector<std::size_t> corners; ///< kept face vertices, by their given place
    std::vector<int> counts;          ///< of the kept faces

    template<class T>
    void keepFaces(std::vector<T>& values) const {
        if (!all) {
            pick(values, faces);
        }
    }
    template<class T>
    void keepCorners(std::vector<T>& values) const {
        if (!all) {
            pick(values, corners);
        }
    }
};

/// Whether nothing has to be mended: each face goes round three different, finite points at least. Most meshes are so.
bool isIntact(const ControlMesh& mesh) {
    constexpr std::size_t together = 16384; // points, faces
    constexpr std::size_t mostCorners = 16; // beyond, comparing each with each costs more than it saves
    std::atomic<bool> intact{true};
    parallelFor(mesh.points.size(), together, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!usable(mesh.points[i])) {
                intact = false;
                return;
            }
        }
    });
    std::vector<std::size_t> starts; // first face vertex of every so many faces
    std::size_t vertex = 0;
    for (std::size_t f = 0; f < mesh.faceVertexCounts.size(); ++f) {
        if (f % together == 0) {
            starts.push_back(vertex);
        }
        const int count = mesh.faceVertexCounts[f];
        if (count < 3 || std::size_t(count) > mostCorners) {
            return false;
        }
        vertex += std::size_t(count);
    }
    if (vertex != mesh.faceVertexIndices.size()) {
        return false;
    }
    parallelFor(mesh.faceVertexCounts.size(), together, [&](std::size_t begin, std::size_t end) {
        const int* corner = mesh.faceVertexIndices.data() + starts[begin / together];
        for (std::size_t f = begin; f < end && intact; ++f) {
            const int* const next = corner + mesh.faceVertexCounts[f];
            for (const int* c = corner; c < next; ++c) {
                if (*c < 0 || std::size_t(*c) >= mesh.points.size() || std::find(corner, c, *c) != c) {
                    intact = false;
                    return;
                }
            }
            corner = next;
        }
    });
    return intact;
}

Selection selectFaces(const ControlMesh& mesh, MeshRepairs& repairs) {
    Selection selection;
    const std::size_t cornerCount = mesh.faceVertexIndices.size();
    if (isIntact(mesh)) {
        selection.all = true;
        return selection;
    }
    std::vector<char> bad(mesh.points.size(), 0);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        bad[i] = !usable(mesh.points[i]);
        repairs.nonFinitePoints += bad[i];
    }

    std::size_t begin = 0;
    std::vector<std::size_t> corners;
    std::vector<int> sorted;
    for (std::size_t f = 0; f < mesh.faceVertexCounts.size(); ++f) {
        const int count = mesh.faceVertexCounts[f];
        if (count <= 0) {
            ++repairs.droppedFaces;
            continue;
        }
        if (std::size_t(count) > cornerCount - begin) {
            // What follows cannot be told apart any more.
            repairs.droppedFaces += int(mesh.faceVertexCounts.size() - f);
            break;
        }
        bool valid = true;
        corners.clear();
        for (std::size_t i = begin; i < begin + std::size_t(count); ++i) {
            const int v = mesh.faceVertexIndices[i];
            if (v < 0 || std::size_t(v) >= mesh.points.size() || bad[std::size_t(v)]) {
                valid = false;
                break;
            }
            if (corners.empty() || mesh.faceVertexIndices[corners.back()] != v) {
                corners.push_back(i);
            }
        }
        begin += std::size_t(count);
        if (valid) {
            while (corners.size() > 1 &&
                   mesh.faceVertexIndices[corners.front()] == mesh.faceVertexIndices[corners.back()]) {
                corners.pop_back();
            }
            sorted.clear();
            for (std::size_t i : corners) {
                sorted.push_back(mesh.faceVertexIndices[i]);
            }
            std::sort(sorted.begin(), sorted.end());
            // A face that visits a vertex twice (a figure of eight) has no inside.
            valid = corners.size() >= 3 && std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
        }
        if (!valid) {
            ++repairs.droppedFaces;
            continue;
        }
        repairs.mendedFaces += int(corners.size()) != count;
        selection.faces.push_back(int(f));
        selection.counts.push_back(int(corners.size()));
        selection.corners.insert(selection.corners.end(), corners.begin(), corners.end());
    }
    return selection;
}

/// False if the array has another length than its interpolation asks for.
template<class T>
bool applySelection(std::vector<T>& values, ControlMesh::Interpolation interpolation, const ControlMesh& mesh,
                    const Selection& selection) {
    using Interpolation = ControlMesh::Interpolation;
    switch (interpolation) {
    case Interpolation::Constant:
        values.resize(std::min<std::size_t>(values.size(), 1));
        return true;
    case Interpolation::Uniform:
        if (values.size() != mesh.faceVertexCounts.size()) {
            return false;
        }
        selection.keepFaces(values);
        return true;
    case Interpolation::Vertex:
        return values.size() == mesh.points.size();
    case Interpolation::FaceVarying:
        if (values.size() != mesh.faceVertexIndices.size()) {
            return false;
        }
        selection.keepCorners(values);
        return true;
    }
    return false;
}

void sanitizeUvs(ControlMesh& mesh, const Selection& selection, MeshRepairs& repairs) {
    if (mesh.uvs.empty() && mesh.uvIndices.empty()) {
        return;
    }
    bool valid = mesh.uvIndices.size() == mesh.faceVertexIndices.size();
    if (valid) {
        selection.keepCorners(mesh.uvIndices);
        for (int i : mesh.uvIndices) {
            valid = valid && i >= 0 && std::size_t(i) < mesh.uvs.size();
        }
    }
    if (!valid) {
        mesh.uvs.clear();
        mesh.uvIndices.clear();
        repairs.droppedUvs = true;
        return;
    }
    for (Vec2f& uv : mesh.uvs) {
        if (!usable(uv)) {
            uv = {};
            ++repairs.nonFiniteUvs;
        }
    }
}

/// The rest pose is whole or not at all: a missing point would tear the surface.
void sanitizeRest(ControlMesh& mesh, MeshRepairs& repairs) {
    if (mesh.rest.empty()) {
        return;
    }
    const bool finite = std::all_of(mesh.rest.begin(), mesh.rest.end(), [](const Vec3f& p) { return usable(p); });
    const bool onePoint =
        std::all_of(mesh.rest.begin(), mesh.rest.end(), [&](const Vec3f& p) { return p == mesh.rest[0]; });
    if (mesh.rest.size() != mesh.points.size() || !finite || onePoint) {
        mesh.rest.clear();
        repairs.droppedRest = true;
    }
}

/// Unit vectors, or zero where there is no wish.
void sanitizeOrientation(ControlMesh& mesh, const Selection& selection, MeshRepairs& repairs) {
    if (mesh.orientation.empty()) {
        return;
    }
    if (!applySelection(mesh.orientation, mesh.orientationInterpolation, mesh, selection)) {
        mesh.orientation.clear();
        repairs.droppedOrientation = true;
    }
    for (Vec3f& d : mesh.orientation) {
        repairs.nonFiniteOrientations += !usable(d);
        d = usable(d) ? normalize(d) : Vec3f();
    }
}

void sanitizeHoles(ControlMesh& mesh, std::size_t givenFaces, const Selection& selection, MeshRepairs& repairs) {
    if (mesh.holeIndices.empty()) {
        return;
    }
    std::vector<char> hole(givenFaces, 0);
    for (int f : mesh.holeIndices) {
        if (f >= 0 && std::size_t(f) < givenFaces) {
            hole[std::size_t(f)] = 1;
        } else {
            repairs.droppedTags = true;
        }
    }
    selection.keepFaces(hole);
    mesh.holeIndices.clear();
    for (std::size_t i = 0; i < hole.size(); ++i) {
        if (hole[i]) {
            mesh.holeIndices.push_back(int(i));
        }
    }
}

float usableSharpness(float s) {
    return s > 0 ? std::min(s, 10.0f) : 0.0f;
} // NaN: 0; 10 is infinitely sharp

void sanitizeCorners(ControlMesh& mesh, MeshRepairs& repairs) {
    if (mesh.cornerIndices.size() != mesh.cornerSharpnesses.size()) {
        repairs.droppedTags = true;
        mesh.cornerIndices.clear();
        mesh.cornerSharpnesses.clear();
        return;
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < mesh.cornerIndices.size(); ++i) {
        const int v = mesh.cornerIndices[i];
        if (v < 0 || std::size_t(v) >= mesh.points.size()) {
            repairs.droppedTags = true;
            continue;
        }
        mesh.cornerIndices[kept] = v;
        mesh.cornerSharpnesses[kept++] = usableSharpness(mesh.cornerSharpnesses[i]);
    }
    mesh.cornerIndices.resize(kept);
    mesh.cornerSharpnesses.resize(kept);
}

/// Rewrites creases as single edges, one sharpness each: a bad index then costs one edge only.
void sanitizeCreases(ControlMesh& mesh, MeshRepairs& repairs) {
    std::size_t vertices = 0, edges = 0;
    bool valid = true;
    for (int n : mesh.creaseLengths) {
        valid = valid && n >= 2;
        if (valid) {
            vertices += std::size_t(n);
            edges += std::size_t(n) - 1;
        }
    }
    const std::size_t sharpnesses = mesh.creaseSharpnesses.size();
    valid = valid && vertices == mesh.creaseIndices.size() &&
            (sharpnesses == mesh.creaseLengths.size() || sharpnesses == edges);
    std::vector<int> indices;
    std::vector<float> weights;
    if (valid) {
        const bool perEdge = sharpnesses == edges && sharpnesses != mesh.creaseLengths.size();
        std::size_t at = 0, edge = 0;
        for (std::size_t c = 0; c < mesh.creaseLengths.size(); ++c) {
            for (int i = 0; i + 1 < mesh.creaseLengths[c]; ++i, ++edge) {
                const int a = mesh.creaseIndices[at + std::size_t(i)], b = mesh.creaseIndices[at + std::size_t(i) + 1];
                const int n = int(mesh.points.size());
                if (a < 0 || b < 0 || a >= n || b >= n || a == b) {
                    repairs.droppedTags = true;
                    continue;
                }
                indices.insert(indices.end(), {a, b});
                weights.push_back(usableSharpness(mesh.creaseSharpnesses[perEdge ? edge : c]));
            }
            at += std::size_t(mesh.creaseLengths[c]);
        }
    } else {
        repairs.droppedTags = true;
    }
    mesh.creaseIndices.swap(indices);
    mesh.creaseSharpnesses.swap(weights);
    mesh.creaseLengths.assign(mesh.creaseSharpnesses.size(), 2);
}

bool oneOf(const std::string& token, std::initializer_list<const char*> known) {
    return std::any_of(known.begin(), known.end(), [&](const char* k) { return token == k; });
}

void sanitizeRules(ControlMesh& mesh, MeshRepairs& repairs) {
    if (!oneOf(mesh.interpolateBoundary, {"none", "edgeOnly", "edgeAndCorner"})) {
        repairs.droppedTags = repairs.droppedTags || !mesh.interpolateBoundary.empty();
        mesh.interpolateBoundary = "edgeAndCorner";
    }
    if (!oneOf(mesh.faceVaryingInterpolation,
               {"none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all"})) {
        repairs.droppedTags = repairs.droppedTags || !mesh.faceVaryingInterpolation.empty();
        mesh.faceVaryingInterpolation = "cornersPlus1";
    }
}

} // namespace

MeshRepairs sanitize(ControlMesh& mesh) {
    MeshRepairs repairs;
    const std::size_t givenFaces = mesh.faceVertexCounts.size();
    const Selection selection = selectFaces(mesh, repairs);

    // Everything that refers to the given faces goes first, while their counts are still there.
    sanitizeUvs(mesh, selection, repairs);
    if (!mesh.normals.empty() && !applySelection(mesh.normals, mesh.normalInterpolation, mesh, selection)) {
        mesh.normals.clear();
        repairs.droppedNormals = true;
    }
    if (!mesh.colors.empty() && !applySelection(mesh.colors, mesh.colorInterpolation, mesh, selection)) {
        mesh.colors.clear();
        repairs.droppedColors = true;
    }
    sanitizeRest(mesh, repairs);
    sanitizeOrientation(mesh, selection, repairs);
    sanitizeHoles(mesh, givenFaces, selection, repairs);
    if (mesh.faceParts.size() == givenFaces) {
        selection.keepFaces(mesh.faceParts);
    } else {
        mesh.faceParts.clear();
    }

    selection.keepCorners(mesh.faceVertexIndices);
    if (!selection.all) {
        mesh.faceVertexCounts = selection.counts;
    }
    for (Vec3f& p : mesh.points) {
        if (!usable(p)) {
            p = {};
        }
    }
    for (Vec3f& n : mesh.normals) {
        n = usable(n) ? normalize(n) : Vec3f(); // zero: refine takes the facet's own
    }
    for (Rgb& c : mesh.colors) {
        c = usable(c) ? c : Rgb(0.5f);
    }
    sanitizeCorners(mesh, repairs);
    sanitizeCreases(mesh, repairs);
    sanitizeRules(mesh, repairs);

    if (mesh.faceVertexCounts.empty() || mesh.holeIndices.size() == mesh.faceVertexCounts.size()) {
        throw Error("the mesh has no usable face" + (givenFaces ? " (" + repairs.summary() + ")" : std::string()));
    }
    return repairs;
}

std::string MeshRepairs::summary() const {
    std::string text;
    const auto add = [&](bool condition, const std::string& part) {
        if (condition) {
            text += (text.empty() ? "" : ", ") + part;
        }
    };
    const auto counted = [](int n, const char* one, const char* many) {
        return std::to_string(n) + " " + (n == 1 ? one : many);
    };
    add(droppedFaces > 0, counted(droppedFaces, "face", "faces") + " dropped (degenerate or indices out of range)");
    add(mendedFaces > 0, counted(mendedFaces, "face", "faces") + " with repeated vertices mended");
    add(nonFinitePoints > 0, counted(nonFinitePoints, "point is", "points are") + " not finite");
    add(nonFiniteUvs > 0, counted(nonFiniteUvs, "texture coordinate is", "texture coordinates are") + " not finite");
    add(droppedUvs, "texture coordinates ignored (wrong counts or indices)");
    add(droppedColors, "colours ignored (wrong count)");
    add(droppedNormals, "normals ignored (wrong count)");
    add(droppedRest, "stf:rest ignored (wrong count, not finite, or all points in one)");
    add(droppedOrientation, "stf:orientation ignored (wrong count)");
    add(nonFiniteOrientations > 0,
        counted(nonFiniteOrientations, "vector", "vectors") + " of stf:orientation ignored (not finite)");
    add(droppedTags, "subdivision tags out of range ignored");
    return text.empty() ? text : text + ".";
}

} // namespace stf
