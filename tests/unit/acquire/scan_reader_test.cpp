// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_reader.h"

#include "stfLib/base/random.h"
#include "tests/unit/acquire/scan_files.h"
#include "tests/unit/support/files.h"

#include <zlib.h>

using namespace stf;
using namespace stf::test;

namespace {

class ScanFiles : public testing::Test {
protected:
    std::string file(const std::string& name) const { return folder_.file(name); }
    // Odd sizes that differ, so that no mistake of axes goes unseen.
    const Scan ball_ = ballScan({13, 10, 9}, {0.5, 0.75, 1.25});
    TemporaryFolder folder_;
    std::vector<std::string> told_;
    const MessageSink messages_ = [this](Severity, const std::string& t) { told_.push_back(t); };

    void expectBall(const std::string& path, const std::string& format, const ScanReadOptions& options = {},
                    bool spacing = true, double factor = 1, double offset = 0) {
        SCOPED_TRACE(path);
        const auto reader = openScan(path, options, messages_);
        EXPECT_EQ(reader->header().format, format);
        ASSERT_EQ(reader->header().size, ball_.size);
        EXPECT_EQ(reader->header().spacingKnown, spacing);
        if (spacing) {
            EXPECT_NEAR(length(reader->header().spacingMm - ball_.spacingMm), 0, 1e-6);
        }
        Progress progress;
        for (const VoxelBox& box : {VoxelBox{{0, 0, 0}, ball_.size}, VoxelBox{{2, 3, 1}, {7, 9, 5}}}) {
            const std::vector<float> values = reader->read(box, progress);
            ASSERT_EQ(values.size(), box.voxelCount());
            std::size_t i = 0;
            for (int z = box.lo.z; z < box.hi.z; ++z) {
                for (int y = box.lo.y; y < box.hi.y; ++y) {
                    for (int x = box.lo.x; x < box.hi.x; ++x) {
                        ASSERT_EQ(values[i++], float(factor * double(ball_.values[ball_.index(x, y, z)]) + offset))
                            << x << " " << y << " " << z;
                    }
                }
            }
        }
    }
    ScanReadOptions raw(ScanType type, bool bigEndian = false, std::uint64_t header = 0) const {
        ScanReadOptions o;
        o.raw = true;
        o.layout = {ball_.size, type, bigEndian, header};
        return o;
    }
};

TEST_F(ScanFiles, RawOfAllTypes) {
    const auto check = [&](auto type, ScanType scanType) {
        for (const bool big : {false, true}) {
            Bytes b;
            b.pad(17, 'x');
            addValues<decltype(type)>(b, ball_, big);
            b.write(file("a.raw"));
            expectBall(file("a.raw"), "raw", raw(scanType, big, 17), false);
        }
    };
    check(std::uint8_t(), ScanType::UInt8);
    check(std::uint16_t(), ScanType::UInt16);
    check(std::int16_t(), ScanType::Int16);
    check(std::uint32_t(), ScanType::UInt32);
    check(std::int32_t(), ScanType::Int32);
    check(float(), ScanType::Float32);
    check(double(), ScanType::Float64);
    EXPECT_TRUE(told_.empty());
    EXPECT_EQ(scanTypeOf("int8"), ScanType::Int8);
    EXPECT_NE(messageOf<Error>([] { scanTypeOf("half"); }).find("float32"), std::string::npos);
}

TEST_F(ScanFiles, Inr) {
    Bytes b = inrFile(ball_);
    addValues<std::uint8_t>(b, ball_);
    b.write(file("a.inr"));
    expectBall(file("a.inr"), "INR");

    Bytes big = inrFile(ball_, "float", 32, "sun");
    addValues<float>(big, ball_, true);
    big.write(file("b.inr"));
    expectBall(file("b.inr"), "INR");

    const gzFile gz = ::gzopen(file("c.inr.gz").c_str(), "wb");
    ::gzwrite(gz, b.data().data(), unsigned(b.size()));
    ::gzclose(gz);
    expectBall(file("c.inr.gz"), "INR");
}

TEST_F(ScanFiles, Nrrd) {
    Bytes b = nrrdFile(ball_, "int16");
    addValues<std::int16_t>(b, ball_);
    b.write(file("a.nrrd"));
    expectBall(file("a.nrrd"), "NRRD");
}

TEST_F(ScanFiles, MetaImage) {
    Bytes b = metaFile(ball_, "MET_SHORT", 1, true);
    addValues<std::int16_t>(b, ball_, true);
    b.write(file("a.mha"));
    expectBall(file("a.mha"), "MetaImage");
}

TEST_F(ScanFiles, Nifti) {
    for (const bool big : {false, true}) {
        Bytes b = niftiFile(ball_, 4, 16, 1, big);
        addValues<std::int16_t>(b, ball_, big);
        b.write(file("a.nii"));
        expectBall(file("a.nii"), "NIfTI");
    }
}

TEST_F(ScanFiles, TiffPages) {
    tiffFile(ball_, 0, ball_.size.z).write(file("a.tif"));
    expectBall(file("a.tif"), "TIFF", {}, false);
}

TEST_F(ScanFiles, TiffFolderInTheOrderOfNumbers) {
    std::filesystem::create_directory(file("slices"));
    // Three digits from 98 on: by letters the order would be another.
    for (int z = 0; z < ball_.size.z; ++z) {
        tiffFile(ball_, z, 1).write(file("slices/slice" + std::to_string(94 + z) + ".tiff"));
    }
    Bytes().text("notes").write(file("slices/readme.txt"));
    expectBall(file("slices"), "TIFF", {}, false);
}

TEST_F(ScanFiles, DicomSeriesByPosition) {
    std::filesystem::create_directory(file("dicom"));
    for (int z = 0; z < ball_.size.z; ++z) {
        dicomSlice(ball_, z).write(file("dicom/im" + std::to_string((z * 5) % ball_.size.z)));
    }
    // Rescaled as the header says: 2 v - 1000.
    expectBall(file("dicom"), "DICOM", {}, true, 2, -1000);
    EXPECT_TRUE(told_.empty());

    // A slice is missing.
    std::filesystem::remove(file("dicom/im" + std::to_string((4 * 5) % ball_.size.z)));
    openScan(file("dicom"), {}, messages_);
    ASSERT_EQ(told_.size(), 1u);
    EXPECT_NE(told_[0].find("missing"), std::string::npos) << told_[0];

    // Two series: one is to be chosen.
    dicomSlice(ball_, 0, "1.2.77").write(file("dicom/other"));
    const std::string text = messageOf<Error>([&] { openScan(file("dicom"), {}); });
    EXPECT_NE(text.find("2 DICOM series"), std::string::npos) << text;
    EXPECT_NE(text.find("1.2.77"), std::string::npos) << text;
    ScanReadOptions options;
    options.series = "1.2.77";
    EXPECT_EQ(openScan(file("dicom"), options)->header().size.z, 1);
}

// What is wrong is told with the path, and nothing crashes.
class BadScans : public ScanFiles {
protected:
    std::string refusal(const std::string& name, const ScanReadOptions& options = {}) {
        const std::string path = file(name);
        const std::string text = messageOf<Error>([&] {
            Progress progress;
            const auto reader = openScan(path, options, messages_);
            reader->read({{0, 0, 0}, reader->header().size}, progress);
        });
        EXPECT_EQ(text.find(path), 0u) << text;
        EXPECT_EQ(text.find(path, 1), std::string::npos) << text;
        EXPECT_EQ(text.find('\n'), std::string::npos) << text;
        std::printf("             %s\n", text.substr(path.size() - name.size()).c_str());
        return text;
    }
    void expectIn(const std::string& text, const std::string& part) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    }
};

