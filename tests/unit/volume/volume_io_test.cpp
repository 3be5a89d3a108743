// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/volume_io.h"

#include "stfLib/volume/vdb_dense.h"
#include "tests/unit/support/file_size_limit.h"
#include "tests/unit/support/files.h"
#include "tests/unit/volume/volumes.h"

using namespace stf;
using namespace stf::test;

namespace {

BaseVolume roundTrip(const BaseVolume& v, std::vector<std::string>* messages = nullptr) {
    const TemporaryFolder folder;
    const std::string path = folder.file("volume.vdb");
    writeBaseVolume(v, path);
    return readBaseVolume(path, [&](Severity, const std::string& text) {
        if (messages) {
            messages->push_back(text);
        }
    });
}

void expectSame(const BaseVolume& a, const BaseVolume& b) {
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.size, b.size);
    EXPECT_EQ(a.voxelMm, b.voxelMm);
    EXPECT_TRUE(a.extinction == b.extinction);
    EXPECT_TRUE(a.albedo == b.albedo);
    EXPECT_TRUE(a.g == b.g);
    EXPECT_TRUE(a.ior == b.ior);
    EXPECT_TRUE(a.surface == b.surface);
    EXPECT_TRUE(a.emission == b.emission);
    EXPECT_EQ(a.coreSigmaA, b.coreSigmaA);
    EXPECT_EQ(a.coreSigmaSPrime, b.coreSigmaSPrime);
    EXPECT_EQ(a.contentHash(), b.contentHash());
}

TEST(VolumeIo, RoundTripOfAllGrids) {
    // The border is zero, hence inactive in the file: the size must come from the metadata.
    for (const Vec3i& size : {Vec3i(7, 5, 3), Vec3i(16, 8, 8), Vec3i(3, 3, 9)}) {
        const BaseVolume v = varied(size);
        std::vector<std::string> messages;
        expectSame(roundTrip(v, &messages), v);
        EXPECT_TRUE(messages.empty());
    }
}

TEST(VolumeIo, AbsentGridsStayAbsent) {
    BaseVolume v = varied({4, 5, 6});
    v.g.clear();
    v.ior.clear();
    v.surface.clear();
    v.emission.clear();
    v.coreSigmaA = v.coreSigmaSPrime = {0, 0, 0};
    v.name.clear();
    std::vector<std::string> messages;
    const BaseVolume r = roundTrip(v, &messages);
    expectSame(r, v);
    EXPECT_FALSE(r.hasCore());
    EXPECT_TRUE(messages.empty());
}

TEST(VolumeIo, EmptyAndTinyTiles) {
    expectSame(roundTrip(homogeneous({5, 4, 3}, {1, 1, 1}, Rgb(0.0f), Rgb(0.0f))),
               homogeneous({5, 4, 3}, {1, 1, 1}, Rgb(0.0f), Rgb(0.0f)));
    const BaseVolume one = homogeneous({1, 1, 1}, {1e-6, 1e3, 0.1}, Rgb(1e9f, 0, 1e-30f), Rgb(1.0f), -0.99f);
    expectSame(roundTrip(one), one);
}

TEST(VolumeIo, VaryingIndexIsExplained) {
    BaseVolume v = homogeneous({2, 2, 4}, {1, 1, 0.5}, Rgb(3.0f), Rgb(0.9f));
    v.ior.assign(v.voxelCount(), 1.5f);
    std::vector<std::string> messages;
    roundTrip(v, &messages);
    EXPECT_TRUE(messages.empty());
    v.ior[3] = 1.3f;
    roundTrip(v, &messages);
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_NE(messages[0].find("volume.vdb: "), std::string::npos);
    EXPECT_NE(messages[0].find("refract"), std::string::npos);
}

TEST(VolumeIo, ContractOfTheFile) {
    const TemporaryFolder folder;
    const std::string path = folder.file("deep/er/volume.vdb"); // folders are made
    const BaseVolume v = varied({7, 5, 3});
    writeBaseVolume(v, path);
    const VdbFile file = readVdb(path);
    EXPECT_EQ(requiredMeta<openvdb::Int32Metadata>(file.metadata, "stf:version"), 1);
    EXPECT_EQ(requiredMeta<openvdb::Vec3IMetadata>(file.metadata, "stf:size"), openvdb::Vec3i(7, 5, 3));
    EXPECT_EQ(requiredMeta<openvdb::Vec3DMetadata>(file.metadata, "stf:voxel_mm"), openvdb::Vec3d(0.5, 0.25, 0.125));
    EXPECT_EQ(requiredMeta<openvdb::StringMetadata>(file.metadata, "stf:name"), "test");
    EXPECT_EQ(requiredMeta<openvdb::Vec3DMetadata>(file.metadata, "stf:core_sigma_s_prime"), openvdb::Vec3d(1, 2, 3));
    ASSERT_EQ(file.grids.size(), 6u);
    for (const auto& grid : file.grids) {
        // Cell-centred: the middle of voxel (0, 0, 0) is half a voxel from the corner of the tile.
        EXPECT_TRUE(grid->transform().indexToWorld(openvdb::Coord(0, 0, 0)).eq({0.25, 0.125, 0.0625}));
        EXPECT_TRUE(grid->transform().indexToWorld(openvdb::Coord(2, 4, 8)).eq({1.25, 1.125, 1.0625}));
    }
    const auto named = std::find_if(file.grids.begin(), file.grids.end(),
                                    [](const auto& grid) { return grid->getName() == "extinction"; });
    ASSERT_NE(named, file.grids.end());
    const auto extinction = openvdb::gridPtrCast<openvdb::Vec3SGrid>(*named);
    ASSERT_TRUE(extinction);
    const Rgb& k = v.extinction[v.index(3, 2, 1)];
    EXPECT_EQ(extinction->tree().getValue({3, 2, 1}), openvdb::Vec3s(k.x, k.y, k.z));
    // No temporary file stays.
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(path).parent_path())) {
        files += entry.is_regular_file();
    }
    EXPECT_EQ(files, 1);
}

TEST(VolumeIo, WritesNothingInvalidAndNowhereImpossible) {
    const TemporaryFolder folder;
    BaseVolume v = varied({4, 4, 4});
    v.albedo[5].x = 2;
    EXPECT_THROW(writeBaseVolume(v, folder.file("a.vdb")), Error);
    EXPECT_FALSE(std::filesystem::exists(folder.file("a.vdb")));
    std::ofstream(folder.file("plain")) << "a file, no folder";
    const std::string below = folder.file("plain/volume.vdb");
    const std::string text = messageOf<Error>([&] { writeBaseVolume(varied({4, 4, 4}), below); });
    EXPECT_EQ(text.find(below + ": "), 0u) << text;
}

TEST(VolumeIo, FullDiskIsReported) {
    const TemporaryFolder folder;
    const std::string path = folder.file("volume.vdb");
    writeBaseVolume(varied({8, 8, 8}), path);
    const auto size = std::filesystem::file_size(path);
    for (std::uintmax_t limit : {std::uintmax_t(1000), size - 1}) {
        const std::string message = messageOf<Error>([&] {
            const FileSizeLimit full(limit);
            writeBaseVolume(varied({8, 8, 8}), path);
        });
        EXPECT_EQ(message.find(path), 0u) << message;
        EXPECT_EQ(std::filesystem::file_size(path), size) << "the old file stays";
        EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1) << "nothing half is left";
    }
}

} // namespace
