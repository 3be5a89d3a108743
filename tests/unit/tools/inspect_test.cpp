// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#include "tests/unit/support/files.h"
#include "tests/unit/volume/volumes.h"
#include "tools/stf/materials_sheet.h"
#include "tools/stf/sheet.h"
#include "tools/stf/volume_json.h"
#include "tools/stf/volume_sheet.h"
#include "tools/stf/volume_usd.h"

#include <cmath>
#include <gmock/gmock.h>
#include <limits>
#include <sstream>

using namespace stf;
using namespace stf::test;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

namespace {

std::vector<std::string> warningsOf(const BaseVolume& v) {
    return volumeWarnings(v, statisticsOf(v));
}

BaseVolume slab(double albedo, int layers) {
    BaseVolume v = homogeneous({4, 4, layers}, Vec3d(0.5), Rgb(2.0f), Rgb(float(albedo)));
    v.coreSigmaA = {0.1, 0.1, 0.1};
    v.coreSigmaSPrime = {1, 1, 1};
    return v;
}

TEST(Inspect, TellsWhereAShellIsThin) {
    // Diffusion length 1 / sqrt(3 0.02 2) = 2.9 mm.
    EXPECT_THAT(warningsOf(slab(0.99, 40)), IsEmpty()) << "20 mm deep";
    const BaseVolume thin = slab(0.99, 6);
    const std::vector<std::string> warnings = warningsOf(thin);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_THAT(warnings[0], AllOf(HasSubstr("thin"), HasSubstr("3 mm"), HasSubstr("1 diffusion lengths")));
    const VolumeStatistics s = statisticsOf(thin);
    char share[32];
    std::snprintf(share, sizeof share, "%.0f %%", 100 * s.reflectanceFromCore.x);
    EXPECT_THAT(warnings[0], HasSubstr(share));
    EXPECT_NEAR(s.reflectanceFromCore.x, 0.0585, 0.001)
        << "R = 0.7527 of deep media of albedo 0.99, exp(-2 T / l_d) = 0.125";
}

TEST(Inspect, TellsOfSeamsAndMissingCores) {
    BaseVolume v = slab(0.9, 40);
    v.size = {16, 4, 10};
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.extinction[i] = Rgb(10 + float(i % 16));
    }
    v.coreSigmaA = v.coreSigmaSPrime = {0, 0, 0};
    EXPECT_THAT(warningsOf(v), ElementsAre(HasSubstr("seam along x"), HasSubstr("no core")));
}

TEST(Inspect, JsonHoldsTheNumbers) {
    const BaseVolume v = makeSample("wax", {});
    const VolumeStatistics s = statisticsOf(v);
    const nlohmann::json j = nlohmann::json::parse(describeVolume(v, s).dump());
    EXPECT_EQ(j["size"][2], 32);
    EXPECT_EQ(j["hash"], v.contentHash());
    EXPECT_NEAR(j["surface"]["lowestMm"].get<double>(), 1.6, 0.05);
    EXPECT_NEAR(j["diffusionLengthMm"][0].get<double>(), 1 / std::sqrt(3 * 0.0035 * 2), 1e-4);
    EXPECT_NEAR(j["thicknessInDiffusionLengths"][1].get<double>(), s.thicknessMm / s.diffusionLengthMm.y, 1e-9);
    const BaseVolume white = homogeneous({2, 2, 2}, Vec3d(1.0), Rgb(1.0f), Rgb(1.0f));
    EXPECT_TRUE(describeVolume(white, statisticsOf(white))["diffusionLengthMm"][0].is_null()) << "infinite";
}

// The pixels of a PNG's header: width and height, big-endian from byte 16.
std::pair<int, int> sizeOfPng(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    unsigned char h[24] = {};
    in.read(reinterpret_cast<char*>(h), 24);
    EXPECT_EQ(std::string(reinterpret_cast<char*>(h) + 1, 3), "PNG");
    const auto at = [&](int i) { return h[i] << 24 | h[i + 1] << 16 | h[i + 2] << 8 | h[i + 3]; };
    return {at(16), at(20)};
}

