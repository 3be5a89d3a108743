// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/near_names.h"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace stf {

namespace {

std::size_t editDistance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t(0));
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
        }
    }
    return row[b.size()];
}

// Shorter ones are in nearly everything.
constexpr std::size_t kShortestPart = 3;

} // namespace

std::string comparableName(const std::string& name) {
    std::string result;
    for (const char c : name) {
        if (c != ' ' && c != '-' && c != '_') {
            result += char(std::tolower(static_cast<unsigned char>(c)));
        }
    }
    return result;
}

std::vector<std::string> nearNames(const std::string& name, const std::vector<std::string>& candidates,
                                   std::size_t most) {
    const std::string wanted = comparableName(name);
    std::vector<std::pair<std::size_t, std::string>> found;
    for (const std::string& candidate : candidates) {
        const std::string text = comparableName(candidate);
        const std::size_t distance = editDistance(wanted, text);
        const bool part = std::min(wanted.size(), text.size()) >= kShortestPart &&
                          (text.find(wanted) != std::string::npos || wanted.find(text) != std::string::npos);
        if (part || distance <= std::max<std::size_t>(2, wanted.size() / 3)) {
            found.emplace_back(distance, candidate);
        }
    }
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::string> result;
    for (std::size_t i = 0; i < std::min(most, found.size()); ++i) {
        result.push_back(found[i].second);
    }
    return result;
}

std::string didYouMean(const std::string& name, const std::vector<std::string>& candidates) {
    const std::vector<std::string> near = nearNames(name, candidates);
    std::string text;
    for (std::size_t i = 0; i < near.size(); ++i) {
        text += (i == 0 ? " (did you mean " : i + 1 == near.size() ? " or " : ", ") + near[i];
    }
    return text.empty() ? text : text + "?)";
}

} // namespace stf
