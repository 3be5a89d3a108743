// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/shell_object.h"
#include "stfLib/render/shell_stage.h"
#include "stfLib/render/stage_cache.h"
#include "stfLib/synthesis/blend_map.h"
#include "stfLib/synthesis/choose_mapping.h"

namespace stf {

/// A surface at rest with its exemplar coordinates, and how it is seen now.
struct MappedSurface {
    std::string key;     ///< of all that surface and map were made from
    std::string poseKey; ///< of the pose besides; empty where it is seen at rest
    std::shared_ptr<const MappingChoice> choice;
    std::shared_ptr<const RefinedSurface> surface;
    std::shared_ptr<const ExemplarMap> map;
    std::shared_ptr<const BlendMap> blend;       ///< holds `map` where the mapping is Blend; else null
    std::shared_ptr<const RefinedSurface> posed; ///< null: it is seen at rest
};

/// The stages from a mesh to exemplar coordinates on its sampled surface: which mapping, the limit surface (sampled
/// finely for synthesis), the map. None depends on the shell's thickness where the sample is synthesised, and only the
/// posed points depend on the pose of a mesh with a rest pose.
class ShellMappings {
public:
    explicit ShellMappings(MapProvider maps) : maps_(std::move(maps)) {}

    /// `shell` has its volumes and scale; `volumeHash` is that of its source. `mesh` is sanitized. Throws Error,
    /// Cancelled.
    MappedSurface prepare(const ControlMesh& mesh, int refineLevel, const StfBinding& binding, const ShellObject& shell,
                          const std::string& volumeHash, const ShellStage& stage);
    void dropUnused();

private:
    struct Sampling;
    struct Sampled;
    Sampled refined(const ControlMesh& mesh, const Sampling& how, const ShellStage& stage) const;
    Sampled sampled(Sampled refined, const Sampling& how, const ShellStage& stage) const;
    void addMap(const StfBinding& binding, const ShellObject& shell, const std::string& volumeHash,
                const ShellStage& stage, MappedSurface& mapped);
    void noticeMotion(const ControlMesh& mesh, const ShellStage& stage);

    MapProvider maps_;
    StageCache<MappingChoice> choices_;
    StageCache<RefinedSurface> surfaces_, poses_;
    StageCache<ExemplarMap> exemplarMaps_;
    StageCache<BlendMap> blendMaps_;
    struct Seen {
        std::string topology, points;
    };
    std::map<std::string, Seen> seen_; ///< of each prim without a rest pose that was synthesised
};

} // namespace stf
