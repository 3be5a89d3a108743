// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_recipe.h"

#include "stfLib/optics/property_table.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

namespace stf {

namespace {

using Json = nlohmann::json;

// An object of the recipe whose keys are asked for one by one; what was not asked for is not known.
class Keys {
public:
    Keys(const Json& json, const std::string& where) : json_(json), where_(where) {
        if (!json.is_object()) {
            throw Error((where.empty() ? "the recipe" : "'" + where + "'") + " is no JSON object");
        }
    }
    const Json* find(const std::string& key) {
        asked_.insert(key);
        const auto found = json_.find(key);
        return found == json_.end() || found->is_null() ? nullptr : &*found;
    }
    std::string path(const std::string& key) const { return where_.empty() ? key : where_ + "." + key; }
    [[noreturn]] void fail(const std::string& key, const std::string& should) const {
        throw Error("'" + path(key) + "' is " + json_.at(key).dump() + "; it should be " + should);
    }

    void text(const std::string& key, std::string& value) {
        if (const Json* const j = find(key)) {
            if (!j->is_string()) {
                fail(key, "a text");
            }
            value = j->get<std::string>();
        }
    }
    std::optional<double> number(const std::string& key, double least, double most) {
        const Json* const j = find(key);
        if (!j) {
            return {};
        }
        if (!j->is_number() || !(j->get<double>() >= least && j->get<double>() <= most)) {
            fail(key, "a number from " + Json(least).dump() + " to " + Json(most).dump());
        }
        return j->get<double>();
    }
    std::vector<double> numbers(const std::string& key) {
        const Json* const j = find(key);
        std::vector<double> values;
        for (std::size_t i = 0; j && i < (j->is_array() ? j->size() : 1); ++i) {
            const Json& item = j->is_array() ? (*j)[i] : *j;
            if (!item.is_number() || !std::isfinite(item.get<double>())) {
                fail(key, "a list of numbers");
            }
            values.push_back(item.get<double>());
        }
        return values;
    }
    /// One number for all axes, or three.
    std::optional<Vec3d> triple(const std::string& key, double least, double most) {
        const std::vector<double> v = numbers(key);
        if (v.empty() && !find(key)) {
            return {};
        }
        const bool fits = std::all_of(v.begin(), v.end(), [&](double x) { return x >= least && x <= most; });
        if ((v.size() != 1 && v.size() != 3) || !fits) {
            fail(key, "one number or three, from " + Json(least).dump() + " to " + Json(most).dump());
        }
        return v.size() == 1 ? Vec3d(v[0]) : Vec3d(v[0], v[1], v[2]);
    }
    std::optional<Vec3i> wholeTriple(const std::string& key, int least, int most) {
        const std::optional<Vec3d> v = triple(key, least, most);
        if (!v) {
            return {};
        }
        const Vec3i whole{int(v->x), int(v->y), int(v->z)};
        if (Vec3d(whole) != *v) {
            fail(key, "whole numbers");
        }
        return whole;
    }
    /// The place of a word in a list of those that are known.
    std::optional<std::size_t> word(const std::string& key, const std::vector<std::string>& known) {
        const Json* const j = find(key);
        if (!j) {
            return {};
        }
        std::string list;
        for (std::size_t i = 0; i < known.size(); ++i) {
            if (*j == known[i]) {
                return i;
            }
            list += (i ? ", " : "") + known[i];
        }
        fail(key, "one of " + list);
    }
    /// Throws where there are keys that nobody asked for.
    void done() const {
        for (const auto& item : json_.items()) {
            if (!asked_.count(item.key())) {
                throw Error("'" + path(item.key()) + "' is no key of a recipe");
            }
        }
    }

private:
    const Json& json_;
    std::string where_;
    std::set<std::string> asked_;
};

Material readMaterial(const Json& json, const std::string& where, const PropertyTable& table) {
    if (json.is_string()) {
        try {
            return table.find(json.get<std::string>());
        } catch (const Error& e) {
            throw Error("'" + where + "': " + e.what());
        }
    }
    return parseMaterial(json.dump(), "'" + where + "'");
}

void readRaw(Keys& top, ScanRecipe& r) {
    const Json* const j = top.find("raw");
    if (!j) {
        return;
    }
    Keys keys(*j, "raw");
    const auto dims = keys.wholeTriple("dims", 1, 1 << 20);
    if (!dims) {
        throw Error("a raw file needs its size ('raw.dims', --dims)");
    }
    r.read.raw = true;
    r.read.layout.size = *dims;
    std::string type = "uint8";
    keys.text("type", type);
    r.read.layout.type = scanTypeOf(type);
    r.read.layout.bigEndian = keys.word("endian", {"little", "big"}).value_or(0) == 1;
    const double header = keys.number("headerBytes", 0, 1e15).value_or(0);
    if (header != std::floor(header)) {
        keys.fail("headerBytes", "a whole number");
    }
    r.read.layout.headerBytes = std::uint64_t(header);
    keys.done();
}

void readClassify(Keys& top, ScanRecipe& r, const PropertyTable& table) {
    const Json* const j = top.find("classify");
    if (!j) {
        throw Error("how to classify is missing ('classify', --classify and --materials)");
    }
    Keys keys(*j, "classify");
    r.thresholds = keys.numbers("thresholds");
    r.widths = keys.numbers("widths");
    const Json* const points = keys.find("points");
    const auto method = keys.word("method", {"transfer", "thresholds", "otsu", "gmm"});
    r.method = method                  ? ScanRecipe::Method(*method)
               : points                ? ScanRecipe::Method::Transfer
               : !r.thresholds.empty() ? ScanRecipe::Method::Thresholds
                                       : ScanRecipe::Method::Otsu;
    const Json* const materials = keys.find("materials");
    if (!materials || !materials->is_array() || materials->empty() || materials->size() > 16) {
        throw Error("'classify.materials' must be a list of 1 to 16 materials (--materials)");
    }
    for (std::size_t i = 0; i < materials->size(); ++i) {
        r.materials.push_back(readMaterial((*materials)[i], "classify.materials[" + std::to_string(i) + "]", table));
    }
    const std::size_t kinds = r.materials.size();
    if (r.method == ScanRecipe::Method::Transfer) {
        if (!points || !points->is_array() || points->empty()) {
            throw Error("a transfer function needs 'classify.points' (--point)");
        }
        for (const Json& p : *points) {
            const bool fits = p.is_array() && p.size() == kinds + 1 &&
                              std::all_of(p.begin(), p.end(), [](const Json& x) { return x.is_number(); });
            if (!fits) {
                throw Error("a point of 'classify.points' is " + p.dump() + "; it should be a value and " +
                            std::to_string(kinds) + " fractions");
            }
            const auto numbers = p.get<std::vector<double>>();
            r.points.push_back({numbers[0], {numbers.begin() + 1, numbers.end()}});
        }
    } else if (r.method == ScanRecipe::Method::Thresholds) {
        if (r.thresholds.size() + 1 != kinds) {
            throw Error(std::to_string(kinds) + " materials need " + std::to_string(kinds - 1) + " thresholds, not " +
                        std::to_string(r.thresholds.size()));
        }
    } else if (kinds < 2) {
        throw Error("to find classes by itself takes two materials or more ('none' is one)");
    }
    const std::vector<double> gradient = keys.numbers("gradient");
    if (!gradient.empty()) {
        if (gradient.size() != 2 || !(gradient[0] >= 0 && gradient[1] >= gradient[0] && gradient[1] > 0)) {
            keys.fail("gradient", "two rising numbers, values per mm");
        }
        r.gradientFlat = gradient[0];
        r.gradientSteep = gradient[1];
    }
    keys.done();
}

void readSurface(Keys& top, ScanRecipe& r) {
    if (const Json* const iso = top.find("iso")) {
        if (*iso == "auto") {
            r.surface = ScanRecipe::Surface::Auto;
        } else if (iso->is_number() && std::isfinite(iso->get<double>())) {
            r.surface = ScanRecipe::Surface::Value;
            r.iso = iso->get<double>();
        } else if (*iso != "none") {
            top.fail("iso", "a number, auto or none");
        }
    }
    r.smooth = top.number("smooth", 0, 10).value_or(r.smooth);
    const Json* const t = top.find("top");
    r.topAuto = t ? *t == "auto" : r.surface != ScanRecipe::Surface::None;
    if (t && !r.topAuto) {
        r.topMm = top.number("top", 0, 1e6);
    }
}

ScanRecipe parse(const Json& json, const std::string& folder) {
    Keys keys(json, "");
    ScanRecipe r;
    const auto resolved = [&](const std::string& path) {
        return path.empty() || folder.empty() ? path : (std::filesystem::path(folder) / path).string();
    };
    std::string table, about;
    keys.find("about");
    keys.text("table", table);
    keys.text("input", r.input);
    keys.text("name", r.name);
    if (r.input.empty()) {
        throw Error("the scan to read is missing ('input')");
    }
    r.input = resolved(r.input);
    if (r.name.empty()) {
        std::filesystem::path p(r.input);
        p = p.has_filename() ? p.filename() : p.parent_path().filename();
        p = p.extension() == ".gz" ? p.stem() : p;
        p = p.stem();
        r.name = p.string();
    }
    const PropertyTable& builtIn = PropertyTable::builtIn();
    const PropertyTable own = table.empty() ? PropertyTable() : PropertyTable::read(resolved(table));
    const PropertyTable& materials = table.empty() ? builtIn : own;
    readRaw(keys, r);
    keys.text("series", r.read.series);
    r.spacingMm = keys.triple("spacing", 1e-9, 1e6);
    r.nan = keys.number("nan", -1e30, 1e30);
    keys.text("crop", r.crop);
    keys.text("depth", r.depth);
    r.scale = keys.number("scale", 1e-9, 1e9).value_or(1);
    r.voxelMm = keys.triple("voxel", 1e-9, 1e9);
    readClassify(keys, r, materials);
    r.tiling = ScanRecipe::Tiling(keys.word("tile", {"none", "blend", "quilt"}).value_or(0));
    if (const Json* const overlap = keys.find("overlap")) {
        // One number, or one for x and one for y.
        const std::vector<double> v = keys.numbers("overlap");
        const bool fits = (v.size() == 1 || v.size() == 2) && std::all_of(v.begin(), v.end(), [](double x) {
                              return x >= 1 && x <= 32767 && x == std::floor(x);
                          });
        if (!fits) {
            throw Error("'overlap' is " + overlap->dump() + "; it should be one or two whole numbers of voxels");
        }
        r.overlap = Vec3i(int(v[0]), int(v.back()), 0);
    }
    readSurface(keys, r);
    if (const Json* const core = keys.find("core")) {
        r.core = readMaterial(*core, "core", materials);
    }
    r.maxMemoryMB = keys.number("maxMemoryMB", 1, 1e9).value_or(r.maxMemoryMB);
    keys.done();
    return r;
}

} // namespace

ScanRecipe parseScanRecipe(const std::string& text, const std::string& patch, const std::string& origin,
                           const std::string& folder) {
    try {
        Json json = Json::parse(text);
        Json change = Json::parse(patch);
        if (!json.is_object()) {
            throw Error("is no JSON object");
        }
        // Absolute, so that the recipe's folder does not count for what the patch says.
        for (const char* key : {"input", "table"}) {
            if (change.contains(key) && change[key].is_string()) {
                change[key] = std::filesystem::absolute(change[key].get<std::string>()).string();
            }
        }
        json.merge_patch(change);
        return parse(json, folder);
    } catch (const Json::exception& e) {
        throw Error(origin + ": " + e.what());
    } catch (const Error& e) {
        throw Error((origin.empty() ? "" : origin + ": ") + e.what());
    }
}

} // namespace stf
