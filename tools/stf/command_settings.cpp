// SPDX-License-Identifier: Apache-2.0
#include "hdStf/settingDocs.h"
#include "hdStf/settingTable.h"
#include "stfLib/base/error.h"
#include "tools/stf/commands.h"
#include "tools/stfrecord/atomicFile.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

namespace stf {

namespace {

struct Arguments {
    std::string update;
    bool json = false;
};

nlohmann::ordered_json asJson() {
    nlohmann::ordered_json settings = nlohmann::ordered_json::array();
    for (const SettingRow& row : settingTable()) {
        nlohmann::ordered_json j{{"key", row.key}, {"type", settingType(row.own)}};
        if (std::holds_alternative<float>(row.own)) {
            j["default"] = std::stod(settingText(row.own)); // 0.02, not the float's neighbour in double
        } else {
            std::visit([&j](const auto& own) { j["default"] = own; }, row.own);
        }
        j["environment"] = row.variable;
        j["name"] = row.name;
        j["meaning"] = row.meaning;
        if (std::isfinite(row.least)) {
            j["least"] = row.least;
        }
        if (std::isfinite(row.most)) {
            j["most"] = row.most;
        }
        if (!row.choices.empty()) {
            j["choices"] = row.choices;
            j["several"] = row.several;
        }
        settings.push_back(j);
    }
    nlohmann::ordered_json variables = nlohmann::ordered_json::array();
    for (const VariableRow& row : variableTable()) {
        variables.push_back({{"name", row.name}, {"whenUnset", row.whenUnset}, {"meaning", row.meaning}});
    }
    return {{"settings", settings}, {"environment", variables}};
}

void update(const std::string& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    if (!file) {
        throw Error(path + ": cannot be read");
    }
    std::string changed;
    try {
        changed = withSettingTables(text.str());
    } catch (const Error& e) {
        throw Error(path + ": " + e.what());
    }
    stfrecord::writeAtomically(path, [&](const std::string& temporary) {
        std::ofstream out(temporary);
        out << changed;
        out.close();
        if (!out) {
            throw Error(path + ": cannot be written");
        }
    });
}

void run(const Arguments& a) {
    if (!a.update.empty()) {
        update(a.update);
    } else if (a.json) {
        std::printf("%s\n", asJson().dump().c_str());
    } else {
        std::printf("%s\n%s", settingTableMarkdown().c_str(), variableTableMarkdown().c_str());
    }
}

} // namespace

void addSettingsCommand(CLI::App& app) {
    auto* command = app.add_subcommand("settings", "Print the renderer's settings and environment variables");
    auto a = std::make_shared<Arguments>();
    command->add_option("--update", a->update, "Write both tables into this document instead (docs/settings.md)");
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] { run(*a); });
}

} // namespace stf