TEST(Inspect, SheetsOfAnyVolume) {
    const TemporaryFolder folder;
    const std::string path = folder.file("sheet.png");
    int lastHeight = 0;
    for (const BaseVolume& v : {makeSample("wax", {}), homogeneous({1, 1, 1}, Vec3d(1.0), Rgb(0.0f), Rgb(0.0f)),
                                homogeneous({3, 90, 2}, {1, 0.1, 7}, Rgb(5.0f), Rgb(1.0f)), varied({9, 7, 5})}) {
        writeVolumeSheet(v, statisticsOf(v), path);
        const auto [width, height] = sizeOfPng(path);
        EXPECT_EQ(width, 1152);
        EXPECT_GT(height, 400);
        EXPECT_NE(height, lastHeight) << "as high as what is on it";
        lastHeight = height;
    }
    EXPECT_THROW(writeVolumeSheet(makeSample("wax", {}), {}, "/nowhere/at/all.png"), std::runtime_error);
}

TEST(Inspect, MaterialsSheet) {
    const TemporaryFolder folder;
    std::vector<MaterialRow> rows;
    const PropertyTable& table = PropertyTable::builtIn();
    for (std::size_t i = 0; i < 5; ++i) {
        rows.push_back(rowOf(table.qualifiedName(i), table.materials()[i]));
    }
    rows.push_back(rowOf("none", table.find("none")));
    EXPECT_EQ(rows[0].name, "jensen2001/Apple");
    EXPECT_NEAR(rows[0].albedo.x, 2.29 / 2.293, 1e-12);
    EXPECT_EQ(rows.back().albedo, Vec3d(0.0));
    const std::string few = folder.file("few.png"), one = folder.file("one.png");
    writeMaterialsSheet(rows, few);
    rows.resize(1);
    writeMaterialsSheet(rows, one);
    EXPECT_GT(sizeOfPng(few).second, sizeOfPng(one).second);
}

TEST(Sheet, Lengths) {
    EXPECT_EQ(lengthText(3.2), "3.2 mm");
    EXPECT_EQ(lengthText(0.045), "45 um");
    EXPECT_EQ(lengthText(0), "0 mm");
    EXPECT_EQ(lengthText(2500), "2.5 m");
    EXPECT_EQ(lengthText(std::numeric_limits<double>::infinity()), "infinite");
    EXPECT_EQ(roundLength(1), 1);
    EXPECT_EQ(roundLength(4.99), 2);
    EXPECT_EQ(roundLength(70), 50);
    EXPECT_NEAR(roundLength(0.0249), 0.02, 1e-15);
}

TEST(Inspect, UsdNamesEveryGrid) {
    const TemporaryFolder folder;
    const BaseVolume v = varied({4, 4, 4});
    writeBaseVolume(v, folder.file("v.vdb"));
    writeVolumeUsd(v, folder.file("v.vdb"), folder.file("v.usda"));
    std::ifstream in(folder.file("v.usda"));
    std::stringstream text;
    text << in.rdbuf();
    for (const char* grid : {"extinction", "albedo", "g", "ior", "surface", "emission"}) {
        EXPECT_THAT(text.str(), HasSubstr(std::string("rel field:") + grid + " = </Volume/" + grid + ">"));
        EXPECT_THAT(text.str(), HasSubstr(std::string("def OpenVDBAsset \"") + grid));
    }
    EXPECT_THAT(text.str(), HasSubstr("@./v.vdb@"));
    std::filesystem::create_directories(folder.path() / "scenes");
    writeVolumeUsd(homogeneous({2, 2, 2}, Vec3d(1.0), Rgb(1.0f), Rgb(1.0f)), folder.file("v.vdb"),
                   folder.file("scenes/v.usda"));
    std::ifstream other(folder.file("scenes/v.usda"));
    std::stringstream otherText;
    otherText << other.rdbuf();
    EXPECT_THAT(otherText.str(), HasSubstr("@" + folder.file("v.vdb") + "@"));
    EXPECT_THAT(otherText.str(), testing::Not(HasSubstr("surface")));
}

} // namespace
