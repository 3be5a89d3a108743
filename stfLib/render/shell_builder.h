// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/renderer.h"
#include "stfLib/render/shell_object.h"

#include <map>

namespace stf {

/// Makes shells: reads base volumes, has their tables, refines the surface, maps, offsets and fills the grid. Keeps
/// volumes and tables of earlier calls, so that an edit of the mesh does not read them again. One thread at a time.
class ShellBuilder {
public:
    ShellBuilder(TableProvider tables, MessageSink messages)
        : tables_(std::move(tables)), messages_(std::move(messages)) {}

    /// Throws Error with the reason (without the prim's name), Cancelled.
    std::shared_ptr<ShellObject> build(const std::string& id, const ControlMesh& mesh, int refineLevel,
                                       const StfBinding& binding, double metersPerUnit, float sceneQuality,
                                       Progress& progress, RenderStats& stats, std::vector<PlanEntry>& plan);

private:
    std::shared_ptr<const BaseVolume> volume(const std::string& path);

    struct CachedVolume {
        long long modified = 0;
        std::uintmax_t size = 0;
        std::shared_ptr<const BaseVolume> volume;
    };
    TableProvider tables_;
    MessageSink messages_;
    std::map<std::string, CachedVolume> volumes_;
    std::map<std::string, std::shared_ptr<const StfTable>> tableOf_; ///< by volume hash and options
};

} // namespace stf
