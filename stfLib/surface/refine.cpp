// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/surface/refine_parts.h"

#include <algorithm>

namespace stf {

namespace {

constexpr std::size_t kTogether = 4096; // triangles, points

/// The same surface seen with the other winding; arrays per face vertex are turned along.
ControlMesh turned(const ControlMesh& mesh) {
    ControlMesh out = mesh;
    out.leftHanded = false;
    const bool turnNormals =
        mesh.normalInterpolation == ControlMesh::Interpolation::FaceVarying && !mesh.normals.empty();
    const bool turnColors = mesh.colorInterpolation == ControlMesh::Interpolation::FaceVarying && !mesh.colors.empty();
    const bool turnOrientation =
        mesh.orientationInterpolation == ControlMesh::Interpolation::FaceVarying && !mesh.orientation.empty();
    std::size_t begin = 0;
    for (int count : mesh.faceVertexCounts) {
        // The first vertex stays, as OpenSubdiv has it for left-handed meshes.
        const auto turn = [&](auto& values) {
            std::reverse(values.begin() + std::ptrdiff_t(begin + 1),
                         values.begin() + std::ptrdiff_t(begin + std::size_t(count)));
        };
        turn(out.faceVertexIndices);
        if (!out.uvIndices.empty()) {
            turn(out.uvIndices);
        }
        if (turnNormals) {
            turn(out.normals);
        }
        if (turnColors) {
            turn(out.colors);
        }
        if (turnOrientation) {
            turn(out.orientation);
        }
        begin += std::size_t(count);
    }
    return out;
}

/// Removes points and uvs that no triangle uses and fills the bounds.
void compact(RefinedSurface& surface, SurfacePose* pose) {
    std::vector<int> number(surface.points.size(), -1);
    for (const Vec3i& t : surface.triangles) {
        number[std::size_t(t.x)] = number[std::size_t(t.y)] = number[std::size_t(t.z)] = 0;
    }
    int used = 0;
    for (int& n : number) {
        n = n < 0 ? n : used++;
    }
    const auto keepUsed = [&](auto& values) {
        if (values.empty() || used == int(number.size())) {
            return;
        }
        for (std::size_t i = 0; i < number.size(); ++i) {
            if (number[i] >= 0) {
                values[std::size_t(number[i])] = values[i];
            }
        }
        values.resize(std::size_t(used));
    };
    keepUsed(surface.points);
    keepUsed(surface.normals);
    keepUsed(surface.colors);
    keepUsed(surface.orientation);
    if (pose) {
        keepUsed(pose->points);
        keepUsed(pose->normals);
    }
    for (const Vec3f& p : surface.points) {
        surface.bounds.add(p);
    }
    for (std::size_t i = 0; used < int(number.size()) && i < surface.triangles.size(); ++i) {
        Vec3i& t = surface.triangles[i];
        t = {number[std::size_t(t.x)], number[std::size_t(t.y)], number[std::size_t(t.z)]};
    }

    number.assign(surface.uvs.size(), -1);
    for (const Vec3i& t : surface.uvTriangles) {
        number[std::size_t(t.x)] = number[std::size_t(t.y)] = number[std::size_t(t.z)] = 0;
    }
    used = 0;
    for (std::size_t i = 0; i < number.size(); ++i) {
        if (number[i] == 0) {
            surface.uvs[std::size_t(used)] = surface.uvs[i];
            number[i] = used++;
        }
    }
    surface.uvs.resize(std::size_t(used));
    for (Vec3i& t : surface.uvTriangles) {
        t = {number[std::size_t(t.x)], number[std::size_t(t.y)], number[std::size_t(t.z)]};
    }
}

RefinedSurface refineWithPose(const ControlMesh& mesh, const RefineOptions& options, const MessageSink& messages,
                              SurfacePose* pose) {
    if (mesh.faceVertexCounts.empty()) {
        throw Error("the mesh has no usable face");
    }
    if (mesh.leftHanded) {
        return refineWithPose(turned(mesh), options, messages, pose);
    }
    RefinedSurface surface = mesh.scheme == ControlMesh::Scheme::None
                                 ? refinePolygons(mesh, options, messages, pose)
                                 : refineSubdivision(mesh, options, messages, pose);
    compact(surface, pose);
    if (surface.triangles.empty()) {
        throw Error("the mesh has no usable face: all are holes");
    }
    return surface;
}

} // namespace

RefinedSurface refine(const ControlMesh& mesh, const RefineOptions& options, const MessageSink& messages) {
    return refineWithPose(mesh, options, messages, nullptr);
}

RefinedSurface refineAtRest(const ControlMesh& mesh, const RefineOptions& options, const MessageSink& messages,
                            SurfacePose& pose) {
    if (mesh.rest.size() != mesh.points.size()) {
        throw Error("the mesh has no rest pose");
    }
    ControlMesh atRest = mesh;
    pose = {};
    pose.points = std::move(atRest.points);
    atRest.points = std::move(atRest.rest);
    atRest.rest.clear();
    return refineWithPose(atRest, options, messages, &pose);
}

RefinedSurface inPose(const RefinedSurface& surface, SurfacePose pose) {
    RefinedSurface posed = surface;
    posed.points = std::move(pose.points);
    posed.normals = std::move(pose.normals);
    posed.cornerNormals = std::move(pose.cornerNormals);
    posed.bounds = {};
    for (const Vec3f& p : posed.points) {
        posed.bounds.add(p);
    }
    return posed;
}

float cornerAngle(const std::vector<Vec3f>& points, const Vec3i& triangle, int c) {
    const Vec3d p(points[std::size_t(triangle[c])]);
    const Vec3d a = Vec3d(points[std::size_t(triangle[(c + 1) % 3])]) - p;
    const Vec3d b = Vec3d(points[std::size_t(triangle[(c + 2) % 3])]) - p;
    return float(std::atan2(length(cross(a, b)), dot(a, b)));
}

std::vector<Vec3f> angleWeightedNormals(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles,
                                        const std::vector<Vec3f>& cornerNormals) {
    // What costs is found in parallel, and added up in the order of the triangles.
    std::vector<Vec3d> facets(cornerNormals.empty() ? triangles.size() : 0);
    std::vector<Vec3f> angles(triangles.size());
    parallelFor(triangles.size(), kTogether, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            const Vec3i& tri = triangles[t];
            if (!facets.empty()) {
                const Vec3d p(points[std::size_t(tri.x)]);
                facets[t] =
                    normalize(cross(Vec3d(points[std::size_t(tri.y)]) - p, Vec3d(points[std::size_t(tri.z)]) - p));
            }
            angles[t] = {cornerAngle(points, tri, 0), cornerAngle(points, tri, 1), cornerAngle(points, tri, 2)};
        }
    });
    std::vector<Vec3d> sum(points.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c) {
            const Vec3d n = facets.empty() ? Vec3d(cornerNormals[3 * t + std::size_t(c)]) : facets[t];
            sum[std::size_t(triangles[t][c])] += n * double(angles[t][c]);
        }
    }
    std::vector<Vec3f> normals(points.size());
    parallelFor(points.size(), kTogether, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            // Opposite facets cancel: what is left over is rounding, not a direction.
            normals[i] = length(sum[i]) > 1e-6 ? Vec3f(normalize(sum[i])) : Vec3f();
        }
    });
    return normals;
}

