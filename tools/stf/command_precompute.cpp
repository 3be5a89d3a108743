// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/cache/table_cache.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/transport/stf_table.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"
#include "tools/stf/table_json.h"
#include "tools/stf/terminal_progress.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

struct Arguments {
    std::string volume, out, cache, form = "dE1";
    int threads = 0;
    TransportOptions options;
    bool json = false;
};

void run(const Arguments& a) {
    const MessageSink messages = [](Severity, const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); };
    const auto volume = std::make_shared<const BaseVolume>(readBaseVolume(a.volume, messages));
    std::shared_ptr<const StfTable> table;
    {
        TerminalProgress progress(!a.json);
        table = cachedTables(a.cache)(volume, a.options, progress, messages);
    }
    if (!a.out.empty()) {
        writeTable(*table, volume->contentHash() + ";" + a.options.key(), a.out);
    }
    if (a.json) {
        nlohmann::json j = describeTable(*table);
        j["volume"] = a.volume;
        j["rank"] = table->multiple.get().rank;
        std::printf("%s\n", j.dump().c_str());
        return;
    }
    const TableError& e = table->error;
    std::printf(
        "%s: form %s, %d directions (%d polar x %d around), %llu photons, %.1f MB in memory, computed in %.1f s\n",
        a.volume.c_str(), name(table->form), table->directions.count(), table->directions.polars(),
        table->directions.azimuths(), static_cast<unsigned long long>(table->photons), double(table->bytes()) / 1e6,
        table->seconds);
    std::printf(
        "error %.2f %% of %.2f %% asked for: noise %.2f, directions %.2f, rank %.2f, filter %.2f, storage %.2f\n",
        100 * e.total(), 100 * e.target, 100 * e.noise, 100 * e.directions, 100 * e.truncation, 100 * e.filter,
        100 * e.storage);
}

} // namespace

void addPrecomputeCommand(CLI::App& app) {
    auto* command = app.add_subcommand("precompute", "Compute and keep the transport table of a base volume");
    auto a = std::make_shared<Arguments>();
    command->add_option("volume", a->volume, "Base volume (.vdb)")->required();
    command->add_option("--quality", a->options.quality, "Wanted relative error of the table")
        ->check(CLI::PositiveNumber);
    command->add_option("--seed", a->options.seed, "Seed of the photons");
    command->add_option("--max-photons", a->options.maxPhotons, "Limit of all walks, per channel")
        ->check(CLI::PositiveNumber);
    command->add_option("--form", a->form, "dE1 or classic")->capture_default_str();
    command->add_option("--polars", a->options.polars, "Polar directions (default: from the error)");
    command->add_option("--azimuths", a->options.azimuths, "Directions around, 1 or even (default: from the error)");
    command->add_option("--threads", a->threads, "Number of threads (default: all cores)");
    command->add_option("--cache", a->cache, "Folder of the store (default: the one the renderer reads)");
    command->add_option("--out", a->out, "Write the table here too");
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] {
        a->options.form = parseTransportForm(a->form);
        setThreadCount(a->threads);
        run(*a);
    });
}

} // namespace stf
