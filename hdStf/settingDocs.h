// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace stf {

/// The tables of docs/settings.md as Markdown: render settings, other environment variables.
std::string settingTableMarkdown();
std::string variableTableMarkdown();

/// A document with these tables between its lines `<!-- stf settings: NAME -->` and `<!-- end -->`, NAME `settings` or
/// `environment`. Throws Error where a mark is missing.
std::string withSettingTables(const std::string& document);

} // namespace stf
