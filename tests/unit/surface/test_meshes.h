// SPDX-License-Identifier: Apache-2.0
#pragma once

// Control meshes with closed-form surfaces, shared by the tests of surface, synthesis and shell.

#include "stfLib/surface/control_mesh.h"

#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>

namespace stf::test {

constexpr double pi = 3.14159265358979323846;

/// Collects the messages of a stage.
struct Messages {
    std::string text;
    MessageSink sink() {
        return [this](Severity, const std::string& t) { text += t + "\n"; };
    }
    bool has(const std::string& part) const { return text.find(part) != std::string::npos; }
};

inline void addFace(ControlMesh& mesh, std::initializer_list<int> vertices) {
    mesh.faceVertexCounts.push_back(int(vertices.size()));
    mesh.faceVertexIndices.insert(mesh.faceVertexIndices.end(), vertices);
}

/// Cube from -1 to 1, faces counter-clockwise from outside.
inline ControlMesh cube(ControlMesh::Scheme scheme) {
    ControlMesh mesh;
    mesh.scheme = scheme;
    for (int i = 0; i < 8; ++i) {
        mesh.points.push_back({i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f});
    }
    addFace(mesh, {0, 2, 3, 1});
    addFace(mesh, {4, 5, 7, 6});
    addFace(mesh, {0, 1, 5, 4});
    addFace(mesh, {2, 6, 7, 3});
    addFace(mesh, {0, 4, 6, 2});
    addFace(mesh, {1, 3, 7, 5});
    return mesh;
}

inline ControlMesh octahedron() {
    ControlMesh mesh;
    mesh.scheme = ControlMesh::Scheme::Loop;
    mesh.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (int s = 0; s < 8; ++s) {
        const int x = s & 1, y = 2 + (s >> 1 & 1), z = 4 + (s >> 2 & 1);
        const bool even = ((s & 1) ^ (s >> 1 & 1) ^ (s >> 2 & 1)) == 0;
        if (even) {
            addFace(mesh, {x, y, z});
        } else {
            addFace(mesh, {y, x, z});
        }
    }
    return mesh;
}

/// A grid of nu x nv quads over uv in [0, 1]^2, placed by `place(u, v)`. Closed directions share their points, but
/// texture coordinates run from 0 to 1 and end at the seam. dP/du x dP/dv has to point outward.
template<class Place>
ControlMesh parametric(int nu, int nv, bool closedU, bool closedV, const Place& place) {
    ControlMesh mesh;
    mesh.scheme = ControlMesh::Scheme::None;
    const int pu = closedU ? nu : nu + 1, pv = closedV ? nv : nv + 1;
    for (int j = 0; j < pv; ++j) {
        for (int i = 0; i < pu; ++i) {
            mesh.points.push_back(Vec3f(place(double(i) / nu, double(j) / nv)));
        }
    }
    for (int j = 0; j <= nv; ++j) {
        for (int i = 0; i <= nu; ++i) {
            mesh.uvs.push_back({float(i) / float(nu), float(j) / float(nv)});
        }
    }
    for (int j = 0; j < nv; ++j) {
        for (int i = 0; i < nu; ++i) {
            for (const auto& [di, dj] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
                mesh.faceVertexIndices.push_back((j + dj) % pv * pu + (i + di) % pu);
                mesh.uvIndices.push_back((j + dj) * (nu + 1) + i + di);
            }
            mesh.faceVertexCounts.push_back(4);
        }
    }
    return mesh;
}

/// Rectangle in z = 0 with the normal +z.
inline ControlMesh rectangle(double width, double height, int nu, int nv) {
    return parametric(nu, nv, false, false, [=](double u, double v) { return Vec3d(u * width, v * height, 0); });
}

/// Open cylinder about z with smooth authored normals.
inline ControlMesh cylinder(double radius, double height, int nu, int nv) {
    ControlMesh mesh = parametric(nu, nv, true, false, [=](double u, double v) {
        return Vec3d(radius * std::cos(2 * pi * u), radius * std::sin(2 * pi * u), v * height);
    });
    for (const Vec3f& p : mesh.points) {
        mesh.normals.push_back(normalize(Vec3f(p.x, p.y, 0)));
    }
    return mesh;
}

/// Torus about z with smooth authored normals; uv turn around both circles.
inline ControlMesh torus(double major, double minor, int nu, int nv) {
    const auto place = [=](double u, double v, double r) {
        const double a = 2 * pi * u, b = 2 * pi * v;
        return Vec3d((major + r * std::cos(b)) * std::cos(a), (major + r * std::cos(b)) * std::sin(a), r * std::sin(b));
    };
    ControlMesh mesh = parametric(nu, nv, true, true, [=](double u, double v) { return place(u, v, minor); });
    for (int j = 0; j < nv; ++j) {
        for (int i = 0; i < nu; ++i) {
            const double u = double(i) / nu, v = double(j) / nv;
            mesh.normals.push_back(Vec3f(normalize(place(u, v, minor) - place(u, v, 0))));
        }
    }
    return mesh;
}

/// Unit sphere: a cube's faces in n x n quads, projected; normals are authored and exact. No uv.
inline ControlMesh sphere(int n, double radius = 1) {
    ControlMesh mesh;
    mesh.scheme = ControlMesh::Scheme::None;
    // Points on a lattice of the cube's surface, numbered as they are met.
    std::vector<int> number(std::size_t((n + 1) * (n + 1) * (n + 1)), -1);
    const auto vertex = [&](const Vec3i& q) {
        int& id = number[std::size_t((q.z * (n + 1) + q.y) * (n + 1) + q.x)];
        if (id < 0) {
            id = int(mesh.points.size());
            // Equal angles rather than equal lengths keep the quads alike.
            const auto warp = [n](int i) { return std::tan((2.0 * i / n - 1) * pi / 4); };
            const Vec3d d = normalize(Vec3d(warp(q.x), warp(q.y), warp(q.z)));
            mesh.points.push_back(Vec3f(d * radius));
            mesh.normals.push_back(Vec3f(d));
        }
        return id;
    };
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side) {
            for (int j = 0; j < n; ++j) {
                for (int i = 0; i < n; ++i) {
                    int corner[4];
                    for (int c = 0; c < 4; ++c) {
                        const int k = side ? c : 3 - c;
                        Vec3i q;
                        q[axis] = side ? n : 0;
                        q[(axis + 1) % 3] = i + (k == 1 || k == 2);
                        q[(axis + 2) % 3] = j + (k == 2 || k == 3);
                        corner[c] = vertex(q);
                    }
                    addFace(mesh, {corner[0], corner[1], corner[2], corner[3]});
                }
            }
        }
    }
    return mesh;
}

} // namespace stf::test
