// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/openvdb_headers.h"

#include "stfLib/shell/shell_grid_impl.h"

#include <filesystem>

namespace stf {

namespace {

/// One number of every sample of a level, as an OpenVDB grid of the same leaves.
template<class Grid, class Value>
typename Grid::Ptr toOpenVdb(const ShellLevel& level, const char* name, const Value& value) {
    using Leaf = typename Grid::TreeType::LeafNodeType;
    static_assert(Leaf::DIM == kLeafSize, "leaves are those of the grid");
    const auto grid = Grid::create();
    for (const ShellLeaf& from : level.leaves()) {
        auto leaf = std::make_unique<Leaf>(openvdb::Coord(from.origin.x, from.origin.y, from.origin.z));
        const ShellSample* sample = from.samples;
        for (int row = 0; row < kLeafRows; ++row) {
            for (int z = 0; z < kLeafSize; ++z) {
                if (from.row[row] >> z & 1) {
                    leaf->setValueOn(openvdb::Index(row * kLeafSize + z), value(level.codec.unpack(*sample++)));
                }
            }
        }
        grid->tree().addLeaf(leaf.release());
    }
    const auto transform = openvdb::math::Transform::createLinearTransform(level.voxel);
    transform->postTranslate(openvdb::Vec3d(level.origin.x, level.origin.y, level.origin.z));
    grid->setTransform(transform);
    grid->setName(name);
    return grid;
}

} // namespace

void ShellGrid::write(const std::string& path) const {
    openvdb::initialize();
    if (impl_->levels.empty()) {
        throw Error("cannot write " + path + ": the shell grid is empty");
    }
    const ShellLevel& level = impl_->levels.front();
    openvdb::GridPtrVec grids;
    using openvdb::FloatGrid;
    grids.push_back(toOpenVdb<FloatGrid>(level, "exemplar_x", [](const ShellPoint& p) { return float(p.exemplar.x); }));
    grids.push_back(toOpenVdb<FloatGrid>(level, "exemplar_y", [](const ShellPoint& p) { return float(p.exemplar.y); }));
    grids.push_back(toOpenVdb<FloatGrid>(level, "depth", [](const ShellPoint& p) { return float(p.depth); }));
    grids.push_back(toOpenVdb<openvdb::Vec3SGrid>(level, "normal", [](const ShellPoint& p) {
        return openvdb::Vec3f(float(p.normal.x), float(p.normal.y), float(p.normal.z));
    }));
    grids.push_back(
        toOpenVdb<openvdb::Int32Grid>(level, "triangle", [](const ShellPoint& p) { return std::int32_t(p.triangle); }));
    const std::string temporary = path + ".part";
    try {
        openvdb::io::File(temporary).write(grids);
        std::filesystem::rename(temporary, path);
    } catch (const std::exception& e) {
        std::error_code ignored;
        std::filesystem::remove(temporary, ignored);
        throw Error("cannot write " + path + ": " + e.what());
    }
}

} // namespace stf
