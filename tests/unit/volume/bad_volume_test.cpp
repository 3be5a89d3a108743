// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/vdb_dense.h"
#include "stfLib/volume/volume_io.h"
#include "tests/unit/support/files.h"
#include "tests/unit/volume/volumes.h"

#include <limits>

using namespace stf;
using namespace stf::test;

namespace {

openvdb::MetaMap metadata(const openvdb::Vec3i& size, int version = 1) {
    openvdb::MetaMap m;
    m.insertMeta("stf:version", openvdb::Int32Metadata(version));
    m.insertMeta("stf:size", openvdb::Vec3IMetadata(size));
    m.insertMeta("stf:voxel_mm", openvdb::Vec3DMetadata(openvdb::Vec3d(1, 1, 1)));
    return m;
}

class BadVolume : public testing::Test {
protected:
    // The complaint about a file, without the path that it must start with.
    std::string complaint(const std::string& path) const {
        const std::string text = messageOf<Error>([&] { readBaseVolume(path); });
        EXPECT_EQ(text.find(path + ": "), 0u) << text;
        EXPECT_EQ(text.find('\n'), std::string::npos) << "one sentence: " << text;
        return text.size() > path.size() ? text.substr(path.size()) : text;
    }
    std::string complaint(const openvdb::GridPtrVec& grids, const openvdb::MetaMap& m) const {
        writeVdb(path_, grids, m);
        return complaint(path_);
    }
    void expectComplaint(const std::string& text, const std::string& part) const {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    }

    const TemporaryFolder folder_;
    const std::string path_ = folder_.file("bad.vdb");
    const Vec3i size_{3, 3, 3};
    const std::vector<Rgb> half_ = std::vector<Rgb>(27, Rgb(0.5f));
    openvdb::GridBase::Ptr rgb(const std::vector<Rgb>& v, const char* name) const {
        return toGrid(v, size_, {1, 1, 1}, name);
    }
};

TEST_F(BadVolume, MissingFile) {
    expectComplaint(complaint(folder_.file("nowhere.vdb")), "no such file");
    complaint(folder_.path().string()); // a folder
}

TEST_F(BadVolume, NotOpenVdb) {
    std::ofstream(path_) << "This is a text.";
    expectComplaint(complaint(path_), "not a readable OpenVDB file");
    std::ofstream(path_, std::ios::trunc).flush();
    expectComplaint(complaint(path_), "not a readable OpenVDB file");
}

TEST_F(BadVolume, TruncatedAnywhere) {
    const std::string whole = folder_.file("whole.vdb");
    writeBaseVolume(varied({9, 9, 9}), whole);
    std::ifstream in(whole, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(in)), {});
    ASSERT_GT(bytes.size(), 5000u);
    for (std::size_t length = 0; length < bytes.size(); length += length < 1500 ? 7 : 211) {
        std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes.substr(0, length);
        SCOPED_TRACE(length);
        complaint(path_);
    }
}

TEST_F(BadVolume, NoMetadata) {
    expectComplaint(complaint({rgb(half_, "extinction"), rgb(half_, "albedo")}, {}), "stf:version");
    openvdb::MetaMap m = metadata({3, 3, 3});
    m.removeMeta("stf:size");
    expectComplaint(complaint({rgb(half_, "extinction"), rgb(half_, "albedo")}, m), "stf:size");
    m = metadata({3, 3, 3});
    m.removeMeta("stf:voxel_mm");
    m.insertMeta("stf:voxel_mm", openvdb::FloatMetadata(1)); // of another type
    expectComplaint(complaint({rgb(half_, "extinction"), rgb(half_, "albedo")}, m), "stf:voxel_mm");
}

TEST_F(BadVolume, AnotherVersion) {
    for (int version : {2, 99, 0, -1}) {
        expectComplaint(complaint({rgb(half_, "extinction"), rgb(half_, "albedo")}, metadata({3, 3, 3}, version)),
                        "version " + std::to_string(version));
    }
}

TEST_F(BadVolume, AbsurdSizes) {
    constexpr int kMax = std::numeric_limits<int>::max();
    for (const openvdb::Vec3i& s : {openvdb::Vec3i(0, 3, 3), openvdb::Vec3i(-3, -3, 3),
                                    openvdb::Vec3i(kMax, kMax, kMax), openvdb::Vec3i(100000, 100000, 1)}) {
        expectComplaint(complaint({rgb(half_, "extinction"), rgb(half_, "albedo")}, metadata(s)), "tile size");
    }
}

TEST_F(BadVolume, MissingGrids) {
    expectComplaint(complaint({rgb(half_, "albedo")}, metadata({3, 3, 3})), "'extinction' is missing");
    expectComplaint(complaint({rgb(half_, "extinction")}, metadata({3, 3, 3})), "'albedo' is missing");
    expectComplaint(complaint({}, metadata({3, 3, 3})), "'extinction' is missing");
}

TEST_F(BadVolume, GridOfAnotherType) {
    const auto scalar = toGrid(std::vector<float>(27, 0.5f), size_, {1, 1, 1}, "albedo");
    expectComplaint(complaint({rgb(half_, "extinction"), scalar}, metadata({3, 3, 3})), "'albedo'");
    expectComplaint(complaint({rgb(half_, "extinction"), rgb(half_, "albedo"), rgb(half_, "g")}, metadata({3, 3, 3})),
                    "'g'");
}

TEST_F(BadVolume, BadValues) {
    const auto with = [&](float value) {
        std::vector<Rgb> values = half_;
        values[13].y = value; // the middle
        return values;
    };
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (float bad : {nan, -1.0f, std::numeric_limits<float>::infinity()}) {
        const std::string text = complaint({rgb(with(bad), "extinction"), rgb(half_, "albedo")}, metadata({3, 3, 3}));
        expectComplaint(text, "'extinction'");
        expectComplaint(text, "(1, 1, 1)");
    }
    expectComplaint(complaint({rgb(half_, "extinction"), rgb(with(1.5f), "albedo")}, metadata({3, 3, 3})), "'albedo'");
    std::vector<float> g(27, 0.2f);
    g[13] = 1.0f;
    expectComplaint(complaint({rgb(half_, "extinction"), rgb(half_, "albedo"), toGrid(g, size_, {1, 1, 1}, "g")},
                              metadata({3, 3, 3})),
                    "'g'");
}

TEST_F(BadVolume, BackgroundFillsWhatTheFileLeavesOut) {
    // A file of another program may hold sparse grids with a background of their own.
    auto albedo = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.25f, 0.5f, 0.75f));
    albedo->setName("albedo");
    albedo->tree().setValue({1, 1, 1}, openvdb::Vec3s(0.125f));
    writeVdb(path_, {rgb(half_, "extinction"), albedo}, metadata({3, 3, 3}));
    const BaseVolume v = readBaseVolume(path_);
    EXPECT_EQ(v.albedo[v.index(1, 1, 1)], Rgb(0.125f));
    EXPECT_EQ(v.albedo[v.index(2, 0, 1)], Rgb(0.25f, 0.5f, 0.75f));
}

} // namespace
