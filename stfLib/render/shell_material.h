// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/shell_object.h"
#include "stfLib/render/shell_stage.h"
#include "stfLib/render/stage_cache.h"
#include "stfLib/transport/precompute.h"

namespace stf {

/// The tables that a binding asks for, or else the settings. Throws Error on a quality that is none; a form that does
/// not exist is reported, and the default taken.
TransportOptions tableOptions(const StfBinding& binding, const RenderSettings& settings, const MessageSink& messages);
/// Layers of a sample that a shell shows: `wantedMm` deep, or all where that is 0 or more than there are.
int layersOfShell(const BaseVolume& sample, double wantedMm);

/// The stages of a shell that do not depend on the mesh: base volumes, their crops, transport tables and the core.
class ShellMaterials {
public:
    ShellMaterials(TableProvider tables, MessageSink messages)
        : tables_(std::move(tables)), messages_(std::move(messages)) {}

    /// Fills volumes, scale, thickness, core, table and medium of a shell. Throws Error with the reason.
    void prepare(const StfBinding& binding, double metersPerUnit, const ShellStage& stage, ShellObject& shell);
    /// Adds what pixels of any footprint read: coarser levels of the tile and, where the surface blends, their mixers.
    void addLevels(const StfBinding& binding, bool blends, const ShellStage& stage, ShellObject& shell);
    /// `prepare`d volumes by their content: what the stages of the surface depend on.
    std::string contentHash(const std::shared_ptr<const BaseVolume>& volume);
    void dropUnused();

private:
    struct CachedVolume {
        long long modified = 0;
        std::uintmax_t size = 0;
        std::shared_ptr<const BaseVolume> volume;
    };
    struct Transport {
        std::shared_ptr<const StfTable> table;
        std::shared_ptr<const TileMedium> medium;
    };

    std::shared_ptr<const BaseVolume> volume(const std::string& path);
    void crop(const StfBinding& binding, const ShellStage& stage, ShellObject& shell);
    void subdivideLit(const ShellStage& stage, ShellObject& shell);
    void addTransport(const StfBinding& binding, const ShellStage& stage, ShellObject& shell);

    TableProvider tables_;
    MessageSink messages_;
    std::map<std::string, CachedVolume> volumes_;
    StageCache<TilePyramid> pyramids_;
    StageCache<std::vector<std::shared_ptr<const HistogramBlend>>> mixers_;
    StageCache<BaseVolume> crops_;                                                     ///< by content and layers
    std::map<std::string, Transport> transports_;                                      ///< by content and options
    std::map<std::weak_ptr<const BaseVolume>, std::string, std::owner_less<>> hashes_; ///< of volumes in memory
};

} // namespace stf
