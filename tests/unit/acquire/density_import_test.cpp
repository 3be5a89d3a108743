// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/density_import.h"

#include "stfLib/optics/property_table.h"
#include "stfLib/volume/vdb_dense.h"
#include "stfLib/volume/volume_io.h"
#include "stfLib/volume/volume_statistics.h"
#include "tests/unit/support/files.h"

#include <cmath>
#include <gmock/gmock.h>
#include <limits>

using namespace stf;
using namespace stf::test;
using testing::AllOf;
using testing::HasSubstr;

namespace {

// A cloud as other programs write it: a sparse fog volume somewhere in space, with a smooth density.
openvdb::FloatGrid::Ptr cloud(const openvdb::math::Transform::Ptr& transform, double radius = 9) {
    initializeOpenVdb();
    auto grid = openvdb::FloatGrid::create(0);
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setTransform(transform);
    auto accessor = grid->getAccessor();
    const openvdb::Coord middle(40, -25, 13);
    const int n = int(radius) + 1;
    for (int z = -n; z <= n; ++z) {
        for (int y = -n; y <= n; ++y) {
            for (int x = -n; x <= n; ++x) {
                const double d = std::sqrt(double(x * x + y * y + z * z)) / radius;
                if (d < 1) {
                    accessor.setValue(middle + openvdb::Coord(x, y, z),
                                      float(1.7 * std::pow(std::cos(1.5707963 * d), 2)));
                }
            }
        }
    }
    return grid;
}

double integralOf(const openvdb::FloatGrid& grid) {
    double sum = 0;
    for (auto it = grid.cbeginValueOn(); it; ++it) {
        sum += double(*it) * double(it.getVoxelCount());
    }
    return sum * std::abs(grid.transform().baseMap()->determinant());
}

// Extinction times volume of a channel, mm^2.
double extinctionIntegral(const BaseVolume& v, int channel) {
    double sum = 0;
    for (const Rgb& k : v.extinction) {
        sum += double(k[channel]);
    }
    return sum * v.voxelMm.x * v.voxelMm.y * v.voxelMm.z;
}

class DensityImportTest : public testing::Test {
protected:
    std::string write(const openvdb::GridBase::Ptr& grid) {
        const std::string path = folder.file("cloud.vdb");
        writeVdb(path, {grid}, {});
        options.path = path;
        options.material = PropertyTable::builtIn().find("marble");
        options.mmPerUnit = 10;
        return path;
    }
    ImportedDensity import() {
        Progress progress;
        return importDensity(options, progress);
    }
    void expectConserved(const ImportedDensity& r, double integral, double tolerance) {
        const double mm = std::pow(options.mmPerUnit, 3) * options.densityScale;
        for (int c = 0; c < 3; ++c) {
            const double expected = integral * mm * options.material.extinction()[c];
            EXPECT_NEAR(extinctionIntegral(r.scan.volume, c) / expected, 1, tolerance) << "channel " << c;
        }
        EXPECT_NEAR(r.tileIntegral / r.sourceIntegral, 1, tolerance);
    }
    TemporaryFolder folder;
    DensityImport options;
};

TEST_F(DensityImportTest, ExtinctionIsDensityTimesTheMaterials) {
    const auto grid = cloud(openvdb::math::Transform::createLinearTransform(0.25));
    write(grid);
    options.densityScale = 3;
    const ImportedDensity r = import();
    const BaseVolume& v = r.scan.volume;
    EXPECT_EQ(v.size, Vec3i(17, 17, 17)) << "the box of active voxels";
    EXPECT_NEAR(v.voxelMm.x, 2.5, 1e-12);
    expectConserved(r, integralOf(*grid), 1e-5);
    const std::size_t middle = v.index(8, 8, 8);
    EXPECT_NEAR(v.extinction[middle].y, 3 * 1.7 * options.material.extinction().y, 1e-4);
    EXPECT_NEAR(v.albedo[middle].y, options.material.sigmaS.y / options.material.extinction().y, 1e-6);
    EXPECT_EQ(v.extinction[0], Rgb(0.0f));
    EXPECT_EQ(v.name, "cloud");
    EXPECT_NO_THROW(validate(v));
}

TEST_F(DensityImportTest, ResampledAndAnisotropic) {
    auto transform = openvdb::math::Transform::createLinearTransform(1);
    transform->preScale(openvdb::Vec3d(0.2, 0.3, 0.5));
    const auto grid = cloud(transform);
    write(grid);
    const ImportedDensity own = import();
    EXPECT_NEAR(own.scan.volume.voxelMm.x, 2, 1e-9);
    EXPECT_NEAR(own.scan.volume.voxelMm.z, 5, 1e-9);
    expectConserved(own, integralOf(*grid), 1e-5);
    options.voxelMm = 4.1;
    const ImportedDensity coarse = import();
    EXPECT_NEAR(coarse.scan.volume.voxelMm.y, 4.1, 0.3);
    expectConserved(coarse, integralOf(*grid), 1e-5);
}

TEST_F(DensityImportTest, TurnedAndSheared) {
    for (const bool shear : {false, true}) {
        auto transform = openvdb::math::Transform::createLinearTransform(0.25);
        transform->postRotate(0.5, openvdb::math::X_AXIS);
        transform->postRotate(0.7, openvdb::math::Z_AXIS);
        if (shear) {
            transform->postShear(0.3, openvdb::math::X_AXIS, openvdb::math::Y_AXIS);
        }
        const auto grid = cloud(transform);
        write(grid);
        const ImportedDensity r = import();
        expectConserved(r, integralOf(*grid), 5e-3);
        // A ball turned is a ball: as wide along every axis.
        if (!shear) {
            EXPECT_NEAR(r.scan.volume.extentMm().x, 2 * 9 * 2.5, 7.5);
            EXPECT_NEAR(r.scan.volume.extentMm().x, r.scan.volume.extentMm().z, 7.5);
        }
    }
}

// Depth goes along the axis that is asked for: the upper half is denser.
TEST_F(DensityImportTest, Depth) {
    const auto grid = cloud(openvdb::math::Transform::createLinearTransform(0.25));
    for (auto it = grid->beginValueOn(); it; ++it) {
        it.setValue(*it * (it.getCoord().z() > 13 ? 2.0f : 1.0f));
    }
    write(grid);
    const auto upperShare = [&](const std::string& depth) {
        options.depth = depth;
        const BaseVolume v = import().scan.volume;
        double upper = 0, all = 0;
        for (std::size_t i = 0; i < v.voxelCount(); ++i) {
            const double k = double(v.extinction[i].x);
            all += k;
            upper += i < v.voxelCount() / 2 ? k : 0;
        }
        return upper / all;
    };
    EXPECT_GT(upperShare("-z"), 0.55) << "up is outside";
    EXPECT_LT(upperShare("+z"), 0.45);
    EXPECT_NEAR(upperShare("+x"), 0.5, 0.06);
}

TEST_F(DensityImportTest, JoinsSides) {
    auto grid = openvdb::FloatGrid::create(0);
    grid->setName("density");
    for (int x = 0; x < 30; ++x) {
        for (int y = 0; y < 20; ++y) {
            for (int z = 0; z < 6; ++z) {
                grid->tree().setValue(openvdb::Coord(x, y, z),
                                      1 + 0.1f * float(x) + 0.05f * float((x * 7 + y * 3) % 5));
            }
        }
    }
    write(grid);
    const ImportedDensity apart = import();
    EXPECT_GT(periodicityError(apart.scan.volume, 0), 10);
    options.tiling = ScanRecipe::Tiling::Blend;
    const ImportedDensity joined = import();
    EXPECT_LT(periodicityError(joined.scan.volume, 0), 2);
    expectConserved(joined, integralOf(*grid), 1e-4);
}

TEST_F(DensityImportTest, TellsWhatIsWrong) {
    const auto complaint = [&] { return messageOf<Error>([&] { import(); }); };
    auto grid = cloud(openvdb::math::Transform::createLinearTransform(0.25));
    const std::string path = write(grid);
    options.grid = "smoke";
    EXPECT_THAT(complaint(), AllOf(HasSubstr(path), HasSubstr("smoke"), HasSubstr("density (float)")));
    options.grid = "";
    options.densityScale = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(complaint(), HasSubstr("density scale"));
    options.densityScale = 1;
    options.material = Material();
    EXPECT_THAT(complaint(), HasSubstr("void"));
    grid->tree().setValue(openvdb::Coord(41, -25, 13), -0.5f);
    write(grid);
    EXPECT_THAT(complaint(), AllOf(HasSubstr(path), HasSubstr("negative"), HasSubstr("-0.5")));
    grid->tree().setValue(openvdb::Coord(41, -25, 13), std::numeric_limits<float>::quiet_NaN());
    write(grid);
    EXPECT_THAT(complaint(), AllOf(HasSubstr(path), HasSubstr("nan"), HasSubstr("[41, -25, 13]")));
    grid = cloud(openvdb::math::Transform::createLinearTransform(0.25));
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    write(grid);
    EXPECT_THAT(complaint(), AllOf(HasSubstr(path), HasSubstr("level set")));
    write(openvdb::FloatGrid::create(0));
    EXPECT_THAT(complaint(), AllOf(HasSubstr(path), HasSubstr("no active voxel")));
    write(openvdb::Vec3SGrid::create(openvdb::Vec3s(0)));
    EXPECT_THAT(complaint(), HasSubstr("vec3s"));
    options.path = folder.file("gone.vdb");
    EXPECT_THAT(complaint(), AllOf(HasSubstr("gone.vdb"), HasSubstr("no such file")));
    const auto wide = cloud(openvdb::math::Transform::createLinearTransform(0.25));
    wide->tree().setValue(openvdb::Coord(4000, 4000, 4000), 1.0f);
    write(wide);
    EXPECT_THAT(complaint(), AllOf(HasSubstr(path), HasSubstr("voxels"))) << "refused before it is held";
}

// What we write is what another program's OpenVDB reads: classes, transforms in mm, boxes.
TEST_F(DensityImportTest, WrittenGridsAreThoseOfOthers) {
    const auto grid = cloud(openvdb::math::Transform::createLinearTransform(0.25));
    write(grid);
    BaseVolume v = import().scan.volume;
    v.surface.assign(v.voxelCount(), -1.0f);
    const std::string path = folder.file("out.vdb");
    writeBaseVolume(v, path);
    openvdb::io::File file(path);
    file.open();
    const auto extinction = file.readGrid("extinction"), surface = file.readGrid("surface");
    EXPECT_EQ(extinction->getGridClass(), openvdb::GRID_FOG_VOLUME);
    EXPECT_EQ(extinction->getVectorType(), openvdb::VEC_INVARIANT);
    EXPECT_EQ(surface->getGridClass(), openvdb::GRID_LEVEL_SET);
    EXPECT_TRUE(extinction->transform().isLinear());
    const openvdb::Vec3d middle = extinction->transform().indexToWorld(openvdb::Coord(0, 0, 0));
    EXPECT_NEAR(middle.x(), 0.5 * v.voxelMm.x, 1e-12) << "in mm, values at the middles of voxels";
    EXPECT_TRUE(extinction->getMetadata<openvdb::Vec3IMetadata>("file_bbox_max"));
    EXPECT_EQ(surface->evalActiveVoxelBoundingBox().dim(), openvdb::Coord(v.size.x, v.size.y, v.size.z));
}

} // namespace
