// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/vdb_dense.h"

#include "stfLib/base/error.h"

#include <filesystem>
#include <fstream>
#include <mutex>
#include <unistd.h>

namespace stf {

namespace {

using openvdb::tools::Dense;
using openvdb::tools::LayoutXYZ;

constexpr double kSmallestVoxelMm3 = 1e-14;

openvdb::CoordBBox boxOf(const Vec3i& size) {
    return {openvdb::Coord(0, 0, 0), openvdb::Coord(size.x - 1, size.y - 1, size.z - 1)};
}

template<class Grid, class Value, class T>
openvdb::GridBase::Ptr make(const std::vector<T>& values, const Vec3i& size, const Vec3d& voxelMm,
                            const std::string& name) {
    static_assert(sizeof(Value) == sizeof(T), "the arrays are handed to OpenVDB as they are");
    auto grid = Grid::create();
    grid->setName(name);
    // LayoutXYZ: x is the fastest index, as in the dense arrays.
    const Dense<const Value, LayoutXYZ> dense(boxOf(size), reinterpret_cast<const Value*>(values.data()));
    // Tolerance 0 keeps every value; inactive background would be lost where a value equals it.
    openvdb::tools::copyFromDense(dense, grid->tree(), openvdb::zeroVal<Value>());
    // Cell-centred: the middle of voxel (i, j, k) is at (i + 1/2, ...) voxel sizes.
    // OpenVDB takes a volume of less than 1e-15 for singular: such a grid keeps its index space, for the size that
    // counts is that of the metadata.
    if (voxelMm.x * voxelMm.y * voxelMm.z > kSmallestVoxelMm3) {
        auto map = openvdb::math::Transform::createLinearTransform();
        map->preScale(openvdb::Vec3d(voxelMm.x, voxelMm.y, voxelMm.z));
        map->postTranslate(openvdb::Vec3d(0.5 * voxelMm.x, 0.5 * voxelMm.y, 0.5 * voxelMm.z));
        grid->setTransform(map);
    }
    // For other programs: vectors are colours, that turn with nothing.
    grid->setVectorType(openvdb::VEC_INVARIANT);
    return grid;
}

template<class Grid, class Value, class T>
std::vector<T> extract(const openvdb::GridPtrVec& grids, const std::string& name, const Vec3i& size) {
    for (const auto& base : grids) {
        if (base->getName() != name) {
            continue;
        }
        const auto grid = openvdb::gridPtrCast<Grid>(base);
        if (!grid) {
            throw Error("grid '" + name + "' has type " + base->type() + ", expected " + Grid::gridType());
        }
        std::vector<T> values(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
        Dense<Value, LayoutXYZ> dense(boxOf(size), reinterpret_cast<Value*>(values.data()));
        openvdb::tools::copyToDense(*grid, dense);
        return values;
    }
    return {};
}

// What io::File writes, to a stream of the caller's: io::File::write() does not look whether the disk took it all.
class CheckedArchive : public openvdb::io::Archive {
public:
    void writeTo(std::ostream& out, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata) const {
        Archive::write(out, grids, /*seekable=*/true, metadata);
    }
};

} // namespace

void initializeOpenVdb() {
    static std::once_flag once;
    std::call_once(once, [] { openvdb::initialize(); });
}

openvdb::GridBase::Ptr toGrid(const std::vector<Rgb>& values, const Vec3i& size, const Vec3d& voxelMm,
                              const std::string& name) {
    return make<openvdb::Vec3SGrid, openvdb::Vec3s>(values, size, voxelMm, name);
}

openvdb::GridBase::Ptr toGrid(const std::vector<float>& values, const Vec3i& size, const Vec3d& voxelMm,
                              const std::string& name) {
    return make<openvdb::FloatGrid, float>(values, size, voxelMm, name);
}

std::vector<Rgb> readRgbGrid(const openvdb::GridPtrVec& grids, const std::string& name, const Vec3i& size) {
    return extract<openvdb::Vec3SGrid, openvdb::Vec3s, Rgb>(grids, name, size);
}

std::vector<float> readFloatGrid(const openvdb::GridPtrVec& grids, const std::string& name, const Vec3i& size) {
    return extract<openvdb::FloatGrid, float, float>(grids, name, size);
}

VdbFile readVdb(const std::string& path) {
    initializeOpenVdb();
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) {
        throw Error(path + ": no such file");
    }
    try {
        // OpenVDB trusts the lengths in a file; a stream that throws at its end stops it where a file was cut off,
        // before it allocates what was never read. Nothing is loaded later: a damaged file must fail here.
        std::ifstream in;
        in.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
        in.open(path, std::ios::binary);
        openvdb::io::Stream stream(in, false);
        VdbFile result;
        result.grids = *stream.getGrids();
        result.metadata = *stream.getMetadata();
        return result;
    } catch (const std::exception& e) {
        throw Error(path + ": not a readable OpenVDB file (" + e.what() + ")");
    }
}

void writeVdb(const std::string& path, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata) {
    initializeOpenVdb();
    namespace fs = std::filesystem;
    const fs::path target(path);
    const fs::path temporary = target.string() + "." + std::to_string(::getpid()) + ".tmp";
    try {
        if (target.has_parent_path()) {
            fs::create_directories(target.parent_path());
        }
        std::ofstream out;
        out.exceptions(std::ios::failbit | std::ios::badbit);
        out.open(temporary, std::ios::binary | std::ios::trunc);
        CheckedArchive().writeTo(out, grids, metadata);
        out.close();
        fs::rename(temporary, target);
    } catch (const std::exception& e) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw Error(path + ": cannot be written (" + e.what() + ")");
    }
}

} // namespace stf
