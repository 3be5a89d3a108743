// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace stf {

/// Exit codes of all commands.
enum ExitCode { kDone = 0, kChecksFailed = 1, kFailed = 2, kUsage = 64 };

/// Each adds one command to the program; the callback does the work and throws stf::Error on failure.
void addMakeCommand(CLI::App& app);
void addPrecomputeCommand(CLI::App& app);
void addImportCommand(CLI::App& app);
void addInspectCommand(CLI::App& app);
void addCacheCommand(CLI::App& app);
void addSlabCommand(CLI::App& app);
void addMapCommand(CLI::App& app);
void addMaterialsCommand(CLI::App& app);
void addShellCommand(CLI::App& app);
void addSynthesizeCommand(CLI::App& app);
void addAcquireCommand(CLI::App& app);
void addPlanCommand(CLI::App& app);
void addStabilityCommand(CLI::App& app);
void addReportCommand(CLI::App& app);
void addSettingsCommand(CLI::App& app);

/// Each adds one command to the group `stf acquire`.
void addAcquireMeshCommand(CLI::App& group);
void addAcquireScanCommand(CLI::App& group);

} // namespace stf
