// SPDX-License-Identifier: Apache-2.0
#include "scene_difference.h"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

namespace fuzz {

namespace {

class Lines {
public:
    template<class T>
    void check(const std::string& what, const T& a, const T& b) {
        if (!(a == b)) {
            add(what);
        }
    }
    void add(const std::string& what) {
        if (count_++ < 12) {
            text_ << "    " << what << "\n";
        }
    }
    std::string text() const { return text_.str(); }

private:
    std::ostringstream text_;
    int count_ = 0;
};

bool drawn(const stf::SceneMesh& m) {
    return m.visible && m.mesh && !m.instances.empty();
}

/// When an instance's motion is sampled.
std::string timesOf(const stf::MeshInstance& instance) {
    std::ostringstream text;
    text << "[";
    for (const stf::TransformSample& sample : instance.motion) {
        text << " " << sample.time;
    }
    text << " ]";
    return text.str();
}

void compareMeshes(const std::string& id, const stf::SceneMesh& a, const stf::SceneMesh& b, Lines& lines) {
    const stf::ControlMesh &m = *a.mesh, &n = *b.mesh;
    lines.check(id + ": face counts", m.faceVertexCounts, n.faceVertexCounts);
    lines.check(id + ": face indices", m.faceVertexIndices, n.faceVertexIndices);
    lines.check(id + ": holes", m.holeIndices, n.holeIndices);
    lines.check(id + ": points", m.points, n.points);
    lines.check(id + ": scheme", int(m.scheme), int(n.scheme));
    lines.check(id + ": orientation", m.leftHanded, n.leftHanded);
    lines.check(id + ": corners", m.cornerIndices, n.cornerIndices);
    lines.check(id + ": creases", m.creaseIndices, n.creaseIndices);
    lines.check(id + ": crease lengths", m.creaseLengths, n.creaseLengths);
    lines.check(id + ": sharpness", m.creaseSharpnesses, n.creaseSharpnesses);
    lines.check(id + ": boundary rule", m.interpolateBoundary, n.interpolateBoundary);
    lines.check(id + ": face-varying rule", m.faceVaryingInterpolation, n.faceVaryingInterpolation);
    lines.check(id + ": uvs", m.uvs, n.uvs);
    lines.check(id + ": uv indices", m.uvIndices, n.uvIndices);
    lines.check(id + ": normals", m.normals, n.normals);
    lines.check(id + ": colours", m.colors, n.colors);
    lines.check(id + ": rest pose", m.rest, n.rest);
    lines.check(id + ": directions", m.orientation, n.orientation);
    lines.check(id + ": refine level", a.refineLevel, b.refineLevel);
    lines.check(id + ": binding", a.stf, b.stf);
    lines.check(id + ": material \"" + a.material + "\", \"" + b.material + "\"", a.material, b.material);
    lines.check(id + ": parts", m.faceParts, n.faceParts);
    lines.check(id + ": materials of parts", a.partMaterials, b.partMaterials);
    lines.check(id + ": links", a.links, b.links);
    if (a.instances.size() != b.instances.size()) {
        lines.add(id + ": instances " + std::to_string(a.instances.size()) + ", " + std::to_string(b.instances.size()));
    } else {
        for (std::size_t i = 0; i < a.instances.size(); ++i) {
            const std::string one = id + ": instance " + std::to_string(i);
            lines.check(one + ": transform", a.instances[i].objectToWorld, b.instances[i].objectToWorld);
            lines.check(one + ": links", a.instances[i].links, b.instances[i].links);
            lines.check(one + ": motion, " + timesOf(a.instances[i]) + " and " + timesOf(b.instances[i]),
                        a.instances[i].motion, b.instances[i].motion);
        }
    }
}

template<class Map>
std::set<std::string> keysOf(const Map& a, const Map& b) {
    std::set<std::string> keys;
    for (const Map* map : {&a, &b}) {
        for (const auto& [key, value] : *map) {
            keys.insert(key);
        }
    }
    return keys;
}

template<class Map>
void compareMaps(const std::string& what, const Map& a, const Map& b, Lines& lines) {
    for (const std::string& key : keysOf(a, b)) {
        if (!a.count(key) || !b.count(key)) {
            lines.add(what + " " + key + ": only in the " + (a.count(key) ? "first" : "second"));
        } else {
            lines.check(what + " " + key, a.at(key), b.at(key));
        }
    }
}

/// UsdImaging finds materials by who is bound to them, and keeps those that nobody is bound to any more.
std::map<std::string, stf::PreviewSurface> boundMaterials(const stf::Scene& scene) {
    std::map<std::string, stf::PreviewSurface> bound;
    for (const auto& [id, mesh] : scene.meshes()) {
        const auto material = scene.materials().find(mesh.material);
        if (drawn(mesh) && material != scene.materials().end()) {
            bound.insert(*material);
        }
    }
    return bound;
}

} // namespace

std::string sceneDifference(const stf::Scene& a, const stf::Scene& b) {
    Lines lines;
    for (const std::string& id : keysOf(a.meshes(), b.meshes())) {
        const auto m = a.meshes().find(id), n = b.meshes().find(id);
        const bool inA = m != a.meshes().end() && drawn(m->second), inB = n != b.meshes().end() && drawn(n->second);
        if (inA != inB) {
            lines.add(id + ": drawn only in the " + (inA ? "first" : "second"));
        } else if (inA) {
            compareMeshes(id, m->second, n->second, lines);
        }
    }
    compareMaps("light", a.lights(), b.lights(), lines);
    compareMaps("material", boundMaterials(a), boundMaterials(b), lines);
    lines.check("metres per unit", a.metersPerUnit(), b.metersPerUnit());
    return lines.text();
}

} // namespace fuzz
