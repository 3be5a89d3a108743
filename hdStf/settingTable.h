// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

/// \file settingTable.h
/// The render settings and environment variables of hdStf, in one place: the delegate's descriptors, the panels of
/// hosts, the tables of docs/settings.md, and `stf settings` are made from it. Free of OpenUSD.

namespace stf {

/// In the type that the delegate keeps the setting in.
using SettingValue = std::variant<bool, int, float, double, std::string, std::array<float, 4>>;

struct SettingRow {
    /// What becomes of a number outside the range.
    enum class Outside { BroughtIn, Refused };

    std::string key;
    std::string name;     ///< as panels show it
    SettingValue own;     ///< the default, where the environment says nothing
    std::string variable; ///< of the environment; empty: none
    std::string meaning;  ///< in Markdown, without a full stop
    double least = -std::numeric_limits<double>::infinity();
    double most = std::numeric_limits<double>::infinity();
    bool aboveLeast = false; ///< `least` itself is outside
    Outside outside = Outside::Refused;
    std::vector<std::string> choices = {}; ///< of text; empty: any
    bool several = false;                  ///< of `choices`, separated by commas, or none
};

/// In the order in which panels show them.
const std::vector<SettingRow>& settingTable();

/// An environment variable that sets no render setting.
struct VariableRow {
    std::string name;
    std::string whenUnset; ///< in Markdown
    std::string meaning;   ///< in Markdown, without a full stop
};
const std::vector<VariableRow>& variableTable();

/// Names of all variables: of settings and others.
std::vector<std::string> variableNames();

/// "bool", "int", "float", "double", "string", "float4".
std::string settingType(const SettingValue& value);
/// As the documentation writes it, which a setting can be given as: `0.02`, `on`, `dE1`, `0 0 1 1`.
std::string settingText(const SettingValue& value);
/// What "on", "true", "off" and "false" say; nothing of any other text.
std::optional<bool> flagOfText(const std::string& text);
/// Whether a text is what a setting may be.
bool settingChooses(const SettingRow& row, const std::string& text);
/// Whether a number is within the range of a setting.
bool settingHolds(const SettingRow& row, double number);
/// Whether a setting that the environment gives as this text is taken (perhaps brought into its range).
bool settingTakes(const SettingRow& row, const std::string& text);
/// What a setting may be, in words: "at least 1", "`stf`, `reference`"; empty: anything of its type.
std::string settingRange(const SettingRow& row);

} // namespace stf
