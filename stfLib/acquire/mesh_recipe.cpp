// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_recipe.h"

#include "stfLib/optics/property_table.h"

#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <sstream>

namespace stf {

namespace {

using nlohmann::json;

// Beyond these a number is a slip of the unit rather than a wish.
constexpr double kMaxMm = 1e6, kMaxScale = 1e6;
constexpr int kMaxEdge = 4096, kMaxCount = 1'000'000;

struct ShapeName {
    const char* name;
    MeshSource::Shape shape;
};
constexpr ShapeName kShapes[] = {{"sphere", MeshSource::Shape::Sphere},
                                 {"box", MeshSource::Shape::Box},
                                 {"cylinder", MeshSource::Shape::Cylinder},
                                 {"pebble", MeshSource::Shape::Pebble},
                                 {"layer", MeshSource::Shape::Layer}};

/// One object of the recipe: hands out its members by key and complains with its place.
class Place {
public:
    Place(const json& value, std::string where, std::initializer_list<const char*> known)
        : value_(value), where_(std::move(where)) {
        if (!value_.is_object()) {
            refuse("is not an object");
        }
        for (const auto& [key, unused] : value_.items()) {
            if (std::find_if(known.begin(), known.end(), [&, k = key](const char* n) { return k == n; }) ==
                known.end()) {
                std::string names;
                for (const char* n : known) {
                    names += (names.empty() ? "" : ", ") + std::string(n);
                }
                refuse("has no '" + key + "' (known: " + names + ")");
            }
        }
    }
    [[noreturn]] void refuse(const std::string& what) const { throw Error(where_ + ": " + what); }
    [[noreturn]] void refuse(const char* key, const std::string& what) const { throw Error(at(key) + " " + what); }
    std::string at(const char* key) const { return where_ + ": '" + key + "'"; }
    bool has(const char* key) const { return value_.contains(key); }
    const json& get(const char* key) const { return value_[key]; }

