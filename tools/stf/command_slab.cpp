// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "tools/stf/commands.h"
#include "tools/stf/slab_stf.h"
#include "tools/stf/slab_walk.h"
#include "tools/stf/terminal_progress.h"

#include <cstdio>
#include <memory>

namespace stf {

void addSlabCommand(CLI::App& app) {
    auto* command = app.add_subcommand("slab", "A laboratory: light through a homogeneous or layered slab");
    auto arguments = std::make_shared<SlabArguments>();
    arguments->addTo(*command);
    command->callback([arguments] {
        const SlabOptions options = arguments->parse();
        setThreadCount(options.threads);
        SlabResult result;
        {
            TerminalProgress progress(!arguments->json());
            result = options.method == SlabOptions::Method::Stf ? slabByTable(options, progress)
                                                                : slabByWalks(options, progress);
        }
        std::fputs(arguments->json() ? (slabJson(options, result) + "\n").c_str() : slabText(options, result).c_str(),
                   stdout);
    });
}

} // namespace stf
