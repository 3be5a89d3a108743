// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/shell_geometry.h"
#include "stfLib/render/shell_material.h"

namespace stf {

/// Makes shells, stage by stage: volume, transport, surface, mapping, grid, pose. Each stage is kept by a key of all it
/// reads until `dropUnused`, so that an edit redoes only what it touches and meshes that are alike share what they can.
/// One thread at a time.
class ShellBuilder {
public:
    ShellBuilder(TableProvider tables, MapProvider maps, MessageSink messages)
        : messages_(std::move(messages)), materials_(std::move(tables), messages_), mappings_(std::move(maps)) {}

    /// Throws Error with the reason (without the prim's name), Cancelled.
    std::shared_ptr<ShellObject> build(const std::string& id, const ControlMesh& mesh, int refineLevel,
                                       const StfBinding& binding, double metersPerUnit, const RenderSettings& settings,
                                       Progress& progress, RenderStats& stats, std::vector<PlanEntry>& plan);
    /// Forgets the results of stages that no shell is made of any more.
    void dropUnused();

private:
    MessageSink messages_;
    ShellMaterials materials_;
    ShellMappings mappings_;
    ShellGeometries geometries_;
};

} // namespace stf