    double number(const char* key, double fallback, double lo, double hi) const {
        return has(key) ? checked(key, get(key), lo, hi) : fallback;
    }
    std::int64_t whole(const char* key, std::int64_t fallback, std::int64_t lo, std::int64_t hi) const {
        if (!has(key)) {
            return fallback;
        }
        const double v = checked(key, get(key), double(lo), double(hi));
        if (v != std::floor(v)) {
            refuse(key, "is not a whole number");
        }
        return std::int64_t(v);
    }
    bool flag(const char* key) const {
        if (has(key) && !get(key).is_boolean()) {
            refuse(key, "is not true or false");
        }
        return has(key) && get(key).get<bool>();
    }
    std::string text(const char* key) const {
        if (has(key) && (!get(key).is_string() || get(key).get<std::string>().empty())) {
            refuse(key, "is not a text");
        }
        return has(key) ? get(key).get<std::string>() : std::string();
    }
    /// Three numbers, or one for all three.
    Vec3d triple(const char* key, const Vec3d& fallback, double lo, double hi) const {
        if (!has(key)) {
            return fallback;
        }
        const json& v = get(key);
        if (v.is_number()) {
            return Vec3d(checked(key, v, lo, hi));
        }
        if (!v.is_array() || v.size() != 3) {
            refuse(key, "is not a number or a list of three");
        }
        return {checked(key, v[0], lo, hi), checked(key, v[1], lo, hi), checked(key, v[2], lo, hi)};
    }
    /// Two numbers in ascending order, or one for both.
    Vec2d range(const char* key, const Vec2d& fallback, double lo, double hi) const {
        if (!has(key)) {
            return fallback;
        }
        const json& v = get(key);
        if (v.is_number()) {
            const double both = checked(key, v, lo, hi);
            return {both, both};
        }
        if (!v.is_array() || v.size() != 2) {
            refuse(key, "is not a number or a list of two (from, to)");
        }
        const Vec2d r{checked(key, v[0], lo, hi), checked(key, v[1], lo, hi)};
        if (r.x > r.y) {
            refuse(key, "goes from the larger to the smaller number");
        }
        return r;
    }

private:
    double checked(const char* key, const json& v, double lo, double hi) const {
        if (!v.is_number()) {
            refuse(key, "holds " + v.dump() + " where a number is expected");
        }
        const double d = v.get<double>();
        if (!(d >= lo && d <= hi)) {
            std::ostringstream s;
            s << "holds " << v.dump() << ", which is not within " << lo << " to " << hi;
            refuse(key, s.str());
        }
        return d;
    }
    const json& value_;
    std::string where_;
};

MaterialChoice materialOf(const Place& p, const char* key) {
    MaterialChoice choice;
    if (!p.has(key)) {
        return choice;
    }
    if (p.get(key).is_string()) {
        choice.name = p.text(key);
        return choice;
    }
    choice.given = parseMaterial(p.get(key).dump(), p.at(key));
    return choice;
}

MeshSource sourceOf(const Place& p, const std::string& folder) {
    MeshSource s;
    s.file = p.text("file");
    s.part = p.text("part");
    const std::string shape = p.text("shape");
    if (s.file.empty() == shape.empty()) {
        p.refuse("names a 'file' or a 'shape', one of them");
    }
    if (!s.file.empty()) {
        s.file = (std::filesystem::path(folder) / s.file).string();
        return s;
    }
    std::string names;
    for (const ShapeName& n : kShapes) {
        names += (names.empty() ? "" : ", ") + std::string(n.name);
        s.shape = shape == n.name ? n.shape : s.shape;
    }
    if (s.shape == MeshSource::Shape::None) {
        p.refuse("shape", "'" + shape + "' is not known (known: " + names + ")");
    }
    s.roughness = p.number("roughness", s.roughness, 0, 0.9);
    s.depthMm = p.range("depth", s.depthMm, -kMaxMm, kMaxMm);
    s.waveMm = p.number("wave", 0, 0, kMaxMm);
    s.cells = int(p.whole("cells", 4, 1, 64));
    s.seed = std::uint64_t(p.whole("seed", 0, 0, std::int64_t(1) << 32));
    if (s.shape == MeshSource::Shape::Layer && !p.has("depth")) {
        p.refuse("a layer needs its 'depth': [from, to] in mm");
    }
    return s;
}

MeshPlacement placementOf(const Place& p) {
    MeshPlacement m;
    m.fit = p.has("fit") && p.get("fit").is_boolean() ? double(p.flag("fit")) : p.number("fit", 0, 0, kMaxScale);
    m.scale = p.triple("scale", Vec3d(1.0), -kMaxScale, kMaxScale);
    m.rotateDegrees = p.triple("rotate", Vec3d(0.0), -36000, 36000);
    m.translateMm = p.triple("translate", Vec3d(0.0), -kMaxMm, kMaxMm);
    if (m.scale.x * m.scale.y * m.scale.z == 0) {
        p.refuse("scale", "is zero along an axis");
    }
    return m;
}

MeshScatter scatterOf(const Place& parent) {
    const Place p(parent.get("scatter"), parent.at("scatter"),
                  {"count", "fraction", "seed", "scale", "turn", "depth", "apart", "gap"});
    MeshScatter s;
    s.count = int(p.whole("count", 0, 1, kMaxCount));
    s.fraction = p.number("fraction", 0, 1e-9, 100);
    if (p.has("count") == p.has("fraction")) {
        p.refuse("has a 'count' or a 'fraction', one of them");
    }
    s.seed = std::uint64_t(p.whole("seed", 0, 0, std::int64_t(1) << 32));
    s.scale = p.range("scale", s.scale, 1e-6, kMaxScale);
    const std::string turn = p.has("turn") ? p.text("turn") : "any";
    if (turn != "any" && turn != "vertical" && turn != "none") {
        p.refuse("turn", "'" + turn + "' is not any, vertical or none");
    }
    s.turn = turn == "any"        ? MeshScatter::Turn::Any
             : turn == "vertical" ? MeshScatter::Turn::Vertical
                                  : MeshScatter::Turn::None;
    if (p.has("depth")) {
        s.depthMm = p.range("depth", {}, -kMaxMm, kMaxMm);
    }
    s.apart = p.flag("apart");
    s.gapMm = p.number("gap", 0, 0, kMaxMm);
    return s;
}

MeshEntry entryOf(const json& value, const std::string& where, const std::string& folder) {
    const Place p(value, where,
                  {"file", "part", "shape", "roughness", "depth", "wave", "cells", "seed", "material", "priority",
                   "fit", "scale", "rotate", "translate", "scatter", "body", "surface"});
    MeshEntry e;
    e.source = sourceOf(p, folder);
    e.material = materialOf(p, "material");
    if (e.material.empty() && e.source.file.empty()) {
        p.refuse("a shape needs a 'material'");
    }
    e.priority = int(p.whole("priority", 0, -1000000, 1000000));
    e.placement = placementOf(p);
    if (p.has("scatter")) {
        e.scatter = scatterOf(p);
    }
    e.body = p.flag("body");
    e.surface = p.flag("surface");
    return e;
}

void topOf(const Place& p, const std::string& origin, const std::string& folder, MeshRecipe& r) {
    if (!p.has("top")) {
        return;
    }
    const json& top = p.get("top");
    if (top == "flat" || top == "geometry") {
        r.top = top == "flat" ? MeshRecipe::Top::Flat : MeshRecipe::Top::Geometry;
        return;
    }
    if (!top.is_object()) {
        p.refuse("top", "is not \"flat\", \"geometry\" or an object with a 'file' or 'shape' of a relief");
    }
    const Place relief(top, origin + ": 'top'",
                       {"file", "part", "shape", "roughness", "depth", "wave", "cells", "seed", "fit", "scale",
                        "rotate", "translate"});
    r.top = MeshRecipe::Top::Relief;
    r.relief = sourceOf(relief, folder);
    r.reliefPlacement = placementOf(relief);
}

} // namespace

std::string MeshSource::label() const {
    if (!file.empty()) {
        return file + (part.empty() ? "" : " (part " + part + ")");
    }
    for (const ShapeName& n : kShapes) {
        if (n.shape == shape) {
            return n.name;
        }
    }
    return "mesh";
}

MeshRecipe parseMeshRecipe(const std::string& text, const std::string& origin, const std::string& folder) {
    json document;
    try {
        document = json::parse(text);
    } catch (const json::exception& e) {
        throw Error(origin + ": is not JSON (" + e.what() + ")");
    }
    const Place p(document, origin, {"about", "name", "size", "voxel", "matrix", "core", "top", "table", "meshes"});
    MeshRecipe r;
    r.name = p.has("name") ? p.text("name") : "acquired";
    if (!p.has("size") || !p.has("voxel")) {
        p.refuse("needs a 'size' (voxels along x, y, z) and a 'voxel' (mm)");
    }
    const Vec3d size = p.triple("size", {}, 1, kMaxEdge);
    r.size = Vec3i(size);
    if (Vec3d(r.size) != size) {
        p.refuse("size", "holds numbers of voxels that are not whole");
    }
    r.voxelMm = p.triple("voxel", {}, 1e-6, 1000);
    r.matrix = materialOf(p, "matrix");
    r.core = materialOf(p, "core");
    if (r.matrix.empty()) {
        r.matrix.name = "none";
    }
    topOf(p, origin, folder, r);
    r.materials = p.text("table");
    if (!r.materials.empty()) {
        r.materials = (std::filesystem::path(folder) / r.materials).string();
    }
    if (p.has("meshes")) {
        if (!p.get("meshes").is_array()) {
            p.refuse("meshes", "is not a list");
        }
        for (std::size_t i = 0; i < p.get("meshes").size(); ++i) {
            r.meshes.push_back(entryOf(p.get("meshes")[i], origin + ": meshes[" + std::to_string(i) + "]", folder));
        }
    }
    return r;
}

std::string meshWords(const std::string& words) {
    json mesh = json::object();
    std::stringstream stream(words);
    std::string word;
    const auto number = [](const std::string& s, double& out) {
        char* end = nullptr;
        out = std::strtod(s.c_str(), &end);
        return !s.empty() && *end == 0 && std::isfinite(out);
    };
    const auto value = [&](const std::string& s) -> json {
        double d = 0;
        if (s == "true" || s == "false") {
            return s == "true";
        }
        json list = json::array();
        std::stringstream parts(s);
        for (std::string part; std::getline(parts, part, ':');) {
            if (!number(part, d)) {
                return s;
            }
            list.push_back(d);
        }
        return list.empty() ? json(s) : list.size() == 1 ? list[0] : list;
    };
    for (bool first = true; std::getline(stream, word, ','); first = false) {
        const std::size_t equals = word.find('=');
        if (first && equals == std::string::npos) {
            mesh["file"] = word;
            continue;
        }
        const std::string key = word.substr(0, equals);
        const bool text = key == "material" || key == "part" || key == "file" || key == "shape";
        const json v = equals == std::string::npos ? json(true)
                       : text                      ? json(word.substr(equals + 1))
                                                   : value(word.substr(equals + 1));
        if (key.rfind("scatter.", 0) == 0) {
            mesh["scatter"][key.substr(8)] = v;
        } else if (key.empty() || key == "scatter") {
            throw Error("'" + words + "': '" + word + "' is not a word like priority=2 or scatter.count=20");
        } else {
            mesh[key] = v;
        }
    }
    return mesh.dump();
}

} // namespace stf
