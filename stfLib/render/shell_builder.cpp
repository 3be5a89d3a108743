// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shell_builder.h"

namespace stf {

std::shared_ptr<ShellObject> ShellBuilder::build(const std::string& id, const ControlMesh& mesh, int refineLevel,
                                                 const StfBinding& binding, double metersPerUnit,
                                                 const RenderSettings& settings, Progress& progress, RenderStats& stats,
                                                 std::vector<PlanEntry>& plan) {
    const MessageSink messages = [&](Severity severity, const std::string& text) {
        report(messages_, severity, id + ": " + text);
    };
    const ShellStage stage{id, settings, messages, progress, stats, plan};
    auto shell = std::make_shared<ShellObject>();
    materials_.prepare(binding, metersPerUnit, stage, *shell);
    const MappedSurface mapped =
        mappings_.prepare(mesh, refineLevel, binding, *shell, materials_.contentHash(shell->source), stage);
    materials_.addLevels(binding, mapped.blend != nullptr, stage, *shell);
    geometries_.prepare(mapped, stage, *shell);
    return shell;
}

void ShellBuilder::dropUnused() {
    geometries_.dropUnused(); // first: it holds what the others made
    mappings_.dropUnused();
    materials_.dropUnused();
}

} // namespace stf
