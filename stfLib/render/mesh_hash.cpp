// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/mesh_hash.h"

#include "stfLib/volume/base_volume.h"

namespace stf {

namespace {

/// Hashes of arrays, one after the other, and the hash of those.
class Hasher {
public:
    template<class T>
    Hasher& add(const std::vector<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        text_ += contentHashOf({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
        return *this;
    }
    Hasher& add(const std::string& text) {
        text_ += text + ";";
        return *this;
    }
    Hasher& add(int number) { return add(std::to_string(number)); }
    std::string hash() const { return contentHashOf(text_); }

private:
    std::string text_;
};

} // namespace

std::string topologyHash(const ControlMesh& m) {
    return Hasher()
        .add(m.faceVertexCounts)
        .add(m.faceVertexIndices)
        .add(m.holeIndices)
        .add(int(m.scheme))
        .add(int(m.leftHanded))
        .add(m.cornerIndices)
        .add(m.cornerSharpnesses)
        .add(m.creaseIndices)
        .add(m.creaseLengths)
        .add(m.creaseSharpnesses)
        .add(m.interpolateBoundary)
        .add(m.faceVaryingInterpolation)
        .hash();
}

std::string restHash(const ControlMesh& m) {
    Hasher h;
    h.add(topologyHash(m)).add(m.uvs).add(m.uvIndices).add(m.orientation).add(int(m.orientationInterpolation));
    if (!m.rest.empty()) {
        // Authored normals belong to the pose; at rest they tell no more than whether the surface is smooth.
        return h.add("rest").add(m.rest).add(m.normals.empty() ? 0 : 1).hash();
    }
    return h.add(m.points).add(m.normals).add(int(m.normalInterpolation)).hash();
}

std::string poseHash(const ControlMesh& m) {
    return Hasher().add(m.points).add(m.normals).add(int(m.normalInterpolation)).hash();
}

} // namespace stf
