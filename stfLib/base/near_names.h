// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace stf {

/// A name as names are compared: lower case, without spaces, hyphens and underscores.
std::string comparableName(const std::string& name);

/// The candidates that someone who wrote `name` may have meant, the nearest first, at most `most`: those within a third
/// of the name's length in edits (Levenshtein 1966: insert, remove, replace, each counts one), at least two, and those
/// that hold the name or are held by it. Names are compared as by `comparableName`.
std::vector<std::string> nearNames(const std::string& name, const std::vector<std::string>& candidates,
                                   std::size_t most = 3);

/// " (did you mean a, b or c?)", empty where nothing is near: to end a message with.
std::string didYouMean(const std::string& name, const std::vector<std::string>& candidates);

} // namespace stf
