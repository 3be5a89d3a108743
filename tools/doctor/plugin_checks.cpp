// SPDX-License-Identifier: Apache-2.0
#include "tools/doctor/plugin_checks.h"

#include "stfLib/base/error.h"
#include "tools/doctor/library_probe.h"
#include "tools/doctor/plug_info.h"

#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>

namespace stf::doctor {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> entriesOf(const std::string& path) {
    std::vector<std::string> entries;
    std::istringstream text(path);
    for (std::string entry; std::getline(text, entry, ':');) {
        if (!entry.empty()) {
            entries.push_back(entry);
        }
    }
    return entries;
}

std::string exportLine(const std::string& folder) {
    return "export PXR_PLUGINPATH_NAME=" + folder;
}

/// Plugins of all entries, the first entry's first, as OpenUSD takes them. Entries that cannot be read become findings.
std::vector<DescribedPlugin> readPath(const PluginSearch& search, Findings& findings) {
    std::vector<DescribedPlugin> plugins;
    std::vector<std::string> entries;
    if (search.path) {
        entries = entriesOf(*search.path);
    }
    if (entries.empty()) {
        findings.push_back(problem("plugin path",
                                   std::string("PXR_PLUGINPATH_NAME is ") + (search.path ? "empty" : "not set") +
                                       ": no host finds the renderer",
                                   exportLine(search.ownFolder)));
        entries = {search.ownFolder}; // what else is wrong with it can be told all the same
    }
    for (const std::string& entry : entries) {
        std::error_code error;
        if (!fs::path(entry).is_absolute()) {
            findings.push_back(problem("plugin path",
                                       "\"" + entry +
                                           "\" in PXR_PLUGINPATH_NAME is relative: OpenUSD looks for it beside its "
                                           "own library, not in the present folder",
                                       exportLine(fs::absolute(entry, error).lexically_normal().string())));
            continue;
        }
        if (!fs::exists(entry, error)) {
            findings.push_back(
                problem("plugin path", entry + " in PXR_PLUGINPATH_NAME does not exist", exportLine(search.ownFolder)));
            continue;
        }
        const PlugInfoReading reading = readPlugInfo(entry);
        for (const std::string& fault : reading.faults) {
            findings.push_back(problem("plugInfo", fault, "install hdStf anew, or take the entry off the path"));
        }
        if (reading.faults.empty()) {
            findings.push_back(ok("plugin path", entry + ": " + std::to_string(reading.files.size()) +
                                                     " plugInfo.json, " + std::to_string(reading.plugins.size()) +
                                                     (reading.plugins.size() == 1 ? " plugin" : " plugins")));
        }
        plugins.insert(plugins.end(), reading.plugins.begin(), reading.plugins.end());
    }
    return plugins;
}

/// The plugin of that name that OpenUSD takes; null where there is none. Further ones become a finding.
const DescribedPlugin* chosen(const std::vector<DescribedPlugin>& plugins, const std::string& name,
                              Findings& findings) {
    const DescribedPlugin* first = nullptr;
    for (const DescribedPlugin& plugin : plugins) {
        if (plugin.name != name) {
            continue;
        }
        if (!first) {
            first = &plugin;
        } else if (plugin.file != first->file) {
            findings.push_back(warning("plugin",
                                       "a plugin " + name + " is on the path twice: that of " + first->file +
                                           " counts, that of " + plugin.file + " does not",
                                       "take the folder that is not meant off PXR_PLUGINPATH_NAME"));
        }
    }
    return first;
}

/// Whether a library is the one that has Hydra: libhd.so of an OpenUSD of many libraries, or a host's single one.
bool hasHydra(const std::string& path) {
    static const std::regex name(R"(lib(.*_)?(hd|usd_m|usd_ms)\.(so|dylib).*)");
    return std::regex_match(fs::path(path).filename().string(), name);
}

std::string describeOpenUsd(const std::string& library) {
    const std::string version = openUsdVersionBeside(library);
    return (version.empty() ? "" : version + ", ") + "namespace " + openUsdNamespace(library) + ", " + library;
}

/// The reason that the loader gives, with what to do about it.
Finding loadProblem(const DescribedPlugin& plugin, const std::string& error) {
    const std::string text = plugin.library + " cannot be loaded: " + error;
    const std::string builtFor = plugin.openUsd.empty() ? "" : " (OpenUSD " + plugin.openUsd + ")";
    if (error.find("__pxrReserved__") != std::string::npos) {
        return problem("plugin", text,
                       "the OpenUSD here is not the one that the plugin was built for" + builtFor +
                           ": build hdStf with that of the host (docs/hosts.md)");
    }
    if (error.find("cannot open shared object file") != std::string::npos) {
        return problem("plugin", text,
                       "install what is missing, or name its folder in LD_LIBRARY_PATH; libraries of OpenUSD" +
                           builtFor + " have to be those of the host");
    }
    return problem("plugin", text, "build or install hdStf anew on this machine");
}

/// Versions of what comes along: by the names of the files, which end with them.
void addLibraries(const std::vector<std::string>& loaded, Findings& findings) {
    const std::pair<const char*, const char*> known[] = {
        {"TBB", "libtbb"}, {"Embree", "libembree"}, {"OpenVDB", "libopenvdb"}, {"OpenSubdiv", "libosdCPU"}};
    for (const auto& [name, start] : known) {
        for (const std::string& path : loaded) {
            const std::string file = fs::path(path).filename().string();
            if (file.rfind(start, 0) != 0 || file.find("malloc") != std::string::npos) {
                continue;
            }
            std::error_code error;
            const std::string real = fs::canonical(path, error).filename().string();
            const std::size_t at = real.find(".so.");
            const std::string version = at == std::string::npos ? real : real.substr(at + 4);
            findings.push_back(ok("libraries", std::string(name) + " " + version + ": " + path));
        }
    }
}

/// An OpenUSD with Python wants the Python that its host has in it.
bool wantsPython(const ProbedLibrary& probed) {
    static const std::regex symbol("undefined symbol: _?Py[A-Z_]");
    return !probed.loaded && std::regex_search(probed.error, symbol);
}

/// Loads the plugin as a host does; where that takes a Python, with one of this machine, whose name `python` then is.
ProbedLibrary probeAsHost(const PluginSearch& search, const std::string& library, std::vector<std::string> before,
                          std::string& python) {
    const ProbedLibrary alone = probeLibrary(search.probe, library, before);
    if (!wantsPython(alone)) {
        return alone;
    }
    before.insert(before.begin(), "");
    for (int minor = 20; minor >= 6; --minor) {
        before.front() = "libpython3." + std::to_string(minor) + ".so.1.0";
        const ProbedLibrary probed = probeLibrary(search.probe, library, before);
        if (probed.loaded) {
            python = before.front();
            return probed;
        }
    }
    return alone;
}

void checkLibrary(const DescribedPlugin& plugin, const PluginSearch& search, Findings& findings) {
    std::error_code error;
    if (!fs::exists(plugin.library, error)) {
        findings.push_back(problem("plugin", plugin.library + ", which " + plugin.file + " names, does not exist",
                                   "install hdStf anew; the folder has to be moved as a whole"));
        return;
    }
    const std::string wants = openUsdNamespace(plugin.library);
    std::vector<std::string> before;
    if (!search.hostLibrary.empty()) {
        if (!fs::exists(search.hostLibrary, error)) {
            findings.push_back(problem("OpenUSD", search.hostLibrary + " does not exist",
                                       "name the host's library: libusd_ms.so, or libhd.so"));
            return;
        }
        const std::string has = openUsdNamespace(search.hostLibrary);
        if (has != wants) {
            findings.push_back(problem("OpenUSD",
                                       plugin.library + " was built for OpenUSD " + plugin.openUsd +
                                           " with namespace " + wants + ", but " + search.hostLibrary +
                                           (has.empty() ? " has no OpenUSD with Hydra" : " has namespace " + has),
                                       "build hdStf with the OpenUSD of the host (docs/hosts.md)"));
            return;
        }
        before = {search.hostLibrary};
    }
    ProbedLibrary probed;
    std::string python;
    try {
        probed = probeAsHost(search, plugin.library, before, python);
    } catch (const Error& e) {
        findings.push_back(warning("plugin", std::string("whether it loads is not known: ") + e.what(),
                                   "stf-probe belongs beside stf: install hdStf anew"));
        return;
    }
    if (wantsPython(probed)) {
        findings.push_back(warning(
            "plugin",
            plugin.library + " cannot be tried outside its host, whose Python its OpenUSD wants: " + probed.error,
            "install libpython of the host's version to try it here"));
        return;
    }
    if (!probed.loaded) {
        findings.push_back(loadProblem(plugin, probed.error));
        return;
    }
    findings.push_back(ok(
        "plugin", plugin.library + " loads" + (python.empty() ? "" : " (with " + python + " for the host's Python)") +
                      "; built for OpenUSD " + (plugin.openUsd.empty() ? "of an unknown version" : plugin.openUsd) +
                      ", namespace " + wants));
    std::vector<std::string> hydras;
    std::copy_if(probed.libraries.begin(), probed.libraries.end(), std::back_inserter(hydras), hasHydra);
    for (const std::string& hydra : hydras) {
        const std::string version = openUsdVersionBeside(hydra);
        if (!version.empty() && !plugin.openUsd.empty() && version != plugin.openUsd) {
            findings.push_back(problem("OpenUSD", "it would load OpenUSD " + describeOpenUsd(hydra),
                                       "build hdStf with that OpenUSD (docs/hosts.md), or give it " + plugin.openUsd));
        } else {
            findings.push_back(ok("OpenUSD", (search.hostLibrary.empty() ? "outside a host it loads " : "it takes ") +
                                                 describeOpenUsd(hydra)));
        }
    }
    if (hydras.size() > 1) {
        findings.push_back(problem("OpenUSD", "two libraries of Hydra are loaded at once",
                                   "keep folders of other OpenUSDs out of LD_LIBRARY_PATH"));
    }
    addLibraries(probed.libraries, findings);
}

} // namespace

Findings checkPlugin(const PluginSearch& search) {
    Findings findings;
    const std::vector<DescribedPlugin> plugins = readPath(search, findings);
    const DescribedPlugin* const renderer = chosen(plugins, "hdStf", findings);
    const DescribedPlugin* const schemas = chosen(plugins, "stfSchemas", findings);
    if (!renderer) {
        findings.push_back(
            problem("plugin", "no plugInfo.json on the path describes the plugin hdStf", exportLine(search.ownFolder)));
        return findings;
    }
    checkLibrary(*renderer, search, findings);
    if (!schemas) {
        findings.push_back(warning("schemas",
                                   "the plugin stfSchemas is not on the path: StfShellAPI is an unknown schema, and "
                                   "materials of StfShell nodes are not seen",
                                   exportLine(search.ownFolder)));
    } else {
        findings.push_back(ok("schemas", schemas->file));
    }
    return findings;
}

} // namespace stf::doctor
