// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/stf_table.h"
#include "stfLib/volume/vdb_dense.h"

namespace stf {

namespace {

constexpr int kTableVersion = 1;

std::string numbered(const char* name, int direction) {
    char text[64];
    std::snprintf(text, sizeof text, "%s_%03d", name, direction);
    return text;
}

// One direction of an interleaved array, as a dense grid, and back.
std::vector<Rgb> slice(const std::vector<float>& values, int directions, int direction) {
    std::vector<Rgb> out(values.size() / 3 / std::size_t(directions));
    for (std::size_t i = 0; i < out.size(); ++i) {
        const float* p = values.data() + (i * std::size_t(directions) + std::size_t(direction)) * 3;
        out[i] = {p[0], p[1], p[2]};
    }
    return out;
}

void unslice(const std::vector<Rgb>& in, int directions, int direction, std::vector<float>& values) {
    values.resize(in.size() * std::size_t(directions) * 3);
    for (std::size_t i = 0; i < in.size(); ++i) {
        float* p = values.data() + (i * std::size_t(directions) + std::size_t(direction)) * 3;
        p[0] = in[i].x, p[1] = in[i].y, p[2] = in[i].z;
    }
}

} // namespace

void writeTable(const StfTable& t, const std::string& key, const std::string& path) {
    initializeOpenVdb();
    const Vec3i columns{t.size.x, t.size.y, 1};
    openvdb::GridPtrVec grids;
    const int n = t.directions.count();
    for (int d = 0; d < n; ++d) {
        grids.push_back(toGrid(slice(t.multiple, n, d), t.size, t.voxelMm, numbered("multiple", d)));
        grids.push_back(toGrid(slice(t.transmitted, n, d), columns, t.voxelMm, numbered("transmitted", d)));
        grids.push_back(toGrid(slice(t.direct, n, d), columns, t.voxelMm, numbered("direct", d)));
    }
    grids.push_back(toGrid(t.backlight, t.size, t.voxelMm, "backlight"));
    grids.push_back(toGrid(t.reflectedBelow, columns, t.voxelMm, "reflected_below"));

    openvdb::MetaMap m;
    m.insertMeta("stf:table_version", openvdb::Int32Metadata(kTableVersion));
    m.insertMeta("stf:key", openvdb::StringMetadata(key));
    m.insertMeta("stf:size", openvdb::Vec3IMetadata(openvdb::Vec3i(t.size.x, t.size.y, t.size.z)));
    m.insertMeta("stf:voxel_mm", openvdb::Vec3DMetadata(openvdb::Vec3d(t.voxelMm.x, t.voxelMm.y, t.voxelMm.z)));
    m.insertMeta("stf:polars", openvdb::Int32Metadata(t.directions.polars()));
    m.insertMeta("stf:azimuths", openvdb::Int32Metadata(t.directions.azimuths()));
    m.insertMeta("stf:volume_hash", openvdb::StringMetadata(t.volumeHash));
    m.insertMeta("stf:form", openvdb::StringMetadata(t.form));
    m.insertMeta("stf:photons", openvdb::Int64Metadata(std::int64_t(t.photonsPerDirection)));
    m.insertMeta("stf:seed", openvdb::Int64Metadata(std::int64_t(t.seed)));
    m.insertMeta("stf:relative_error", openvdb::DoubleMetadata(t.relativeError));
    m.insertMeta("stf:seconds", openvdb::DoubleMetadata(t.seconds));
    writeVdb(path, grids, m);
}

StfTable readTable(const std::string& path, const std::string& key) {
    const VdbFile file = readVdb(path);
    try {
        const openvdb::MetaMap& m = file.metadata;
        if (requiredMeta<openvdb::Int32Metadata>(m, "stf:table_version") != kTableVersion ||
            (!key.empty() && requiredMeta<openvdb::StringMetadata>(m, "stf:key") != key)) {
            throw Error("the table was made for something else");
        }
        StfTable t;
        const openvdb::Vec3i size = requiredMeta<openvdb::Vec3IMetadata>(m, "stf:size");
        const openvdb::Vec3d voxel = requiredMeta<openvdb::Vec3DMetadata>(m, "stf:voxel_mm");
        t.size = {size[0], size[1], size[2]};
        t.voxelMm = {voxel[0], voxel[1], voxel[2]};
        t.directions = DirectionSet(requiredMeta<openvdb::Int32Metadata>(m, "stf:polars"),
                                    requiredMeta<openvdb::Int32Metadata>(m, "stf:azimuths"));
        t.volumeHash = requiredMeta<openvdb::StringMetadata>(m, "stf:volume_hash");
        t.form = requiredMeta<openvdb::StringMetadata>(m, "stf:form");
        t.photonsPerDirection = std::uint64_t(requiredMeta<openvdb::Int64Metadata>(m, "stf:photons"));
        t.seed = std::uint64_t(requiredMeta<openvdb::Int64Metadata>(m, "stf:seed"));
        t.relativeError = requiredMeta<openvdb::DoubleMetadata>(m, "stf:relative_error");
        t.seconds = requiredMeta<openvdb::DoubleMetadata>(m, "stf:seconds");

        const Vec3i columns{t.size.x, t.size.y, 1};
        const auto grid = [&](const std::string& name, const Vec3i& gridSize) {
            std::vector<Rgb> values = readRgbGrid(file.grids, name, gridSize);
            if (values.empty()) {
                throw Error("grid '" + name + "' is missing");
            }
            return values;
        };
        const int n = t.directions.count();
        for (int d = 0; d < n; ++d) {
            unslice(grid(numbered("multiple", d), t.size), n, d, t.multiple);
            unslice(grid(numbered("transmitted", d), columns), n, d, t.transmitted);
            unslice(grid(numbered("direct", d), columns), n, d, t.direct);
        }
        t.backlight = grid("backlight", t.size);
        t.reflectedBelow = grid("reflected_below", columns);
        return t;
    } catch (const std::exception& e) {
        throw Error(path + ": " + e.what());
    }
}

} // namespace stf
