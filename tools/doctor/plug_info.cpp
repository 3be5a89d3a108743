// SPDX-License-Identifier: Apache-2.0
#include "tools/doctor/plug_info.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glob.h>
#include <nlohmann/json.hpp>
#include <set>

namespace stf::doctor {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::size_t kMostFiles = 1000;
constexpr std::uintmax_t kMostBytes = 16u << 20;

std::string textOr(const Json& object, const char* key, const std::string& otherwise) {
    const auto it = object.find(key);
    return it != object.end() && it->is_string() ? it->get<std::string>() : otherwise;
}

std::vector<std::string> expand(const std::string& pattern) {
    std::vector<std::string> names;
    glob_t found{};
    if (::glob(pattern.c_str(), GLOB_MARK, nullptr, &found) == 0) {
        names.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
    }
    ::globfree(&found);
    return names;
}

class Reader {
public:
    explicit Reader(PlugInfoReading& reading) : reading_(reading) {}

    void read(std::string path, bool mustExist) {
        if (path.back() == '/') {
            path += "plugInfo.json";
        }
        path = fs::path(path).lexically_normal().string();
        if (seen_.size() >= kMostFiles || !seen_.insert(path).second) {
            return;
        }
        std::error_code error;
        const std::uintmax_t bytes = fs::file_size(path, error);
        std::ifstream file(path);
        if (error || !file) {
            // What an "Includes" names need not be there.
            if (mustExist || fs::exists(path, error)) {
                fault(path, "cannot be read");
            }
            return;
        }
        if (bytes > kMostBytes) {
            fault(path, "is too large for a plugInfo.json");
            return;
        }
        reading_.files.push_back(path);
        std::string text;
        for (std::string line; std::getline(file, line); text += "\n") {
            if (line.find('#') >= line.find_first_not_of(" \t#")) {
                text += line;
            }
        }
        try {
            take(path, Json::parse(text));
        } catch (const Json::exception& e) {
            // "[json.exception.parse_error.101] parse error at line 3, column 1: ..."
            const std::string said = e.what();
            const std::size_t end = said.find("] ");
            fault(path, "is no valid JSON: " + (end == std::string::npos ? said : said.substr(end + 2)));
        }
    }

private:
    void fault(const std::string& path, const std::string& what) { reading_.faults.push_back(path + " " + what); }

    void take(const std::string& path, const Json& top) {
        if (!top.is_object()) {
            fault(path, "holds no JSON object");
            return;
        }
        for (const char* key : {"Plugins", "Includes"}) {
            if (top.contains(key) && !top[key].is_array()) {
                fault(path, std::string("has \"") + key + "\" that is no list");
            }
        }
        const fs::path folder = fs::path(path).parent_path();
        for (const Json& plugin : top.value("Plugins", Json()).is_array() ? top["Plugins"] : Json::array()) {
            if (plugin.is_object()) {
                describe(path, folder, plugin);
            } else {
                fault(path, "has a plugin that is no JSON object");
            }
        }
        for (const Json& include : top.value("Includes", Json()).is_array() ? top["Includes"] : Json::array()) {
            if (include.is_string() && !include.get_ref<const std::string&>().empty()) {
                follow((folder / include.get<std::string>()).string());
            } else {
                fault(path, "has an \"Includes\" that is no path");
            }
        }
    }

    void describe(const std::string& path, const fs::path& folder, const Json& plugin) {
        DescribedPlugin d;
        d.name = textOr(plugin, "Name", "");
        d.file = path;
        const fs::path root = folder / textOr(plugin, "Root", ".");
        if (const std::string library = textOr(plugin, "LibraryPath", ""); !library.empty()) {
            // A library's path counts from the root.
            d.library = (root / library).lexically_normal().string();
        }
        if (const auto info = plugin.find("Info"); info != plugin.end() && info->is_object()) {
            if (const auto own = info->find("hdStf"); own != info->end() && own->is_object()) {
                d.openUsd = textOr(*own, "OpenUSD", "");
            }
        }
        reading_.plugins.push_back(d);
    }

    void follow(const std::string& pattern) {
        if (pattern.find_first_of("*?") == std::string::npos) {
            read(pattern, false);
            return;
        }
        for (const std::string& name : expand(pattern)) {
            std::error_code error;
            // A pattern for folders means the file in each.
            if (fs::is_regular_file(name, error) || fs::exists(name + "plugInfo.json", error)) {
                read(name, true);
            }
        }
    }

    PlugInfoReading& reading_;
    std::set<std::string> seen_;
};

} // namespace

PlugInfoReading readPlugInfo(const std::string& entry) {
    PlugInfoReading reading;
    std::error_code error;
    const bool isFolder = fs::is_directory(entry, error);
    Reader(reading).read(isFolder ? entry + "/" : entry, true);
    return reading;
}

} // namespace stf::doctor