TEST_F(BadScans, Missing) {
    refusal("none.nii");
    Bytes().text("hello").write(file("a.xyz"));
    expectIn(refusal("a.xyz"), "NIfTI");
    std::filesystem::create_directory(file("empty"));
    expectIn(refusal("empty"), "neither DICOM nor TIFF");
    Bytes().text("hello").write(file("a.raw"));
    expectIn(refusal("a.raw"), "--dims");
}

TEST_F(BadScans, TruncatedVoxels) {
    Bytes b;
    addValues<std::uint8_t>(b, ball_);
    b.write(file("a.raw"), 100);
    expectIn(refusal("a.raw", raw(ScanType::UInt8)), "ends at byte 1070");
    Bytes inr = inrFile(ball_);
    addValues<std::uint8_t>(inr, ball_);
    inr.write(file("a.inr"), 1);
    expectIn(refusal("a.inr"), "ends at byte 1425");
    const gzFile gz = ::gzopen(file("b.inr.gz").c_str(), "wb");
    ::gzwrite(gz, inr.data().data(), unsigned(inr.size() - 200));
    ::gzclose(gz);
    expectIn(refusal("b.inr.gz"), "ends at byte 1226, in layer 7 of 9");
    Bytes nrrd = nrrdFile(ball_);
    addValues<std::uint8_t>(nrrd, ball_);
    nrrd.write(file("a.nrrd"), 300);
    refusal("a.nrrd");
    Bytes meta = metaFile(ball_);
    addValues<std::uint8_t>(meta, ball_);
    meta.write(file("a.mha"), 300);
    refusal("a.mha");
    Bytes nifti = niftiFile(ball_);
    addValues<std::uint8_t>(nifti, ball_);
    nifti.write(file("a.nii"), 300);
    refusal("a.nii");
    tiffFile(ball_, 0, 9).write(file("a.tif"), 60);
    refusal("a.tif");
}

