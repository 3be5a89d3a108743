// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/volume_usd.h"

#include "tools/stfrecord/atomicFile.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace stf {

namespace {

struct Field {
    const char* grid;
    bool vector, there;
};

std::string assetPath(const std::string& volume, const std::string& scene) {
    namespace fs = std::filesystem;
    const fs::path from = fs::absolute(scene).parent_path(), to = fs::absolute(volume);
    const fs::path relative = to.lexically_normal().lexically_relative(from.lexically_normal());
    return relative.empty() || *relative.begin() == ".." ? to.lexically_normal().string() : "./" + relative.string();
}

} // namespace

void writeVolumeUsd(const BaseVolume& v, const std::string& volumePath, const std::string& path) {
    const Field fields[] = {{"extinction", true, true},
                            {"albedo", true, true},
                            {"g", false, !v.g.empty()},
                            {"ior", false, !v.ior.empty()},
                            {"surface", false, !v.surface.empty()},
                            {"emission", true, !v.emission.empty()}};
    const std::string asset = assetPath(volumePath, path);
    if (asset.find('@') != std::string::npos) {
        throw std::runtime_error(path + ": cannot name " + asset + " in a scene, for its '@'");
    }
    const Vec3d mm = v.extentMm();
    std::string relations, prims;
    for (const Field& f : fields) {
        if (!f.there) {
            continue;
        }
        const std::string grid = f.grid;
        relations += "    rel field:" + grid + " = </Volume/" + grid + ">\n";
        prims += "\n    def OpenVDBAsset \"" + grid + "\"\n    {\n        token fieldName = \"" + grid +
                 "\"\n        asset filePath = @" + asset + "@\n        token fieldDataType = \"" +
                 (f.vector ? "float3\"\n        token vectorDataRoleHint = \"Color\"" : "float\"") +
                 "\n        token fieldClass = \"" +
                 (grid == "surface"                            ? "levelSet"
                  : grid == "extinction" || grid == "emission" ? "fogVolume"
                                                               : "unknown") +
                 "\"\n    }\n";
    }
    stfrecord::writeAtomically(path, [&](const std::string& temporary) {
        std::ofstream out(temporary);
        out << "#usda 1.0\n(\n    doc = \"The grids of a base volume. Millimetres, coefficients per mm.\"\n"
               "    defaultPrim = \"Volume\"\n    metersPerUnit = 0.001\n    upAxis = \"Z\"\n)\n\n"
               "def Volume \"Volume\"\n{\n"
            << relations << "    float3[] extent = [(0, 0, 0), (" << mm.x << ", " << mm.y << ", " << mm.z
            << ")]\n    # z of a base volume grows inward.\n    float3 xformOp:scale = (1, 1, -1)\n"
               "    uniform token[] xformOpOrder = [\"xformOp:scale\"]\n"
            << prims << "}\n";
        if (!out.flush()) {
            throw std::runtime_error(path + ": cannot be written");
        }
    });
}

} // namespace stf
