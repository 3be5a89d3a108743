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
    if (a.instances.size() != b.instances.size()) {
        lines.add(id + ": instances " + std::to_string(a.instances.size()) + ", " + std::to_string(b.instances.size()));
    } else {
        for (std::size_t i = 0; i < a.instances.size(); ++i) {
            const std::string one = id + ": instance " + std::to_string(i);
            lines.check(one + ": transform", a.instances[i].objectToWorld, b.instances[i].objectToWorld);
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

bool has(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

/// Which drawn meshes and instances belong to a link of a light.
std::set<std::string> membersOf(const stf::Scene& scene, const std::string& link, const HostNames& names) {
    std::set<std::string> members;
    for (const auto& [id, mesh] : scene.meshes()) {
        for (std::size_t i = 0; drawn(mesh) && i < mesh.instances.size(); ++i) {
            if (link.empty() || has(mesh.links, link) || has(mesh.instances[i].links, link)) {
                members.insert(nameInFirst(names, id) + " " + std::to_string(i));
            }
        }
    }
    return members;
}

/// Links are compared by their members: UsdImaging goes on with the name of a light that is gone, for whichever other
/// light has the same members.
void compareLinks(const stf::Scene& a, const stf::Scene& b, const HostNames& names, Lines& lines) {
    for (const auto& [id, light] : a.lights()) {
        const auto other = b.lights().find(id);
        if (other != b.lights().end()) {
            lines.check("light " + id + ": whom it lights", membersOf(a, light.lightLink, {}),
                        membersOf(b, other->second.lightLink, names));
            lines.check("light " + id + ": who throws its shadows", membersOf(a, light.shadowLink, {}),
                        membersOf(b, other->second.shadowLink, names));
        }
    }
}

std::map<std::string, stf::Light> withoutLinks(std::map<std::string, stf::Light> lights) {
    for (auto& [id, light] : lights) {
        light.lightLink.clear();
        light.shadowLink.clear();
    }
    return lights;
}

using Meshes = std::map<std::string, stf::SceneMesh>;

/// What is drawn, by the names of the first scene.
Meshes drawnMeshes(const stf::Scene& scene, const HostNames& names) {
    Meshes meshes;
    for (const auto& [id, mesh] : scene.meshes()) {
        if (drawn(mesh)) {
            meshes.emplace(nameInFirst(names, id), mesh);
        }
    }
    return meshes;
}

/// What follows the name of the native instance that came first, in the name of what all of them share: a property of
/// that prim (20.08) or a prim below it. Empty for other names.
std::string sharedLeaf(const std::string& id) {
    const std::string leaf = id.substr(id.find_last_of("./") + 1);
    return leaf.rfind("proto_", 0) == 0 ? leaf : std::string();
}

} // namespace

std::string nameInFirst(const HostNames& names, const std::string& id) {
    const auto name = names.find(id);
    return name == names.end() ? id : name->second;
}

HostNames hostNames(const stf::Scene& a, const stf::Scene& b) {
    Meshes first = drawnMeshes(a, {}), second = drawnMeshes(b, {});
    HostNames names;
    for (const auto& [id, mesh] : second) {
        const std::string leaf = sharedLeaf(id);
        if (leaf.empty() || first.count(id)) {
            continue;
        }
        const auto same = std::find_if(first.begin(), first.end(), [&](const auto& entry) {
            return !second.count(entry.first) && sharedLeaf(entry.first) == leaf &&
                   entry.second.instances == mesh.instances;
        });
        if (same != first.end()) {
            names[id] = same->first;
            first.erase(same);
        }
    }
    return names;
}

std::string sceneDifference(const stf::Scene& a, const stf::Scene& b) {
    Lines lines;
    const HostNames names = hostNames(a, b);
    const Meshes first = drawnMeshes(a, {}), second = drawnMeshes(b, names);
    for (const std::string& id : keysOf(first, second)) {
        const auto m = first.find(id), n = second.find(id);
        if (m == first.end() || n == second.end()) {
            lines.add(id + ": drawn only in the " + (n == second.end() ? "first" : "second"));
        } else {
            compareMeshes(id, m->second, n->second, lines);
        }
    }
    compareMaps("light", withoutLinks(a.lights()), withoutLinks(b.lights()), lines);
    compareLinks(a, b, names, lines);
    compareMaps("material", boundMaterials(a), boundMaterials(b), lines);
    lines.check("metres per unit", a.metersPerUnit(), b.metersPerUnit());
    return lines.text();
}

} // namespace fuzz
