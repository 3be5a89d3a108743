// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_reader.h"
#include "stfLib/surface/refined_surface.h"

#include <algorithm>
#include <ctime>
#include <string>

namespace stf {

/// All triangles of a mesh file (OBJ, PLY, STL, OFF), as they are. Throws Error where it cannot be read.
inline ControlMesh meshOf(const std::string& path) {
    ControlMesh mesh;
    mesh.scheme = ControlMesh::Scheme::None;
    for (const MeshPart& part : readMeshFile(path)) {
        const int base = int(mesh.points.size());
        for (const Vec3d& p : part.mesh.points) {
            mesh.points.push_back(Vec3f(p));
        }
        for (const Vec3i& t : part.mesh.triangles) {
            mesh.faceVertexCounts.push_back(3);
            mesh.faceVertexIndices.insert(mesh.faceVertexIndices.end(), {base + t.x, base + t.y, base + t.z});
        }
    }
    sanitize(mesh);
    return mesh;
}

/// Seconds of the processor that `f` takes: others may be at work. What it returns keeps it from being left out.
template<class F>
double processorSeconds(const F& f) {
    volatile float keep = 0;
    const std::clock_t start = std::clock();
    keep = keep + f();
    return double(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Things a second in the quickest of some rounds, `count` of them in each.
template<class F>
double perSecond(std::size_t count, int rounds, const F& f) {
    double best = 1e300;
    for (int r = 0; r < rounds; ++r) {
        best = std::min(best, processorSeconds(f));
    }
    return double(count) / best;
}

} // namespace stf