TEST_F(BadScans, TruncatedHeaders) {
    inrFile(ball_).write(file("a.inr"), 100);
    expectIn(refusal("a.inr"), "does not end with");
    niftiFile(ball_).write(file("a.nii"), 200);
    refusal("a.nii");
    nrrdFile(ball_).write(file("a.nrrd"), 60);
    refusal("a.nrrd");
    metaFile(ball_).write(file("a.mha"), 60);
    refusal("a.mha");
    Bytes().text("II").value<std::uint16_t>(42).value<std::uint32_t>(5000).write(file("a.tif"));
    refusal("a.tif");
    Bytes().pad(128).text("DICM").write(file("a.dcm"));
    refusal("a.dcm");
}

TEST_F(BadScans, InrFields) {
    Bytes().text("#INRIMAGE-4#{\nXDIM=4\nZDIM=4\n").pad(252, '\n').text("##}\n").write(file("a.inr"));
    expectIn(refusal("a.inr"), "no YDIM");
    Scan s = ball_;
    s.size.y = -3;
    inrFile(s).write(file("b.inr"));
    expectIn(refusal("b.inr"), "YDIM=-3");
    inrFile(ball_, "packed", 8).write(file("c.inr"));
    expectIn(refusal("c.inr"), "TYPE=packed");
    inrFile(ball_, "float", 32, "vax").write(file("d.inr"));
    expectIn(refusal("d.inr"), "CPU=vax");
    s = ball_;
    s.spacingMm.z = 0;
    Bytes e = inrFile(s);
    addValues<std::uint8_t>(e, ball_);
    e.write(file("e.inr"));
    expectIn(refusal("e.inr"), "distance of voxels");
    Bytes().text("not an image at all").pad(600).write(file("f.inr"));
    expectIn(refusal("f.inr"), "INRIMAGE");
}

