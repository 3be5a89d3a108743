// SPDX-License-Identifier: Apache-2.0
// stf: makes, precomputes and inspects base volumes, looks after the cache of their tables, and computes slabs and flat
// tiles.

#include "stfLib/base/error.h"
#include "tools/stf/commands.h"

#include <cstdio>

int main(int argc, char** argv) {
    CLI::App app("stf: base volumes and transport tables of hdStf", "stf");
    app.require_subcommand(1);
    stf::addMakeCommand(app);
    stf::addPrecomputeCommand(app);
    stf::addImportCommand(app);
    stf::addInspectCommand(app);
    stf::addCacheCommand(app);
    stf::addSlabCommand(app);
    stf::addMapCommand(app);
    stf::addMaterialsCommand(app);
    stf::addShellCommand(app);
    stf::addSynthesizeCommand(app);
    stf::addAcquireCommand(app);
    stf::addPlanCommand(app);
    stf::addStabilityCommand(app);
    stf::addReportCommand(app);
    stf::addSettingsCommand(app);
    try {
        app.parse(argc, argv);
        return stf::kDone;
    } catch (const CLI::RuntimeError& e) {
        return e.get_exit_code(); // a command that found something wrong and said so
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? stf::kDone : stf::kUsage;
    } catch (const stf::Cancelled&) {
        std::fprintf(stderr, "stf: cancelled\n");
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stf: %s\n", e.what());
    }
    return stf::kFailed;
}
