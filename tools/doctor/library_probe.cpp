// SPDX-License-Identifier: Apache-2.0
#include "tools/doctor/library_probe.h"

#include "stfLib/base/error.h"
#include "stfLib/base/temporary_folder.h"
#include "tools/stf/run_program.h"

#include <cstdio>
#include <cstring>
#include <cxxabi.h>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>

namespace stf::doctor {

namespace {

namespace fs = std::filesystem;

/// "..: undefined symbol: _ZN..Ev" with the symbol as it is written in C++.
std::string readable(const std::string& error) {
    const std::size_t at = error.rfind("_Z");
    if (at == std::string::npos) {
        return error;
    }
    const std::size_t end = error.find_first_of(" ,)", at);
    const std::string symbol = error.substr(at, end == std::string::npos ? end : end - at);
    int status = 0;
    const std::unique_ptr<char, void (*)(void*)> name(abi::__cxa_demangle(symbol.c_str(), nullptr, nullptr, &status),
                                                      std::free);
    return status == 0 ? error.substr(0, at) + name.get() + (end == std::string::npos ? "" : error.substr(end)) : error;
}

} // namespace

ProbedLibrary probeLibrary(const std::string& probe, const std::string& library,
                           const std::vector<std::string>& before) {
    const TemporaryFolder folder;
    std::vector<std::string> words = {probe};
    words.insert(words.end(), before.begin(), before.end());
    words.push_back(library);
    ProgramRun how;
    how.standardOutput = folder.file("told.json");
    how.standardError = folder.file("errors");
    how.mostSeconds = 120;
    const ProgramEnd end = runProgram(words, how);
    ProbedLibrary probed;
    if (end.signal != 0) {
        probed.error = end.timedOut ? "loading it does not end"
                                    : std::string("loading it ends the process: ") + ::strsignal(end.signal);
        return probed;
    }
    // Libraries may print what they like before the line.
    std::ifstream file(how.standardOutput);
    nlohmann::json told;
    for (std::string line; std::getline(file, line);) {
        if (const auto j = nlohmann::json::parse(line, nullptr, false); j.is_object() && j.contains("loaded")) {
            told = j;
        }
    }
    if (!told.is_object()) {
        probed.error = "loading it ends the process with " + std::to_string(end.code);
        return probed;
    }
    probed.loaded = told["loaded"];
    probed.error = readable(told["error"]);
    probed.libraries = told["libraries"].get<std::vector<std::string>>();
    return probed;
}

std::string openUsdNamespace(const std::string& library) {
    // Names of classes are in the tables of symbols as "N<length>pxrInternal_v0_24__pxrReserved__16HdRenderDelegateE".
    static const std::string ending = "__pxrReserved__";
    std::ifstream file(library, std::ios::binary);
    std::string kept;
    std::string block(1 << 20, '\0');
    while (file) {
        file.read(block.data(), std::streamsize(block.size()));
        kept.append(block, 0, std::size_t(file.gcount()));
        for (std::size_t at = kept.find(ending); at != std::string::npos; at = kept.find(ending, at + 1)) {
            std::size_t first = at;
            while (first > 0 && (std::isalnum(static_cast<unsigned char>(kept[first - 1])) || kept[first - 1] == '_')) {
                --first;
            }
            const std::string word = kept.substr(first, at - first);
            if (const std::size_t pxr = word.rfind("pxr");
                pxr != std::string::npos && pxr > 0 && std::isdigit(static_cast<unsigned char>(word[pxr - 1]))) {
                return word.substr(pxr);
            }
        }
        kept.erase(0, kept.size() - std::min<std::size_t>(kept.size(), 256)); // a name may lie across two blocks
    }
    return {};
}

std::string openUsdVersionBeside(const std::string& library) {
    std::error_code error;
    const fs::path real = fs::canonical(library, error);
    std::ifstream file(real.parent_path().parent_path() / "include" / "pxr" / "pxr.h");
    std::string minor, patch;
    const std::regex line(R"(#define PXR_(MINOR|PATCH)_VERSION (\d+))");
    std::smatch match;
    for (std::string text; std::getline(file, text);) {
        if (std::regex_search(text, match, line)) {
            (match[1] == "MINOR" ? minor : patch) = match[2];
        }
    }
    if (minor.empty() || patch.empty()) {
        return {};
    }
    return minor + "." + (patch.size() == 1 ? "0" + patch : patch);
}

} // namespace stf::doctor
