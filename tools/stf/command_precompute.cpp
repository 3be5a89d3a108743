// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/table_cache.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/transport/stf_table.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"

#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace stf {

namespace {

struct Arguments {
    std::string volume, out, cache;
    TransportOptions options;
    bool json = false;
};

volatile std::sig_atomic_t interrupted = 0;

// Stops at the next photon block after an interrupt.
class SignalProgress : public Progress {
public:
    using Progress::Progress;
    bool cancelled() const override { return interrupted || Progress::cancelled(); }
};

void run(const Arguments& a) {
    const MessageSink messages = [](Severity, const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); };
    const auto volume = std::make_shared<const BaseVolume>(readBaseVolume(a.volume, messages));
    const bool bar = isatty(2) && !a.json;
    SignalProgress progress([bar](const std::string& stage, double fraction) {
        if (bar) {
            std::fprintf(stderr, "\r%-12s %5.1f %%", stage.c_str(), 100 * fraction);
        }
    });
    std::signal(SIGINT, [](int) { interrupted = 1; });
    const auto table = cachedTables(a.cache)(volume, a.options, progress, messages);
    if (bar) {
        std::fprintf(stderr, "\n");
    }
    if (!a.out.empty()) {
        writeTable(*table, volume->contentHash() + ";" + a.options.key(), a.out);
    }
    if (a.json) {
        std::printf("%s\n", nlohmann::json{{"volume", a.volume},
                                           {"hash", table->volumeHash},
                                           {"form", table->form},
                                           {"directions", table->directions.count()},
                                           {"photons", table->photonsPerDirection},
                                           {"relativeError", table->relativeError},
                                           {"bytes", table->bytes()},
                                           {"seconds", table->seconds}}
                                .dump()
                                .c_str());
    } else {
        std::printf("%s: %d directions, %llu photons each, noise %.2g %% per voxel, %.1f MB, computed in %.1f s\n",
                    a.volume.c_str(), table->directions.count(),
                    static_cast<unsigned long long>(table->photonsPerDirection), 100 * table->relativeError,
                    double(table->bytes()) / 1e6, table->seconds);
    }
}

} // namespace

void addPrecomputeCommand(CLI::App& app) {
    auto* command = app.add_subcommand("precompute", "Compute and keep the transport table of a base volume");
    auto a = std::make_shared<Arguments>();
    command->add_option("volume", a->volume, "Base volume (.vdb)")->required();
    command->add_option("--quality", a->options.quality, "Wanted relative noise of the tables")
        ->check(CLI::PositiveNumber);
    command->add_option("--seed", a->options.seed, "Seed of the photons");
    command->add_option("--max-photons", a->options.maxPhotons, "Limit per direction")->check(CLI::PositiveNumber);
    command->add_option("--cache", a->cache, "Folder of the store (default: the one the renderer reads)");
    command->add_option("--out", a->out, "Write the table here too");
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] { run(*a); });
}

} // namespace stf
