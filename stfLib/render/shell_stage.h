// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/renderer.h"

#include <chrono>

namespace stf {

/// What the stages of one mesh's preparation report to.
struct ShellStage {
    const std::string& id;
    const RenderSettings& settings;
    MessageSink messages; ///< puts the prim in front
    Progress& progress;
    RenderStats& stats;
    std::vector<PlanEntry>& plan;

    void note(const char* stage, bool runs, const std::string& why, double seconds) const {
        plan.push_back({id, stage, runs, why, seconds});
    }
    /// The same for a stage whose result may be there already.
    void noteKept(const char* stage, bool kept, const std::string& why, double seconds) const {
        note(stage, !kept, kept ? why + "; already in memory" : why, seconds);
    }
};

class StageTimer {
public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace stf
