// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/mesh_acquisition_json.h"

namespace stf {

nlohmann::json describeAcquisition(const MeshAcquisition& a, const std::string& path) {
    const BaseVolume& v = a.volume;
    const Vec3d mm = v.extentMm();
    nlohmann::json meshes = nlohmann::json::array(), shares = nlohmann::json::object();
    for (const AcquiredMesh& m : a.meshes) {
        meshes.push_back({{"mesh", m.label},
                          {"material", m.material},
                          {"copies", m.copies},
                          {"volumeMm3", m.volumeMm3},
                          {"points", m.repair.points},
                          {"triangles", m.repair.triangles},
                          {"pieces", m.repair.pieces},
                          {"turned", m.repair.turned},
                          {"degenerate", m.repair.degenerate},
                          {"duplicates", m.repair.duplicates},
                          {"crowdedEdges", m.repair.crowdedEdges},
                          {"holes", m.repair.holes},
                          {"boundary", m.repair.boundaryMm},
                          {"summary", m.repair.summary()}});
    }
    for (const AcquiredShare& s : a.shares) {
        shares[s.material] = shares.value(s.material, 0.0) + s.share;
    }
    return {{"path", path},
            {"name", v.name},
            {"size", {v.size.x, v.size.y, v.size.z}},
            {"extentMm", {mm.x, mm.y, mm.z}},
            {"surface", !v.surface.empty()},
            {"shares", shares},
            {"meshes", meshes},
            {"hash", v.contentHash()}};
}

} // namespace stf
