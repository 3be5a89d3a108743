// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/scene.h"

namespace stf {

void Scene::setMesh(const std::string& id, ControlMesh mesh, int refineLevel) {
    auto shared = std::make_shared<const ControlMesh>(std::move(mesh));
    const std::lock_guard<std::mutex> lock(mutex_);
    SceneMesh& m = meshes_[id];
    m.mesh = std::move(shared);
    m.refineLevel = refineLevel;
    m.meshVersion = ++version_;
}

void Scene::setStf(const std::string& id, std::optional<StfBinding> binding) {
    const std::lock_guard<std::mutex> lock(mutex_);
    SceneMesh& m = meshes_[id];
    if (!(m.stf == binding)) {
        m.stf = std::move(binding);
        m.stfVersion = ++version_;
    }
}

void Scene::setInstances(const std::string& id, std::vector<MeshInstance> instances) {
    const std::lock_guard<std::mutex> lock(mutex_);
    SceneMesh& m = meshes_[id];
    if (m.instances != instances) {
        m.instances = std::move(instances);
        m.instanceVersion = ++version_;
    }
}

void Scene::setPrimId(const std::string& id, std::int32_t primId) {
    const std::lock_guard<std::mutex> lock(mutex_);
    SceneMesh& m = meshes_[id];
    if (m.primId != primId) {
        m.primId = primId;
        m.instanceVersion = ++version_;
    }
}

void Scene::setVisible(const std::string& id, bool visible) {
    const std::lock_guard<std::mutex> lock(mutex_);
    SceneMesh& m = meshes_[id];
    if (m.visible != visible) {
        m.visible = visible;
        m.instanceVersion = ++version_;
    }
}

void Scene::setMeshMaterial(const std::string& id, const std::string& material) {
    const std::lock_guard<std::mutex> lock(mutex_);
    SceneMesh& m = meshes_[id];
    if (m.material != material) {
        m.material = material;
        m.instanceVersion = ++version_;
    }
}

void Scene::setPartMaterials(const std::string& id, std::vector<std::string> materials) {
    const std::lock_guard<std::mutex> lock(mutex_);
    SceneMesh& m = meshes_[id];
    if (m.partMaterials != materials) {
        m.partMaterials = std::move(materials);
        m.instanceVersion = ++version_;
    }
}

void Scene::setLinks(const std::string& id, std::vector<std::string> links) {
    const std::lock_guard<std::mutex> lock(mutex_);
    SceneMesh& m = meshes_[id];
    if (m.links != links) {
        m.links = std::move(links);
        m.instanceVersion = ++version_;
    }
}

void Scene::setMaterial(const std::string& id, const PreviewSurface& surface) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto [it, isNew] = materials_.try_emplace(id, surface);
    if (isNew || !(it->second == surface)) {
        it->second = surface;
        ++version_;
    }
}

void Scene::removeMaterial(const std::string& id) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (materials_.erase(id)) {
        ++version_;
    }
}

void Scene::removeMesh(const std::string& id) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (meshes_.erase(id)) {
        ++version_;
    }
}

void Scene::setLight(const std::string& id, const Light& light) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto it = lights_.find(id);
    if (it == lights_.end() || !(it->second == light)) {
        lights_[id] = light;
        lightVersion_ = ++version_;
    }
}

void Scene::removeLight(const std::string& id) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (lights_.erase(id)) {
        lightVersion_ = ++version_;
    }
}

void Scene::setMetersPerUnit(double metersPerUnit) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (metersPerUnit > 0 && std::isfinite(metersPerUnit) && metersPerUnit != metersPerUnit_) {
        metersPerUnit_ = metersPerUnit;
        ++version_;
    }
}

} // namespace stf
