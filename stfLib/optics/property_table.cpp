// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/property_table.h"

#include "stfLib/base/error.h"
#include "stfLib/base/near_names.h"
#include "stfLib/optics/materials_json.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

namespace stf {

namespace {

using Json = nlohmann::ordered_json; // materials in the order of the file

// What a coefficient of a base volume may be (docs/base_volume.md); also keeps sums finite.
constexpr double kLargest = 1e9;

// Names of fields on the way to where the parser is, to tell where a text stops being JSON.
class Trail {
public:
    bool see(int depth, Json::parse_event_t event, const Json& parsed) {
        if (event == Json::parse_event_t::object_start) {
            seen_.resize(std::size_t(depth) + 1);
            seen_.back().clear();
        } else if (event == Json::parse_event_t::key) {
            keys_.resize(std::size_t(depth));
            keys_[std::size_t(depth) - 1] = parsed.get<std::string>();
            if (!seen_[std::size_t(depth) - 1].insert(keys_.back()).second) {
                throw Error(text() + " is there twice");
            }
        }
        return true;
    }
    std::string text() const {
        std::string result;
        for (const std::string& key : keys_) {
            result += (result.empty() ? "" : "/") + key;
        }
        return result;
    }

private:
    std::vector<std::string> keys_;
    std::vector<std::set<std::string>> seen_;
};

Json parseJson(const std::string& text) {
    Trail trail;
    try {
        return Json::parse(
            text, [&](int depth, Json::parse_event_t event, Json& parsed) { return trail.see(depth, event, parsed); });
    } catch (const Json::exception& e) {
        const std::string where = trail.text();
        throw Error("not a table of materials" + (where.empty() ? "" : ", at or after " + where) + ": " + e.what());
    }
}

double number(const Json& value, const std::string& what, double lowest, double highest) {
    if (!value.is_number()) {
        throw Error(what + " is " + value.dump() + " where a number is expected");
    }
    const double x = value.get<double>();
    if (!(x >= lowest && x <= highest)) {
        std::ostringstream s;
        s << what << " is " << x << ", outside " << lowest << " to " << highest;
        throw Error(s.str());
    }
    return x;
}

// Three numbers, or one for all channels.
Vec3d triple(const Json& value, const std::string& what, double lowest, double highest) {
    if (!value.is_array()) {
        return Vec3d(number(value, what, lowest, highest));
    }
    if (value.size() != 3) {
        throw Error(what + " has " + std::to_string(value.size()) + " numbers where one or three are expected");
    }
    Vec3d v;
    for (int c = 0; c < 3; ++c) {
        v[c] = number(value[std::size_t(c)], what, lowest, highest);
    }
    return v;
}

double meanCosine(double g, const std::string& what) {
    if (!(g > -1 && g < 1)) {
        std::ostringstream s;
        s << what << " is " << g << ", outside -1 < g < 1";
        throw Error(s.str());
    }
    return g;
}

// The factor from a table's unit of length to 1/mm.
double perMm(const Json& document) {
    if (!document.contains("units") || !document["units"].is_string()) {
        throw Error("units is missing (\"mm^-1\", \"cm^-1\" or \"m^-1\")");
    }
    const std::string text = document["units"].get<std::string>();
    const std::string unit = text.substr(0, text.find(','));
    const std::pair<const char*, double> known[] = {{"mm^-1", 1},  {"1/mm", 1},    {"cm^-1", 0.1},
                                                    {"1/cm", 0.1}, {"m^-1", 1e-3}, {"1/m", 1e-3}};
    for (const auto& [name, factor] : known) {
        if (unit == name) {
            return factor;
        }
    }
    throw Error("units is \"" + text + "\", not one of \"mm^-1\", \"cm^-1\" and \"m^-1\"");
}

void checkFields(const Json& value, const std::string& where) {
    static const std::vector<std::string> known{"sigma_a",
                                                "sigma_s",
                                                "sigma_s_prime",
                                                "g",
                                                "g_assumed",
                                                "eta",
                                                "source",
                                                "note",
                                                "diffuse_reflectance_table",
                                                "sigma_s_prime_pbrt"};
    if (!value.is_object()) {
        throw Error(where + " is not a material: an object with sigma_a and sigma_s or sigma_s_prime is expected");
    }
    for (const auto& [key, ignored] : value.items()) {
        if (std::find(known.begin(), known.end(), key) == known.end()) {
            throw Error(where + ": no field '" + key + "'" + didYouMean(key, known));
        }
    }
    if (!value.contains("sigma_a")) {
        throw Error(where + ": sigma_a is missing");
    }
    if (value.contains("sigma_s") == value.contains("sigma_s_prime")) {
        throw Error(where + ": one of sigma_s and sigma_s_prime is expected");
    }
    if (value.contains("g") && value.contains("g_assumed")) {
        throw Error(where + ": one of g and g_assumed is expected");
    }
}

Material materialOf(const std::string& name, const Json& value, const std::string& where, double factor) {
    checkFields(value, where);
    Material m;
    m.name = name;
    m.sigmaA = triple(value["sigma_a"], where + ": sigma_a", 0, kLargest) * factor;
    m.ior = value.contains("eta") ? number(value["eta"], where + ": eta", 0.1, 10) : 1.0;
    const char* const gField = value.contains("g_assumed") ? "g_assumed" : "g";
    const std::string gName = where + ": " + gField;
    const Vec3d g = value.contains(gField) ? triple(value[gField], gName, -1, 1) : Vec3d(0.0);
    for (int c = 0; c < 3; ++c) {
        meanCosine(g[c], gName);
    }
    if (value.contains("sigma_s_prime")) {
        if (g.x != g.y || g.y != g.z) {
            throw Error(gName + " differs between channels: with sigma_s_prime it is one number");
        }
        m.g = g.x;
        m.sigmaS = triple(value["sigma_s_prime"], where + ": sigma_s_prime", 0, kLargest) * (factor / (1 - m.g));
    } else {
        const Vec3d sigmaS = triple(value["sigma_s"], where + ": sigma_s", 0, kLargest) * factor;
        const double sum = sigmaS.x + sigmaS.y + sigmaS.z;
        m.g = g.x == g.y && g.y == g.z ? g.x : sum > 0 ? dot(sigmaS, g) / sum : 0.0;
        for (int c = 0; c < 3; ++c) {
            // One factor is exact where g is the same for all.
            m.sigmaS[c] = sigmaS[c] * (g[c] == m.g ? 1.0 : (1 - g[c]) / (1 - m.g));
        }
    }
    return m;
}

// Parts of a document that are no tables.
bool isHeader(const std::string& key) {
    return key == "units" || key == "sources" || key == "notes";
}

std::string textOf(const Json& object, const std::string& key) {
    return object.is_object() && object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : "";
}

Material voidMaterial(const std::string& name) {
    Material m;
    m.name = name;
    return m;
}

} // namespace

Material parseMaterial(const std::string& json, const std::string& where) {
    Json value = parseJson(json);
    if (!value.is_object()) {
        throw Error(where + " is " + value.dump() + " where a material's name or its coefficients are expected");
    }
    const std::string given = textOf(value, "name");
    value.erase("name");
    if (value.contains("ior")) {
        if (value.contains("eta")) {
            throw Error(where + ": one of ior and eta is expected");
        }
        value["eta"] = value["ior"];
        value.erase("ior");
    }
    if (!value.contains("sigma_a")) {
        value["sigma_a"] = 0;
    }
    if (!value.contains("sigma_s") && !value.contains("sigma_s_prime")) {
        value["sigma_s"] = 0;
    }
    Material m = materialOf(given.empty() ? "material" : given, value, where, 1);
    m.source = "recipe";
    return m;
}

Material withMeanCosine(const Material& material, double g) {
    Material m = material;
    m.sigmaS = material.sigmaSPrime() / (1 - meanCosine(g, material.name + ": g"));
    m.g = g;
    return m;
}

void PropertyTable::add(const std::string& table, const Material& material) {
    for (std::size_t i = 0; i < materials_.size(); ++i) {
        if (tables_[i] == table && comparableName(materials_[i].name) == comparableName(material.name)) {
            throw Error(qualifiedName(i) + " and " + table + "/" + material.name + " are the same name");
        }
    }
    materials_.push_back(material);
    tables_.push_back(table);
}

PropertyTable PropertyTable::parse(const std::string& text, const std::string& origin) {
    try {
        const Json document = parseJson(text);
        if (!document.is_object()) {
            throw Error("not a table of materials: an object is expected");
        }
        const double factor = perMm(document);
        const Json sources = document.contains("sources") ? document["sources"] : Json::object();
        PropertyTable result;
        for (const auto& [table, entries] : document.items()) {
            if (isHeader(table)) {
                continue;
            }
            if (!entries.is_object()) {
                throw Error(table + " is not a table: an object of materials is expected");
            }
            for (const auto& [name, value] : entries.items()) {
                const std::string lower = comparableName(name);
                if (lower.empty() || lower == "none" || lower == "void" ||
                    name.find_first_of("/@") != std::string::npos) {
                    throw Error(table + "/" + name +
                                ": not a name for a material (none and void are taken, / and @ "
                                "have a meaning of their own)");
                }
                Material m = materialOf(name, value, table + "/" + name, factor);
                m.source = textOf(value, "source");
                if (m.source.empty()) {
                    m.source = textOf(sources, table);
                }
                result.add(table, m);
            }
        }
        if (result.materials_.empty()) {
            throw Error("no material in it");
        }
        result.own_ = result.materials_.size();
        return result;
    } catch (const Error& e) {
        throw Error(origin + ": " + e.what());
    }
}

const PropertyTable& PropertyTable::builtIn() {
    static const PropertyTable table = parse(builtInMaterialsJson(), "built-in materials");
    return table;
}

PropertyTable PropertyTable::read(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    if (!in || !(text << in.rdbuf())) {
        throw Error(path + ": cannot be read");
    }
    PropertyTable result = parse(text.str(), path);
    const PropertyTable& more = builtIn();
    result.materials_.insert(result.materials_.end(), more.materials_.begin(), more.materials_.end());
    result.tables_.insert(result.tables_.end(), more.tables_.begin(), more.tables_.end());
    return result;
}

Material PropertyTable::find(const std::string& request) const {
    const std::size_t at = request.find('@');
    const std::string name = request.substr(0, at), wanted = comparableName(name);
    if (at != std::string::npos) {
        const Material m = find(name);
        const std::string option = request.substr(at + 1);
        std::size_t used = 0;
        double g = 0;
        try {
            g = option.rfind("g=", 0) == 0 ? std::stod(option.substr(2), &used) : 0.0;
        } catch (const std::exception&) {
            used = 0;
        }
        if (used == 0 || used + 2 != option.size()) {
            throw Error("'" + request + "': after @ a mean cosine is expected, as in " + name + "@g=0.8");
        }
        return withMeanCosine(m, g);
    }
    if (wanted == "none" || wanted == "void") {
        return voidMaterial("none");
    }
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < materials_.size(); ++i) {
        if (wanted == comparableName(materials_[i].name) || wanted == comparableName(qualifiedName(i))) {
            found.push_back(i);
        }
    }
    if (found.empty()) {
        std::vector<std::string> names{"none"};
        for (std::size_t i = 0; i < materials_.size(); ++i) {
            names.push_back(name.find('/') == std::string::npos ? materials_[i].name : qualifiedName(i));
        }
        throw Error("no material named '" + name + "'" + didYouMean(name, names));
    }
    // A user's material stands before a built-in one of the same name; two of one file do not decide.
    const auto own = std::count_if(found.begin(), found.end(), [&](std::size_t i) { return i < own_; });
    if ((own == 0 ? found.size() : std::size_t(own)) > 1) {
        std::string names;
        for (const std::size_t i : found) {
            names += (names.empty() ? "" : ", ") + qualifiedName(i);
        }
        throw Error("the material '" + name + "' is in several tables, name one: " + names);
    }
    return materials_[found.front()];
}

} // namespace stf