std::vector<Vec3f> controlPointValues(const ControlMesh& mesh, const std::vector<Vec3f>& values,
                                      ControlMesh::Interpolation interpolation) {
    using Interpolation = ControlMesh::Interpolation;
    if (values.empty() || interpolation == Interpolation::Vertex) {
        return values;
    }
    std::vector<Vec3f> means(mesh.points.size(), values[0]);
    if (interpolation == Interpolation::Constant) {
        return means;
    }
    std::vector<int> uses(mesh.points.size(), 0);
    std::size_t corner = 0;
    for (std::size_t f = 0; f < mesh.faceVertexCounts.size(); ++f) {
        for (int i = 0; i < mesh.faceVertexCounts[f]; ++i, ++corner) {
            const std::size_t v = std::size_t(mesh.faceVertexIndices[corner]);
            const Vec3f& c = values[interpolation == Interpolation::Uniform ? f : corner];
            means[v] = uses[v]++ ? means[v] + c : c;
        }
    }
    for (std::size_t v = 0; v < means.size(); ++v) {
        means[v] /= float(std::max(1, uses[v]));
    }
    return means;
}

void normalizeOrientation(std::vector<Vec3f>& orientation) {
    constexpr float leastAgreement = 0.3f; // of unit vectors, in the length of their mean
    for (Vec3f& d : orientation) {
        d = length(d) > leastAgreement ? normalize(d) : Vec3f();
    }
}

double typicalLargest(std::vector<double>& lengths) {
    if (lengths.empty()) {
        return 0;
    }
    const auto at = lengths.begin() + std::ptrdiff_t(double(lengths.size() - 1) * 0.95);
    std::nth_element(lengths.begin(), at, lengths.end());
    return *at;
}

void weldUvs(const ControlMesh& mesh, std::vector<Vec2f>& uvs, std::vector<int>& uvIndices) {
    // Per control point a short chain of the values met there.
    std::vector<int> first(mesh.points.size(), -1);
    std::vector<int> next;
    uvs.clear();
    uvIndices.resize(mesh.uvIndices.size());
    for (std::size_t i = 0; i < mesh.uvIndices.size(); ++i) {
        const Vec2f uv = mesh.uvs[std::size_t(mesh.uvIndices[i])];
        int& head = first[std::size_t(mesh.faceVertexIndices[i])];
        int found = head;
        while (found >= 0 && !(uvs[std::size_t(found)] == uv)) {
            found = next[std::size_t(found)];
        }
        if (found < 0) {
            found = int(uvs.size());
            uvs.push_back(uv);
            next.push_back(head);
            head = found;
        }
        uvIndices[i] = found;
    }
}

} // namespace stf
