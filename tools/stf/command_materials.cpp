// SPDX-License-Identifier: Apache-2.0
#include "tools/srgb.h"
#include "tools/stf/commands.h"
#include "tools/stf/materials_sheet.h"
#include "tools/stf/sheet.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace stf {

namespace {

struct Arguments {
    std::vector<std::string> names;
    std::string table, sheet;
    bool json = false;
};

// JSON has no infinity: null.
nlohmann::json triple(const Vec3d& v) {
    nlohmann::json j = nlohmann::json::array();
    for (int c = 0; c < 3; ++c) {
        j.push_back(std::isfinite(v[c]) ? nlohmann::json(v[c]) : nlohmann::json());
    }
    return j;
}

nlohmann::json describe(const MaterialRow& row) {
    const Material& m = row.material;
    return {{"name", row.name},
            {"source", m.source},
            {"sigmaA", triple(m.sigmaA)},
            {"sigmaS", triple(m.sigmaS)},
            {"sigmaSPrime", triple(m.sigmaSPrime())},
            {"extinction", triple(m.extinction())},
            {"albedo", triple(row.albedo)},
            {"g", m.g},
            {"ior", m.ior},
            {"diffuseReflectance", triple(row.reflectance)},
            {"meanFreePathMm", triple(row.meanFreePathMm)},
            {"diffusionLengthMm", triple(row.diffusionLengthMm)}};
}

// Three cells of a terminal in the colour of the material; nothing where no person looks.
std::string swatch(const Rgb& color) {
    if (!::isatty(STDOUT_FILENO)) {
        return {};
    }
    char text[64];
    std::snprintf(text, sizeof text, "\033[48;2;%d;%d;%dm   \033[0m ", srgbByte(color.x), srgbByte(color.y),
                  srgbByte(color.z));
    return text;
}

std::string numbers(const Vec3d& v) {
    char text[64];
    std::snprintf(text, sizeof text, "%.4g %.4g %.4g", v.x, v.y, v.z);
    return text;
}

void printList(const std::vector<MaterialRow>& rows) {
    const bool terminal = ::isatty(STDOUT_FILENO);
    std::printf("%s%-44s %-24s %-24s %5s %5s  %-20s %-22s %s\n", terminal ? "    " : "", "name", "extinction 1/mm",
                "albedo", "g", "ior", "diffuse reflectance", "mean free path mm", "diffusion length mm");
    for (const MaterialRow& row : rows) {
        const Vec3d r = row.reflectance;
        char reflectance[32];
        std::snprintf(reflectance, sizeof reflectance, "%.3f %.3f %.3f", r.x, r.y, r.z);
        std::printf("%s%-44s %-24s %-24s %5.3f %5.2f  %-20s %-22s %s\n", swatch(Rgb(r)).c_str(), row.name.c_str(),
                    numbers(row.material.extinction()).c_str(), numbers(row.albedo).c_str(), row.material.g,
                    row.material.ior, reflectance, numbers(row.meanFreePathMm).c_str(),
                    numbers(row.diffusionLengthMm).c_str());
    }
}

void printOne(const MaterialRow& row) {
    const Material& m = row.material;
    const auto line = [](const char* name, const std::string& value, const char* unit) {
        std::printf("  %-22s %s%s\n", name, value.c_str(), unit);
    };
    std::printf("%s%s\n", swatch(Rgb(row.reflectance)).c_str(), row.name.c_str());
    line("source", m.source, "");
    line("absorption", numbers(m.sigmaA), " 1/mm");
    line("scattering", numbers(m.sigmaS), " 1/mm");
    line("reduced scattering", numbers(m.sigmaSPrime()), " 1/mm");
    line("extinction", numbers(m.extinction()), " 1/mm");
    line("albedo", numbers(row.albedo), "");
    line("g", nlohmann::json(m.g).dump(), "");
    line("ior", nlohmann::json(m.ior).dump(), "");
    line("diffuse reflectance", numbers(row.reflectance), "");
    line("mean free path", numbers(row.meanFreePathMm), " mm, 1 / (absorption + reduced scattering)");
    line("diffusion length", numbers(row.diffusionLengthMm), " mm");
}

void run(const Arguments& a) {
    const PropertyTable table = a.table.empty() ? PropertyTable::builtIn() : PropertyTable::read(a.table);
    std::vector<MaterialRow> rows;
    for (const std::string& name : a.names) {
        rows.push_back(rowOf(name, table.find(name)));
    }
    for (std::size_t i = 0; a.names.empty() && i < table.ownCount(); ++i) {
        rows.push_back(rowOf(table.qualifiedName(i), table.materials()[i]));
    }
    if (!a.sheet.empty()) {
        writeMaterialsSheet(rows, a.sheet);
    }
    if (a.json) {
        nlohmann::json list = nlohmann::json::array();
        for (const MaterialRow& row : rows) {
            list.push_back(describe(row));
        }
        std::printf("%s\n", list.dump().c_str());
    } else if (a.names.empty()) {
        printList(rows);
    } else {
        for (const MaterialRow& row : rows) {
            printOne(row);
        }
    }
}

} // namespace

void addMaterialsCommand(CLI::App& app) {
    auto* command = app.add_subcommand("materials", "List materials: the published tables, or a table of your own");
    auto a = std::make_shared<Arguments>();
    command->add_option("name", a->names, "Materials to show; NAME@g=0.8 takes another mean cosine. None: all");
    command->add_option("--table", a->table, "A table of your own (docs/materials.md); its materials come first");
    command->add_option("--sheet", a->sheet, "Write swatches into this PNG");
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] { run(*a); });
}

} // namespace stf
