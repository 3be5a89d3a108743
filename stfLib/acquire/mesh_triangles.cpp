// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_triangles.h"

#include "stfLib/base/triangulate_face.h"

namespace stf {

void Box3d::add(const Vec3d& p) {
    for (int k = 0; k < 3; ++k) {
        lo[k] = std::min(lo[k], p[k]);
        hi[k] = std::max(hi[k], p[k]);
    }
}

Box3d boundsOf(const TriangleMesh& mesh) {
    Box3d box;
    for (const Vec3i& t : mesh.triangles) {
        for (int k = 0; k < 3; ++k) {
            box.add(mesh.points[std::size_t(t[k])]);
        }
    }
    return box;
}

void addPolygon(TriangleMesh& mesh, const std::vector<int>& corners) {
    std::vector<Vec3d> places;
    for (int c : corners) {
        if (std::size_t(c) < mesh.points.size()) {
            places.push_back(mesh.points[std::size_t(c)]);
        }
    }
    if (corners.size() > 3 && places.size() == corners.size()) {
        std::vector<Vec3i> triangles;
        triangulateFace(places, triangles);
        for (const Vec3i& t : triangles) {
            mesh.triangles.push_back({corners[std::size_t(t.x)], corners[std::size_t(t.y)], corners[std::size_t(t.z)]});
        }
        return;
    }
    for (std::size_t i = 2; i < corners.size(); ++i) {
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
}

double signedVolume(const TriangleMesh& mesh) {
    const Vec3d middle = boundsOf(mesh).middle();
    double sum = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Vec3d a = mesh.corner(i, 0) - middle, b = mesh.corner(i, 1) - middle, c = mesh.corner(i, 2) - middle;
        sum += dot(a, cross(b, c));
    }
    return sum / 6;
}

TriangleMesh transformed(const TriangleMesh& mesh, const Transform& transform) {
    TriangleMesh result = mesh;
    for (Vec3d& p : result.points) {
        p = transform.point(p);
    }
    if (transform.determinant() < 0) {
        for (Vec3i& t : result.triangles) {
            std::swap(t.y, t.z);
        }
    }
    return result;
}

void append(TriangleMesh& mesh, const TriangleMesh& more) {
    const int first = int(mesh.points.size());
    mesh.points.insert(mesh.points.end(), more.points.begin(), more.points.end());
    for (const Vec3i& t : more.triangles) {
        mesh.triangles.push_back(t + Vec3i(first));
    }
}

} // namespace stf
