// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/control_mesh_reader.h"

#include "stfLib/acquire/mesh_reader.h"
#if HDSTF_WITH_OPENUSD
#include "tools/stf/usd_mesh_reader.h"
#endif

namespace stf {

ControlMesh readControlMesh(const std::string& path, const std::string& scheme,
                            [[maybe_unused]] const MessageSink& messages) {
#if HDSTF_WITH_OPENUSD
    const std::vector<MeshPart> parts = isUsdPath(path) ? readUsdMeshes(path, messages) : readMeshFile(path);
#else
    const std::vector<MeshPart> parts = readMeshFile(path);
#endif
    ControlMesh mesh;
    mesh.scheme = scheme == "loop"           ? ControlMesh::Scheme::Loop
                  : scheme == "catmullClark" ? ControlMesh::Scheme::CatmullClark
                                             : ControlMesh::Scheme::None;
    for (const MeshPart& part : parts) {
        const int base = int(mesh.points.size());
        for (const Vec3d& p : part.mesh.points) {
            mesh.points.push_back(Vec3f(p));
        }
        for (const Vec3i& t : part.mesh.triangles) {
            mesh.faceVertexCounts.push_back(3);
            for (int c = 0; c < 3; ++c) {
                mesh.faceVertexIndices.push_back(base + t[c]);
            }
        }
    }
    return mesh;
}

double surfaceArea(const RefinedSurface& s) {
    double sum = 0;
    for (const Vec3i& t : s.triangles) {
        const Vec3d p(s.points[std::size_t(t.x)]);
        sum += 0.5 * length(cross(Vec3d(s.points[std::size_t(t.y)]) - p, Vec3d(s.points[std::size_t(t.z)]) - p));
    }
    return sum;
}

} // namespace stf
