// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/scan_arguments.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace stf {

namespace {

using Json = nlohmann::json;

double numberOf(const std::string& text, const char* option) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != 0) {
        throw CLI::ValidationError(std::string(option) + ": '" + text + "' is no number");
    }
    return value;
}

// "120:0,1" to [120, 0, 1]
Json pointOf(const std::string& text) {
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos) {
        throw CLI::ValidationError("--point takes VALUE:FRACTION,FRACTION,.., not '" + text + "'");
    }
    Json point = Json::array({numberOf(text.substr(0, colon), "--point")});
    std::istringstream rest(text.substr(colon + 1));
    for (std::string word; std::getline(rest, word, ',');) {
        point.push_back(numberOf(word, "--point"));
    }
    return point;
}

void put(Json& json, const char* key, const std::string& text) {
    if (!text.empty()) {
        json[key] = text;
    }
}
void put(Json& json, const char* key, const std::vector<double>& numbers) {
    if (numbers.size() == 1) {
        json[key] = numbers[0];
    } else if (!numbers.empty()) {
        json[key] = numbers;
    }
}

// A number where it is one, else a word.
void putEither(Json& json, const char* key, const std::string& text) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (!text.empty()) {
        json[key] = *end == 0 ? Json(value) : Json(text);
    }
}

std::string textOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    if (!in || !(text << in.rdbuf())) {
        throw Error(path + ": cannot be read");
    }
    return text.str();
}

} // namespace

void ScanArguments::addTo(CLI::App& c) {
    c.add_option("files", files_, "INPUT OUT.vdb, or with --recipe OUT.vdb alone")->required()->expected(1, 2);
    c.add_option("--recipe", recipe_, "A JSON file that says what options say; options count more");
    c.add_option("--name", name_, "Name of the volume");
    c.add_option("--dims", dims_, "Of a file without a header: voxels X,Y,Z")->delimiter(',')->expected(3);
    c.add_option("--type", type_, "Of such a file: uint8 int8 uint16 int16 uint32 int32 float32 float64");
    c.add_option("--endian", endian_, "Of such a file: little or big");
    c.add_option("--header-bytes", headerBytes_, "Of such a file: bytes before the first voxel")->expected(1);
    c.add_option("--series", series_, "UID of the series of a folder of DICOM files");
    c.add_option("--spacing", spacing_, "Distance of voxels in mm: one number or X,Y,Z")
        ->delimiter(',')
        ->expected(1, 3);
    c.add_option("--nan", nan_, "Value for voxels that are not finite")->expected(1);
    c.add_option("--crop", crop_, "Part of the scan: X0:X1,Y0:Y1,Z0:Z1 in voxels, or mm (0:20mm)");
    c.add_option("--depth", depth_, "Axis of the scan that goes inward: +x -x +y -y +z -z");
    c.add_option("--scale", scale_, "Multiplies all sizes")->expected(1);
    c.add_option("--voxel", voxel_, "Edges of the tile's voxels in mm: one number or X,Y,Z")
        ->delimiter(',')
        ->expected(1, 3);
    c.add_option("--classify", method_, "transfer, thresholds, otsu or gmm");
    c.add_option("--materials", materials_, "In order of brightness, 'none' for a void: A,B,..")->delimiter(',');
    c.add_option("--table", table_, "A table of materials of your own");
    c.add_option("--core", core_, "Material of the core below the shell; without: the tile's mean");
    c.add_option("--point", points_, "transfer: VALUE:FRACTION,FRACTION,.. (repeat)");
    c.add_option("--thresholds", thresholds_, "thresholds: A,B,..")->delimiter(',');
    c.add_option("--widths", widths_, "thresholds: widths of their ramps, one or all")->delimiter(',');
    c.add_option("--gradient", gradient_, "LOW:HIGH in values per mm: classify edges by the materials at both sides");
    c.add_option("--tile", tile_, "none, blend or quilt");
    c.add_option("--overlap", overlap_, "Voxels of the tile at its sides, or X,Y")->delimiter(',')->expected(1, 2);
    c.add_option("--iso", iso_, "Value of the surface, or auto");
    c.add_option("--smooth", smooth_, "Voxels: what is taken off the surface as noise")->expected(1);
    c.add_option("--top", top_, "Where z = 0 is: auto, or mm below the first layer");
    c.add_option("--max-memory", memory_, "MB; what takes more is refused")->expected(1);
    c.add_option("--threads", threads_, "0: all cores")->check(CLI::NonNegativeNumber);
    c.add_flag("--json", json_, "Print a line of JSON");
}

ScanRecipe ScanArguments::recipe() const {
    Json patch = Json::object(), raw = Json::object(), classify = Json::object();
    if (files_.size() == 2) {
        patch["input"] = files_[0];
    } else if (recipe_.empty()) {
        throw CLI::ValidationError("INPUT and OUT.vdb are both needed without --recipe");
    }
    put(raw, "dims", dims_);
    put(raw, "type", type_);
    put(raw, "endian", endian_);
    put(raw, "headerBytes", headerBytes_);
    put(patch, "name", name_);
    put(patch, "series", series_);
    put(patch, "spacing", spacing_);
    put(patch, "nan", nan_);
    put(patch, "crop", crop_);
    put(patch, "depth", depth_);
    put(patch, "scale", scale_);
    put(patch, "voxel", voxel_);
    put(patch, "table", table_);
    put(patch, "core", core_);
    put(patch, "tile", tile_);
    put(patch, "overlap", overlap_);
    putEither(patch, "iso", iso_);
    put(patch, "smooth", smooth_);
    putEither(patch, "top", top_);
    put(patch, "maxMemoryMB", memory_);
    put(classify, "method", method_);
    if (!materials_.empty()) {
        classify["materials"] = materials_;
    }
    for (const std::string& point : points_) {
        classify["points"].push_back(pointOf(point));
    }
    if (!thresholds_.empty()) {
        classify["thresholds"] = thresholds_;
    }
    if (!widths_.empty()) {
        classify["widths"] = widths_;
    }
    if (!gradient_.empty()) {
        const std::size_t colon = gradient_.find(':');
        if (colon == std::string::npos) {
            throw CLI::ValidationError("--gradient takes LOW:HIGH");
        }
        classify["gradient"] = {numberOf(gradient_.substr(0, colon), "--gradient"),
                                numberOf(gradient_.substr(colon + 1), "--gradient")};
    }
    if (!raw.empty()) {
        patch["raw"] = raw;
    }
    if (!classify.empty()) {
        patch["classify"] = classify;
    }
    return parseScanRecipe(recipe_.empty() ? "{}" : textOf(recipe_), patch.dump(), recipe_,
                           std::filesystem::path(recipe_).parent_path().string());
}

} // namespace stf
