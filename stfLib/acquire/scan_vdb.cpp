// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_vdb.h"

#include "stfLib/volume/base_volume.h"
#include "stfLib/volume/vdb_dense.h"

#pragma GCC visibility push(default)
#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/Interpolation.h>
#pragma GCC visibility pop

#include <cmath>
#include <sstream>

namespace stf {

namespace {

openvdb::FloatGrid::Ptr pick(const VdbFile& file, const std::string& wanted) {
    std::string known;
    openvdb::FloatGrid::Ptr only;
    int floats = 0;
    for (const auto& base : file.grids) {
        known += (known.empty() ? "" : ", ") + base->getName() + " (" + base->valueType() + ")";
        const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(base);
        if (!grid) {
            if (!wanted.empty() && base->getName() == wanted) {
                throw Error("grid '" + wanted + "' holds " + base->valueType() + ", not float");
            }
            continue;
        }
        if (base->getName() == (wanted.empty() ? "density" : wanted)) {
            return grid;
        }
        only = grid;
        ++floats;
    }
    if (wanted.empty() && floats == 1) {
        return only;
    }
    throw Error((wanted.empty() ? "which grid is the density is not clear" : "there is no grid '" + wanted + "'") +
                std::string(" (there are: ") + (known.empty() ? "none" : known) + ")");
}

bool alongAxes(const openvdb::math::Transform& transform) {
    const openvdb::math::Mat4d m = transform.baseMap()->getAffineMap()->getMat4();
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            if (i == j ? !(m(i, j) > 0) : std::abs(m(i, j)) > 1e-6 * std::abs(m(j, j))) {
                return false;
            }
        }
    }
    return true;
}

double sumOfActive(const openvdb::FloatGrid& grid) {
    double sum = 0;
    for (auto it = grid.cbeginValueOn(); it; ++it) {
        sum += double(*it) * double(it.getVoxelCount());
    }
    return sum;
}

// Voxels along the world's axes with the same integral: point samples of the trilinear interpolant, scaled.
openvdb::FloatGrid::Ptr resampled(const openvdb::FloatGrid& grid, const std::string& name) {
    const openvdb::Vec3d edges = grid.transform().voxelSize();
    const double edge = std::min(edges.x(), std::min(edges.y(), edges.z()));
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    const openvdb::BBoxd world = grid.transform().indexToWorld(box);
    const openvdb::Vec3d cells = world.extents() / edge;
    if (cells.x() * cells.y() * cells.z() > double(kMaxVoxels)) {
        throw Error("grid '" + name + "' is turned or sheared; resampled along the axes it has too many voxels");
    }
    auto result = openvdb::FloatGrid::create(grid.background());
    result->setTransform(openvdb::math::Transform::createLinearTransform(edge));
    openvdb::tools::resampleToMatch<openvdb::tools::BoxSampler>(grid, *result);
    const double before = sumOfActive(grid) * std::abs(grid.transform().baseMap()->determinant());
    const double after = sumOfActive(*result) * edge * edge * edge;
    if (after > 0) {
        const float scale = float(before / after);
        for (auto it = result->beginValueOn(); it; ++it) {
            it.setValue(*it * scale);
        }
    }
    return result;
}

class VdbReader : public ScanReader {
public:
    VdbReader(const std::string& path, const std::string& name, const MessageSink& messages) {
        grid_ = pick(readVdb(path), name);
        if (!grid_->transform().isLinear()) {
            throw Error("grid '" + grid_->getName() + "' has a perspective transform: resample it to a linear one");
        }
        if (grid_->empty()) {
            throw Error("grid '" + grid_->getName() + "' has no active voxel");
        }
        if (!alongAxes(grid_->transform())) {
            report(messages, Severity::Info,
                   "grid '" + grid_->getName() + "' is turned or sheared: resampled to voxels along the axes");
            const std::string gridName = grid_->getName();
            grid_ = resampled(*grid_, gridName);
            grid_->setName(gridName);
        }
        const openvdb::CoordBBox box = grid_->evalActiveVoxelBoundingBox();
        const openvdb::Vec3d edges = grid_->transform().voxelSize();
        lo_ = box.min();
        header_.format = "OpenVDB";
        header_.size = {box.dim().x(), box.dim().y(), box.dim().z()};
        header_.spacingMm = {edges.x(), edges.y(), edges.z()};
        header_.spacingKnown = true;
        header_.type = ScanType::Float32;
    }

    std::uint64_t bufferBytes(const VoxelBox&) const override { return grid_->memUsage(); }

    std::vector<float> read(const VoxelBox& box, Progress& progress) const override {
        progress.update("read", 0);
        std::vector<float> values(box.voxelCount());
        const openvdb::CoordBBox part(lo_ + openvdb::Coord(box.lo.x, box.lo.y, box.lo.z),
                                      lo_ + openvdb::Coord(box.hi.x - 1, box.hi.y - 1, box.hi.z - 1));
        openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(part, values.data());
        openvdb::tools::copyToDense(*grid_, dense);
        progress.update("read", 1);
        return values;
    }

private:
    openvdb::FloatGrid::Ptr grid_;
    openvdb::Coord lo_;
};

std::string classOf(openvdb::GridClass c) {
    switch (c) {
    case openvdb::GRID_FOG_VOLUME:
        return "fog volume";
    case openvdb::GRID_LEVEL_SET:
        return "level set";
    case openvdb::GRID_STAGGERED:
        return "staggered";
    default:
        return "unknown";
    }
}

DensitySummary summarize(const openvdb::FloatGrid& grid) {
    DensitySummary s;
    s.grid = grid.getName();
    s.gridClass = classOf(grid.getGridClass());
    if (grid.empty()) {
        throw Error("grid '" + s.grid + "' has no active voxel");
    }
    const openvdb::Coord size = grid.evalActiveVoxelBoundingBox().dim();
    s.size = {size.x(), size.y(), size.z()};
    const openvdb::Vec3d edges = grid.transform().voxelSize();
    s.voxel = {edges.x(), edges.y(), edges.z()};
    s.lowest = 1e300;
    s.highest = -1e300;
    for (auto it = grid.cbeginValueOn(); it; ++it) {
        const double value = double(*it);
        if (!std::isfinite(value)) {
            std::ostringstream text;
            text << "grid '" << s.grid << "' holds " << value << " at voxel " << it.getCoord();
            throw Error(text.str());
        }
        s.lowest = std::min(s.lowest, value);
        s.highest = std::max(s.highest, value);
        s.integral += value * double(it.getVoxelCount());
        s.active += std::size_t(it.getVoxelCount());
    }
    s.integral *= std::abs(grid.transform().baseMap()->determinant());
    return s;
}

} // namespace

std::unique_ptr<ScanReader> openVdb(const std::string& path, const std::string& grid, const MessageSink& messages) {
    return std::make_unique<VdbReader>(path, grid, messages);
}

DensitySummary summarizeDensity(const std::string& path, const std::string& grid) {
    const VdbFile file = readVdb(path);
    try {
        return summarize(*pick(file, grid));
    } catch (const Error& e) {
        throw Error(path + ": " + e.what());
    }
}

} // namespace stf
