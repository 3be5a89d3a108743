// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/renderer.h"
#include "stfLib/render/shell_object.h"

#include <map>

namespace stf {

/// Makes shells: reads base volumes, has their tables, refines the surface, maps, offsets and fills the grid. Keeps
/// volumes and tables of earlier calls until `dropUnused`, so that an edit of the mesh does not read them again and
/// meshes of one material share them. One thread at a time.
class ShellBuilder {
public:
    ShellBuilder(TableProvider tables, MessageSink messages)
        : tables_(std::move(tables)), messages_(std::move(messages)) {}

    /// Throws Error with the reason (without the prim's name), Cancelled.
    std::shared_ptr<ShellObject> build(const std::string& id, const ControlMesh& mesh, int refineLevel,
                                       const StfBinding& binding, double metersPerUnit, const RenderSettings& settings,
                                       Progress& progress, RenderStats& stats, std::vector<PlanEntry>& plan);
    /// Forgets volumes and tables that nobody else holds.
    void dropUnused();

private:
    std::shared_ptr<const BaseVolume> volume(const std::string& path);

    struct CachedVolume {
        long long modified = 0;
        std::uintmax_t size = 0;
        std::shared_ptr<const BaseVolume> volume;
    };
    struct CachedTransport {
        std::shared_ptr<const StfTable> table;
        std::shared_ptr<const TileMedium> medium;
    };
    TableProvider tables_;
    MessageSink messages_;
    std::map<std::string, CachedVolume> volumes_;
    std::map<std::string, CachedTransport> transports_; ///< by volume hash and options
};

} // namespace stf
