// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace stf::doctor {

/// What came of loading a library in a process of its own.
struct ProbedLibrary {
    bool loaded = false;
    std::string error;                  ///< the loader's, names demangled; without a full stop
    std::vector<std::string> libraries; ///< that are loaded then, by path
};

/// Loads `library` with all its symbols, by the program `probe` (stf-probe), after the libraries `before`, which stand
/// for a host. Throws Error where the probe itself cannot be started.
ProbedLibrary probeLibrary(const std::string& probe, const std::string& library,
                           const std::vector<std::string>& before = {});

/// The internal namespace of OpenUSD whose classes a library has or uses, without its ending: "pxrInternal_v0_24". Read
/// from the file. Empty where there is none, or where the file cannot be read.
std::string openUsdNamespace(const std::string& library);

/// The version of OpenUSD ("24.05") that the headers beside a library of it have (../include/pxr/pxr.h); empty where
/// there are none.
std::string openUsdVersionBeside(const std::string& library);

} // namespace stf::doctor
