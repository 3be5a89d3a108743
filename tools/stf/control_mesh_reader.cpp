// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/control_mesh_reader.h"

#include "stfLib/acquire/mesh_reader.h"
#include "stfLib/acquire/mesh_repair.h"
#if HDSTF_WITH_OPENUSD
#include "tools/stf/usd_mesh_reader.h"
#endif

namespace stf {

ControlMesh readControlMesh(const std::string& path, const std::string& scheme, const MessageSink& messages) {
#if HDSTF_WITH_OPENUSD
    const std::vector<MeshPart> parts = isUsdPath(path) ? readUsdMeshes(path, messages) : readMeshFile(path);
#else
    const std::vector<MeshPart> parts = readMeshFile(path);
#endif
    ControlMesh mesh;
    mesh.scheme = scheme == "loop"           ? ControlMesh::Scheme::Loop
                  : scheme == "catmullClark" ? ControlMesh::Scheme::CatmullClark
                                             : ControlMesh::Scheme::None;
    TriangleMesh whole;
    for (const MeshPart& part : parts) {
        append(whole, part.mesh);
    }
    // A surface has one outside: triangles turned against their neighbours are turned back.
    const MendedMesh mended = repair(whole, path);
    const MeshRepair& r = mended.repair;
    if (messages && r.turned + r.degenerate + r.duplicates + r.crowdedEdges > 0) {
        messages(Severity::Warning, path + ": " + r.summary());
    }
    for (const Vec3d& p : mended.mesh.points) {
        mesh.points.push_back(Vec3f(p));
    }
    for (const Vec3i& t : mended.mesh.triangles) {
        mesh.faceVertexCounts.push_back(3);
        mesh.faceVertexIndices.insert(mesh.faceVertexIndices.end(), {t.x, t.y, t.z});
    }
    return mesh;
}

RefinedSurface readRefinedSurface(const std::string& path, const std::string& scheme, const MessageSink& messages) {
    const MessageSink ofMesh = [&](Severity s, const std::string& t) { report(messages, s, path + ": " + t); };
    ControlMesh mesh = readControlMesh(path, scheme, messages);
    try {
        const std::string repairs = sanitize(mesh).summary();
        if (!repairs.empty()) {
            ofMesh(Severity::Warning, repairs);
        }
        RefineOptions options;
        Box3f box;
        for (const Vec3f& p : mesh.points) {
            box.add(p);
        }
        if (mesh.scheme != ControlMesh::Scheme::None) {
            options.targetEdge = box.diagonal() / 150;
        }
        return refine(mesh, options, ofMesh);
    } catch (const Error& e) {
        throw Error(path + ": " + e.what());
    }
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