TEST_F(BadScans, WrongByteOrder) {
    const Scan big = ballScan({32, 32, 8}, {1, 1, 1});
    ScanReadOptions options;
    options.raw = true;
    const auto check = [&](auto type, ScanType scanType) {
        for (const bool order : {false, true}) {
            Bytes b;
            addValues<decltype(type)>(b, big, order);
            b.write(file("a.raw"));
            options.layout = {big.size, scanType, !order, 0};
            expectIn(refusal("a.raw", options), order ? "--endian big" : "--endian little");
        }
    };
    check(std::int32_t(), ScanType::Int32);
    check(float(), ScanType::Float32);
    check(double(), ScanType::Float64);
    // Sixteen bits: values over more than one byte.
    Scan wide = big;
    CounterRng rng(1, 0);
    for (float& v : wide.values) {
        v = (v > 125 ? 2000.0f : 500.0f) + 60 * rng.uniform(); // noise as scanners have it
    }
    Bytes b;
    addValues<std::int16_t>(b, wide);
    b.write(file("a.raw"));
    options.layout = {big.size, ScanType::Int16, true, 0};
    expectIn(refusal("a.raw", options), "--endian little");
    Bytes inr = inrFile(wide, "signed fixed", 16, "sun");
    addValues<std::int16_t>(inr, wide);
    inr.write(file("a.inr"));
    expectIn(refusal("a.inr"), "little-endian");
    Bytes meta = metaFile(wide, "MET_SHORT", 1, true);
    addValues<std::int16_t>(meta, wide);
    meta.write(file("a.mha"));
    expectIn(refusal("a.mha"), "other byte order");
}

TEST_F(BadScans, MoreThanOneValue) {
    Scan three = ball_;
    three.values.insert(three.values.end(), ball_.values.begin(), ball_.values.end());
    three.values.insert(three.values.end(), ball_.values.begin(), ball_.values.end());
    tiffFile(ball_, 0, 2, 3).write(file("a.tif"));
    expectIn(refusal("a.tif"), "3 values per voxel");
    Bytes meta = metaFile(ball_, "MET_UCHAR", 3);
    addValues<std::uint8_t>(meta, three);
    meta.write(file("a.mha"));
    expectIn(refusal("a.mha"), "3 values per voxel");
    Bytes nifti = niftiFile(ball_, 2, 8, 3);
    addValues<std::uint8_t>(nifti, three);
    nifti.write(file("a.nii"));
    expectIn(refusal("a.nii"), "3 volumes");
}

TEST_F(BadScans, AbsurdSizes) {
    Scan s = ball_;
    s.size = {2000000000, 2000000000, 2000000000};
    inrFile(s).write(file("a.inr"));
    expectIn(refusal("a.inr"), "cannot be");
    nrrdFile(s).write(file("a.nrrd"));
    refusal("a.nrrd");
    metaFile(s).write(file("a.mha"));
    refusal("a.mha");
    ScanReadOptions options;
    options.raw = true;
    options.layout.size = {0, 4, 4};
    Bytes().pad(64).write(file("a.raw"));
    expectIn(refusal("a.raw", options), "cannot be");
}

TEST_F(BadScans, SlicesThatDiffer) {
    std::filesystem::create_directory(file("slices"));
    tiffFile(ball_, 0, 1).write(file("slices/a1.tif"));
    tiffFile(ballScan({5, 5, 1}, {1, 1, 1}), 0, 1).write(file("slices/a2.tif"));
    const std::string text = messageOf<Error>([&] {
        Progress progress;
        const auto reader = openScan(file("slices"), {});
        reader->read({{0, 0, 0}, reader->header().size}, progress);
    });
    expectIn(text, "a2.tif");
    expectIn(text, "5 x 5 x 1");
}

TEST_F(BadScans, LeftOverBytesAreTold) {
    Bytes b;
    addValues<std::uint8_t>(b, ball_);
    b.pad(b.size() + 5).write(file("a.raw"));
    openScan(file("a.raw"), raw(ScanType::UInt8), messages_);
    ASSERT_EQ(told_.size(), 1u);
    expectIn(told_[0], "5 bytes are left over");
}

TEST_F(BadScans, Cancel) {
    Bytes b;
    addValues<std::uint8_t>(b, ball_);
    b.write(file("a.raw"));
    Progress progress;
    progress.cancel();
    EXPECT_THROW(openScan(file("a.raw"), raw(ScanType::UInt8))->read({{0, 0, 0}, ball_.size}, progress), Cancelled);
}

} // namespace
