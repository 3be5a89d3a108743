// SPDX-License-Identifier: Apache-2.0
#include "tools/doctor/environment_checks.h"

#include "hdStf/settingTable.h"
#include "stfLib/base/near_names.h"

#include <algorithm>

extern char** environ;

namespace stf::doctor {

namespace {

const char* const kPluginPath = "PXR_PLUGINPATH_NAME";

/// The setting that a variable sets; null: none.
const SettingRow* settingOf(const std::string& variable) {
    for (const SettingRow& row : settingTable()) {
        if (row.variable == variable) {
            return &row;
        }
    }
    return nullptr;
}

bool startsWith(const std::string& text, const std::string& start) {
    return text.rfind(start, 0) == 0;
}

} // namespace

Variables environmentVariables() {
    Variables variables;
    for (char** entry = environ; entry && *entry; ++entry) {
        const std::string text = *entry;
        const std::size_t equals = text.find('=');
        if (equals != std::string::npos) {
            variables.emplace_back(text.substr(0, equals), text.substr(equals + 1));
        }
    }
    std::sort(variables.begin(), variables.end());
    return variables;
}

Findings checkEnvironment(const Variables& variables) {
    Findings findings;
    const std::vector<std::string> known = variableNames();
    for (const auto& [name, value] : variables) {
        if (startsWith(name, "PXR_PLUGIN") && name != kPluginPath) {
            findings.push_back(warning("environment", name + " is set, which OpenUSD does not read",
                                       std::string("the variable is called ") + kPluginPath));
        }
        if (!startsWith(name, "HDSTF_")) {
            continue;
        }
        if (std::find(known.begin(), known.end(), name) == known.end()) {
            findings.push_back(warning("environment", name + " is no variable of hdStf" + didYouMean(name, known),
                                       "`stf settings` lists those that there are"));
            continue;
        }
        const SettingRow* const row = settingOf(name);
        if (row && !value.empty() && !settingTakes(*row, value)) {
            const std::string range = settingRange(*row);
            findings.push_back(warning("environment",
                                       name + "=" + value + " is no value of " + row->key + ", whose default counts",
                                       "it is of type " + settingType(row->own) + (range.empty() ? "" : ": " + range)));
        } else {
            findings.push_back(ok("environment", name + "=" + value));
        }
    }
    return findings;
}

} // namespace stf::doctor
