// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/volume_io.h"

#include "stfLib/volume/vdb_dense.h"

#include <algorithm>

namespace stf {

namespace {

constexpr int kVersion = 1;

Vec3d optionalVec3d(const openvdb::MetaMap& map, const char* key) {
    const auto value = map.getMetadata<openvdb::Vec3DMetadata>(key);
    return value ? Vec3d(value->value()[0], value->value()[1], value->value()[2]) : Vec3d(0.0);
}

BaseVolume parse(const VdbFile& file, const MessageSink& messages) {
    BaseVolume v;
    const int version = requiredMeta<openvdb::Int32Metadata>(file.metadata, "stf:version");
    if (version > kVersion || version < 1) {
        throw Error("base volume version " + std::to_string(version) +
                    " is not known to this program (it reads up to " + std::to_string(kVersion) + ")");
    }
    const openvdb::Vec3i size = requiredMeta<openvdb::Vec3IMetadata>(file.metadata, "stf:size");
    const openvdb::Vec3d voxel = requiredMeta<openvdb::Vec3DMetadata>(file.metadata, "stf:voxel_mm");
    v.size = {size[0], size[1], size[2]};
    v.voxelMm = {voxel[0], voxel[1], voxel[2]};
    // Before anything is allocated.
    const double count = double(size[0]) * double(size[1]) * double(size[2]);
    if (minComponent(v.size) < 1 || count > double(kMaxVoxels)) {
        throw Error("tile size " + std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
                    std::to_string(size[2]) + " is not usable (1 to " + std::to_string(kMaxVoxels) + " voxels)");
    }
    if (const auto name = file.metadata.getMetadata<openvdb::StringMetadata>("stf:name")) {
        v.name = name->value();
    }
    v.coreSigmaA = optionalVec3d(file.metadata, "stf:core_sigma_a");
    v.coreSigmaSPrime = optionalVec3d(file.metadata, "stf:core_sigma_s_prime");
    v.extinction = readRgbGrid(file.grids, "extinction", v.size);
    v.albedo = readRgbGrid(file.grids, "albedo", v.size);
    v.g = readFloatGrid(file.grids, "g", v.size);
    v.ior = readFloatGrid(file.grids, "ior", v.size);
    v.surface = readFloatGrid(file.grids, "surface", v.size);
    v.emission = readRgbGrid(file.grids, "emission", v.size);
    if (v.extinction.empty() || v.albedo.empty()) {
        throw Error(std::string("grid '") + (v.extinction.empty() ? "extinction" : "albedo") + "' is missing");
    }
    validate(v);
    if (!v.ior.empty()) {
        const auto [low, high] = std::minmax_element(v.ior.begin(), v.ior.end());
        if (*high - *low > 1e-3f && v.surface.empty()) {
            report(
                messages, Severity::Info,
                "the index of refraction varies: it counts where light crosses a surface, inside nothing is refracted");
        }
    }
    return v;
}

} // namespace

BaseVolume readBaseVolume(const std::string& path, const MessageSink& messages) {
    const VdbFile file = readVdb(path);
    try {
        return parse(
            file, [&](Severity severity, const std::string& text) { report(messages, severity, path + ": " + text); });
    } catch (const std::exception& e) {
        throw Error(path + ": " + e.what());
    }
}

void writeBaseVolume(const BaseVolume& v, const std::string& path) {
    validate(v);
    initializeOpenVdb();
    openvdb::GridPtrVec grids;
    // Classes are for other programs, which draw by them.
    const auto add = [&](const auto& values, const char* name, openvdb::GridClass gridClass = openvdb::GRID_UNKNOWN) {
        if (!values.empty()) {
            const openvdb::GridBase::Ptr grid = toGrid(values, v.size, v.voxelMm, name);
            grid->setGridClass(gridClass);
            grids.push_back(grid);
        }
    };
    add(v.extinction, "extinction", openvdb::GRID_FOG_VOLUME);
    add(v.albedo, "albedo");
    add(v.g, "g");
    add(v.ior, "ior");
    add(v.surface, "surface", openvdb::GRID_LEVEL_SET);
    add(v.emission, "emission", openvdb::GRID_FOG_VOLUME);
    const auto vec3d = [](const Vec3d& x) { return openvdb::Vec3DMetadata(openvdb::Vec3d(x.x, x.y, x.z)); };
    openvdb::MetaMap metadata;
    metadata.insertMeta("stf:version", openvdb::Int32Metadata(kVersion));
    metadata.insertMeta("stf:size", openvdb::Vec3IMetadata(openvdb::Vec3i(v.size.x, v.size.y, v.size.z)));
    metadata.insertMeta("stf:voxel_mm", vec3d(v.voxelMm));
    metadata.insertMeta("stf:name", openvdb::StringMetadata(v.name));
    metadata.insertMeta("stf:core_sigma_a", vec3d(v.coreSigmaA));
    metadata.insertMeta("stf:core_sigma_s_prime", vec3d(v.coreSigmaSPrime));
    writeVdb(path, grids, metadata);
}

} // namespace stf
