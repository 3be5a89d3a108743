// SPDX-License-Identifier: Apache-2.0
#include "tools/stability/stability_case.h"

#include <algorithm>

namespace stf {

namespace {

bool names(const std::string& wanted, const StabilityCase& c) {
    return c.id == wanted || c.id.compare(0, wanted.size() + 1, wanted + ".") == 0;
}

// "10.one-face": points in their order, those with a name behind those with a number.
int pointOf(const StabilityCase& c) {
    const int point = std::atoi(c.id.c_str());
    return point > 0 ? point : 1000;
}

} // namespace

const std::vector<StabilityCase>& stabilityCases() {
    static const std::vector<StabilityCase> cases = [] {
        std::vector<StabilityCase> all;
        addMarchCases(all);
        addSlabCases(all);
        addOpticsCases(all);
        addSceneCases(all);
        addLightCases(all);
        addGeometryCases(all);
        addTableCases(all);
        addRepeatCases(all);
        addLeftOutCases(all);
        std::stable_sort(all.begin(), all.end(),
                         [](const StabilityCase& a, const StabilityCase& b) { return pointOf(a) < pointOf(b); });
        return all;
    }();
    return cases;
}

std::vector<StabilityCase> chooseStabilityCases(const std::vector<std::string>& only, bool quick) {
    const std::vector<StabilityCase>& all = stabilityCases();
    for (const std::string& wanted : only) {
        if (std::none_of(all.begin(), all.end(), [&](const StabilityCase& c) { return names(wanted, c); })) {
            throw Error("no stability case \"" + wanted + "\"; there are points 1 to 13, plan, and the cases that " +
                        "`stf stability --list` tells");
        }
    }
    std::vector<StabilityCase> chosen;
    for (const StabilityCase& c : all) {
        const bool asked = std::any_of(only.begin(), only.end(), [&](const std::string& w) { return names(w, c); });
        if ((only.empty() || asked) && !(quick && c.slow)) {
            chosen.push_back(c);
        }
    }
    return chosen;
}

StabilityOutcome runStabilityCase(const StabilityCase& c, StabilityRun& run) {
    try {
        return c.run(run);
    } catch (const Cancelled&) {
        throw;
    } catch (const std::exception& e) {
        return {std::string("failed: ") + e.what(), false};
    }
}

} // namespace stf
