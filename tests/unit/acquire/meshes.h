// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_acquire.h"
#include "stfLib/acquire/mesh_shapes.h"
#include "tests/unit/support/files.h"

#include <fstream>

namespace stf::test {

constexpr double kPi = 3.14159265358979323846;

/// A finely triangulated sphere; its points lie `radius` away from the middle.
inline TriangleMesh sphereMesh(double radius, const Vec3d& middle, int detail = 5) {
    MeshSource source;
    source.shape = MeshSource::Shape::Sphere;
    TriangleMesh m = makeShape(source, Vec3d(1.0), detail);
    for (Vec3d& p : m.points) {
        p = normalize(p) * radius + middle;
    }
    return m;
}

inline TriangleMesh boxMesh(const Vec3d& size, const Vec3d& middle) {
    MeshSource source;
    source.shape = MeshSource::Shape::Box;
    TriangleMesh m = makeShape(source, Vec3d(1.0), 0);
    for (Vec3d& p : m.points) {
        p = p * size + middle;
    }
    return m;
}

inline TriangleMesh turnedOver(TriangleMesh m) {
    for (Vec3i& t : m.triangles) {
        std::swap(t.y, t.z);
    }
    return m;
}

/// What a recipe makes of meshes that are handed over under the names of files ("a", "b", ...).
struct Acquired : MeshAcquisition {
    std::vector<std::string> messages;
};

inline Acquired acquired(const std::string& recipe, const std::vector<TriangleMesh>& files = {}) {
    const MeshReader reader = [&](const std::string& path) -> std::vector<MeshPart> {
        const std::size_t i = std::size_t(path.back() - 'a');
        if (i >= files.size()) {
            throw Error(path + ": no such file");
        }
        return {{"part", "", "", files[i]}};
    };
    Acquired result;
    Progress progress;
    static_cast<MeshAcquisition&>(result) =
        acquireMesh(parseMeshRecipe(recipe, "recipe", ""), reader, 1e9, progress,
                    [&](Severity, const std::string& text) { result.messages.push_back(text); });
    return result;
}

/// Share of the tile's volume; 0 for a material that is not there.
inline double shareOf(const MeshAcquisition& a, const std::string& material) {
    double sum = 0;
    for (const AcquiredShare& s : a.shares) {
        sum += s.material == material ? s.share : 0;
    }
    return sum;
}

} // namespace stf::test
