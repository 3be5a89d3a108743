// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/motion.h"
#include "stfLib/render/light.h"
#include "stfLib/render/preview_surface.h"
#include "stfLib/render/stf_binding.h"
#include "stfLib/surface/control_mesh.h"

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace stf {

/// One instance of a mesh.
struct MeshInstance {
    Transform objectToWorld; ///< at the present time
    std::int32_t instanceId = 0;
    std::vector<TransformSample> motion; ///< objectToWorld around it; empty: at rest
    std::string name = {};               ///< by which cryptomattes know it; empty: the mesh's id
    /// Which of the light and shadow links (`Light`) it belongs to, beside those of the mesh.
    std::vector<std::string> links = {};
    bool operator==(const MeshInstance& i) const {
        return objectToWorld == i.objectToWorld && instanceId == i.instanceId && motion == i.motion && name == i.name &&
               links == i.links;
    }
};

/// A mesh with all that a host says of it. Version numbers grow with each change, so that `Renderer::prepare` knows
/// what to redo; setting a value to itself changes nothing.
struct SceneMesh {
    std::shared_ptr<const ControlMesh> mesh;
    int refineLevel = 0;
    std::optional<StfBinding> stf;
    std::string material; ///< id of what is bound; empty or unknown: displayColor
    /// Of parts from 1 on (`ControlMesh::faceParts`); part 0, and what is not listed, has `material`.
    std::vector<std::string> partMaterials;
    std::vector<MeshInstance> instances;
    std::vector<std::string> links; ///< which light and shadow links (`Light`) it belongs to
    std::int32_t primId = 0;
    bool visible = true;
    std::uint64_t meshVersion = 0, stfVersion = 0, instanceVersion = 0;
};

/// What is to be rendered, as plain values. Every setter is thread-safe (hosts sync prims in parallel) but must not run
/// while a Renderer prepares or renders: the host stops rendering first (the delegate's edit gate).
class Scene {
public:
    void setMesh(const std::string& id, ControlMesh mesh, int refineLevel);
    void setStf(const std::string& id, std::optional<StfBinding> binding);
    void setInstances(const std::string& id, std::vector<MeshInstance> instances);
    void setPrimId(const std::string& id, std::int32_t primId);
    void setVisible(const std::string& id, bool visible);
    /// Which material a mesh has; it need not be there (yet).
    void setMeshMaterial(const std::string& id, const std::string& material);
    /// The same for its parts from 1 on.
    void setPartMaterials(const std::string& id, std::vector<std::string> materials);
    /// The light and shadow links that it belongs to.
    void setLinks(const std::string& id, std::vector<std::string> links);
    void removeMesh(const std::string& id);

    void setMaterial(const std::string& id, const PreviewSurface& surface);
    void removeMaterial(const std::string& id);

    void setLight(const std::string& id, const Light& light);
    void removeLight(const std::string& id);

    /// Metres per object unit; default 0.01, USD's own.
    void setMetersPerUnit(double metersPerUnit);

    // For the renderer.
    const std::map<std::string, SceneMesh>& meshes() const { return meshes_; }
    const std::map<std::string, PreviewSurface>& materials() const { return materials_; }
    const std::map<std::string, Light>& lights() const { return lights_; }
    double metersPerUnit() const { return metersPerUnit_; }
    /// Grows with every change of any kind.
    std::uint64_t version() const { return version_; }
    std::uint64_t lightVersion() const { return lightVersion_; }

private:
    std::mutex mutex_;
    std::map<std::string, SceneMesh> meshes_;
    std::map<std::string, PreviewSurface> materials_;
    std::map<std::string, Light> lights_;
    double metersPerUnit_ = 0.01;
    std::uint64_t version_ = 1, lightVersion_ = 1;
};

} // namespace stf
