// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace stf {

/// How another program is run.
struct ProgramRun {
    std::string standardOutput, standardError; ///< files to write them to; empty: this process's own
    double mostSeconds = 0;                    ///< it is ended after that long; 0: never
};

struct ProgramEnd {
    int code = 0;
    int signal = 0; ///< that ended it; 0: it ended by itself
    bool timedOut = false;
};

/// Runs a program with this environment, looked for on the path where its name has no slash, and waits for its end.
/// Throws Error with its name where it cannot be started.
ProgramEnd runProgram(const std::vector<std::string>& words, const ProgramRun& how = {});

} // namespace stf
