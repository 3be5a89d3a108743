// SPDX-License-Identifier: Apache-2.0
#include "hdStf/settingDocs.h"

#include "hdStf/settingTable.h"
#include "stfLib/base/error.h"

namespace stf {

namespace {

std::string code(const std::string& text) {
    return text.empty() ? "" : "`" + text + "`";
}

void replaceBetween(std::string& document, const std::string& name, const std::string& table) {
    const std::string begin = "<!-- stf settings: " + name + " -->\n", end = "<!-- end -->";
    const std::size_t start = document.find(begin);
    const std::size_t stop = start == std::string::npos ? start : document.find(end, start);
    if (stop == std::string::npos) {
        throw Error("the document has no part between \"<!-- stf settings: " + name + " -->\" and \"" + end + "\"");
    }
    const std::size_t from = start + begin.size();
    document.replace(from, stop - from, "\n" + table + "\n");
}

} // namespace

std::string settingTableMarkdown() {
    std::string text = "| key | type | default | values | environment | meaning |\n|---|---|---|---|---|---|\n";
    for (const SettingRow& row : settingTable()) {
        const bool word = std::holds_alternative<std::string>(row.own);
        const std::string own = settingText(row.own);
        text += "| " + code(row.key) + " | " + settingType(row.own) + " | " + (word ? code(own) : own) + " | " +
                settingRange(row) + " | " + code(row.variable) + " | " + row.meaning + " |\n";
    }
    return text;
}

std::string variableTableMarkdown() {
    std::string text = "| environment | where it is not set | meaning |\n|---|---|---|\n";
    for (const VariableRow& row : variableTable()) {
        text += "| " + code(row.name) + " | " + row.whenUnset + " | " + row.meaning + " |\n";
    }
    return text;
}

std::string withSettingTables(const std::string& document) {
    std::string text = document;
    replaceBetween(text, "settings", settingTableMarkdown());
    replaceBetween(text, "environment", variableTableMarkdown());
    return text;
}

} // namespace stf
