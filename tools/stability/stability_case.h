// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/base/temporary_folder.h"

#include <functional>
#include <string>
#include <vector>

namespace stf {

/// What a run of a case found: numbers in a sentence, and whether what must hold does.
struct StabilityOutcome {
    std::string measured;
    bool ok = false;
};

/// What cases share while they run: a folder for files in between, and who may cancel.
struct StabilityRun {
    TemporaryFolder folder;
    Progress progress;
};

/// One stiff or extreme input and what must hold for it. Runs through the functions that the renderer itself uses.
struct StabilityCase {
    std::string id;       ///< "<point>.<name>": points 1 to 13 are those of docs/stability.md, "plan" stages left out
    std::string input;    ///< what is put in
    std::string mustHold; ///< with its bound
    bool slow = false;    ///< not part of a quick run
    bool knownLimit = false; ///< what must hold is that a known error is no larger than it is known to be
    std::function<StabilityOutcome(StabilityRun&)> run;
};

/// All cases, in the order of their points.
const std::vector<StabilityCase>& stabilityCases();

/// The cases that `only` names by id or by point ("8"); all where it is empty. Throws Error that names what is unknown.
std::vector<StabilityCase> chooseStabilityCases(const std::vector<std::string>& only, bool quick);

/// Runs a case; what it throws is an outcome that is not ok. Throws Cancelled.
StabilityOutcome runStabilityCase(const StabilityCase& c, StabilityRun& run);

// Each adds the cases of some points.
void addMarchCases(std::vector<StabilityCase>& all);    ///< 1
void addSlabCases(std::vector<StabilityCase>& all);     ///< 2, 7, 9
void addOpticsCases(std::vector<StabilityCase>& all);   ///< 4, 5
void addSceneCases(std::vector<StabilityCase>& all);    ///< 3, 6
void addLightCases(std::vector<StabilityCase>& all);    ///< 8
void addGeometryCases(std::vector<StabilityCase>& all); ///< 10
void addTableCases(std::vector<StabilityCase>& all);    ///< 11
void addRepeatCases(std::vector<StabilityCase>& all);   ///< 12, 13
void addLeftOutCases(std::vector<StabilityCase>& all);  ///< plan

/// printf into a string.
template<class... T>
std::string measuredText(const char* pattern, T... values) {
    char text[400];
    std::snprintf(text, sizeof text, pattern, values...);
    return text;
}

} // namespace stf
