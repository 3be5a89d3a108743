// SPDX-License-Identifier: Apache-2.0
// stf-probe: loads libraries as a host would and tells what came of it, as a line of JSON. A program of its own,
// without OpenUSD: what it loads may belong to another one than the tools', and may end the process.
//
//     stf-probe LIBRARY..     the last is the one that is asked about; those before it are the host's

#include <cstdio>
#include <dlfcn.h>
#include <nlohmann/json.hpp>
#include <string>
#include <unistd.h>
#include <vector>

#if defined(__APPLE__)
#include <mach-o/dyld.h>
#else
#include <link.h>
#endif

namespace {

std::vector<std::string> loadedLibraries() {
    std::vector<std::string> paths;
#if defined(__APPLE__)
    for (std::uint32_t i = 0; i < _dyld_image_count(); ++i) {
        paths.emplace_back(_dyld_get_image_name(i));
    }
#else
    dl_iterate_phdr(
        [](dl_phdr_info* info, std::size_t, void* data) {
            if (info->dlpi_name && *info->dlpi_name) {
                static_cast<std::vector<std::string>*>(data)->emplace_back(info->dlpi_name);
            }
            return 0;
        },
        &paths);
#endif
    return paths;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "stf-probe LIBRARY..\n");
        return 64;
    }
    nlohmann::json told{{"loaded", true}, {"error", ""}};
    for (int i = 1; i < argc && told["loaded"]; ++i) {
        const bool isHosts = i + 1 < argc;
        if (!dlopen(argv[i], RTLD_NOW | (isHosts ? RTLD_GLOBAL : RTLD_LOCAL))) {
            const char* const error = dlerror();
            told = {{"loaded", false}, {"error", error ? error : argv[i]}};
        }
    }
    told["libraries"] = loadedLibraries();
    std::printf("%s\n", told.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
    std::fflush(stdout);
    // Whatever those libraries want to do at the end is none of this program's business.
    _exit(0);
}
