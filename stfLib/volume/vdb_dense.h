// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to stfLib's sources: names OpenVDB types.
#include "stfLib/base/error.h"
#include "stfLib/base/openvdb_headers.h"
#include "stfLib/base/vec.h"

#include <string>
#include <vector>

namespace stf {

/// Registers OpenVDB's types, once per process.
void initializeOpenVdb();

/// Dense arrays (x fastest) to grids and back. `read` returns an empty array for a missing grid and throws Error for
/// one of another type.
openvdb::GridBase::Ptr toGrid(const std::vector<Rgb>& values, const Vec3i& size, const Vec3d& voxelMm,
                              const std::string& name);
openvdb::GridBase::Ptr toGrid(const std::vector<float>& values, const Vec3i& size, const Vec3d& voxelMm,
                              const std::string& name);
std::vector<Rgb> readRgbGrid(const openvdb::GridPtrVec& grids, const std::string& name, const Vec3i& size);
std::vector<float> readFloatGrid(const openvdb::GridPtrVec& grids, const std::string& name, const Vec3i& size);

/// Opens and reads a whole file. Throws Error with a message that starts with the path.
struct VdbFile {
    openvdb::GridPtrVec grids;
    openvdb::MetaMap metadata;
};
VdbFile readVdb(const std::string& path);
/// Writes beside the target and renames. Throws Error.
void writeVdb(const std::string& path, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata);

/// Metadata that must be there, with its type. Throws Error.
template<class Meta>
auto requiredMeta(const openvdb::MetaMap& map, const char* key) {
    const auto value = map.getMetadata<Meta>(key);
    if (!value) {
        throw Error(std::string("metadata '") + key + "' is missing or of another type");
    }
    return value->value();
}

} // namespace stf
