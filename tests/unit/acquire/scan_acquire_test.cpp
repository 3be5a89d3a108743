// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_acquire.h"

#include "stfLib/base/random.h"
#include "tests/unit/acquire/scan_files.h"
#include "tests/unit/support/files.h"

#include <cmath>
#include <limits>

using namespace stf;
using namespace stf::test;

namespace {

const char* const kClasses =
    R"("classify": {"method": "otsu", "materials": ["none",
        {"name": "bone", "sigma_a": [0.1, 0.2, 0.3], "sigma_s": [10, 11, 12], "g": 0.5, "ior": 1.4}]})";

class AcquireScan : public testing::Test {
protected:
    std::string file(const std::string& name) const { return folder_.file(name); }
    ScanRecipe recipe(const std::string& rest, const std::string& patch = "{}") const {
        return parseScanRecipe("{" + rest + "}", patch, "", folder_.path().string());
    }
    AcquiredScan acquire(const std::string& rest) {
        Progress progress;
        return acquireScan(recipe(rest), progress, [this](Severity, const std::string& t) { told_.push_back(t); });
    }
    std::string refusal(const std::string& rest) {
        const std::string text = messageOf<Error>([&] { acquire(rest); });
        EXPECT_EQ(text.find(file("a.raw")), 0u) << text;
        std::printf("             %s\n", text.substr(std::min(text.size(), file("").size())).c_str());
        return text;
    }
    // A noisy ball of 1000 in 100, partial volumes and all, in mm; returns its volume.
    double writeBall(const Vec3i& size, const Vec3d& h, double radius, double noise) {
        const Vec3d middle = Vec3d(size) * h * 0.5;
        CounterRng rng(2, 0);
        Bytes b;
        for (int z = 0; z < size.z; ++z) {
            for (int y = 0; y < size.y; ++y) {
                for (int x = 0; x < size.x; ++x) {
                    int inside = 0;
                    for (int k = 0; k < 64; ++k) {
                        const Vec3d p =
                            Vec3d(x + (k % 4 + 0.5) / 4, y + (k / 4 % 4 + 0.5) / 4, z + (k / 16 + 0.5) / 4) * h;
                        inside += length(p - middle) < radius ? 1 : 0;
                    }
                    const double random = 2 * double(rng.uniform() + rng.uniform() + rng.uniform() - 1.5f);
                    b.value<std::int16_t>(std::int16_t(std::lround(100 + 900 * inside / 64.0 + noise * random)));
                }
            }
        }
        b.write(file("a.raw"));
        return 4 * M_PI / 3 * radius * radius * radius;
    }
    std::string ballRecipe(const std::string& more = "") const {
        return R"("input": "a.raw", "raw": {"dims": [40, 36, 30], "type": "int16"}, "spacing": [0.5, 0.5, 0.6], )" +
               std::string(kClasses) + more;
    }
    double writeBall() { return writeBall({40, 36, 30}, {0.5, 0.5, 0.6}, 7, 30); }

    TemporaryFolder folder_;
    std::vector<std::string> told_;
};

// Sum of a coefficient over the volume, in 1/mm times mm^3.
double content(const BaseVolume& v, bool scattering) {
    double sum = 0;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        sum += double(v.extinction[i].y) * (scattering ? double(v.albedo[i].y) : 1 - double(v.albedo[i].y));
    }
    return sum * v.voxelMm.x * v.voxelMm.y * v.voxelMm.z;
}

TEST_F(AcquireScan, VolumeOfANoisyBall) {
    const double volume = writeBall();
    for (const char* more : {"", R"(, "voxel": 0.83)", R"(, "voxel": [0.25, 0.5, 0.3])", R"(, "depth": "-x")",
                             R"(, "tile": "blend", "overlap": 8)"}) {
        const AcquiredScan s = acquire(ballRecipe(more));
        EXPECT_NEAR(content(s.volume, true) / 11, volume, 0.005 * volume) << more;
        EXPECT_NEAR(content(s.volume, false) / 0.2, volume, 0.005 * volume) << more;
        EXPECT_NEAR(s.tileFractions[1], volume / (20 * 18 * 18), 0.005 * s.tileFractions[1]) << more;
        EXPECT_NEAR(s.tileFractions[0] + s.tileFractions[1], 1, 1e-9);
        EXPECT_NEAR(s.volume.coreSigmaSPrime.y, 5.5, 1e-6);
        EXPECT_NEAR(s.volume.coreSigmaA.z, 0.3, 1e-6);
        EXPECT_NO_THROW(validate(s.volume));
        EXPECT_TRUE(s.volume.surface.empty());
    }
    const AcquiredScan small = acquire(ballRecipe(R"(, "scale": 0.1, "voxel": 0.1)"));
    EXPECT_NEAR(content(small.volume, true) / 11, volume / 1000, 0.005 * volume / 1000);
    EXPECT_EQ(small.volume.size, Vec3i(20, 18, 18));
    EXPECT_EQ(acquire(ballRecipe(R"(, "depth": "-x")")).volume.size, Vec3i(36, 30, 40));
}

TEST_F(AcquireScan, Classes) {
    writeBall();
    for (const char* method : {"otsu", "gmm"}) {
        Progress progress;
        const auto s =
            acquireScan(recipe(ballRecipe(), std::string(R"({"classify": {"method": ")") + method + "\"}}"), progress);
        ASSERT_EQ(s.classes.size(), 2u);
        EXPECT_NEAR(s.classes[0].mean, 100, 15) << method;
        EXPECT_NEAR(s.classes[1].mean, 1000, 60) << method;
    }
    Progress progress;
    const auto t = acquireScan(
        recipe(ballRecipe(), R"({"classify": {"method": "thresholds", "thresholds": 550, "widths": 900}})"), progress);
    EXPECT_TRUE(t.classes.empty());
    ASSERT_EQ(t.transfer.size(), 2u);
    EXPECT_EQ(t.transfer[0].value, 100);
    const auto p = acquireScan(
        recipe(ballRecipe(), R"({"classify": {"method": "transfer", "points": [[100, 1, 0], [1000, 0, 1]]}})"),
        progress);
    EXPECT_NEAR(p.tileFractions[1], t.tileFractions[1], 1e-9);
}

TEST_F(AcquireScan, SurfaceOfABall) {
    const double volume = writeBall();
    const AcquiredScan s = acquire(ballRecipe(R"(, "iso": "auto")"));
    const BaseVolume& v = s.volume;
    ASSERT_FALSE(v.surface.empty());
    EXPECT_NEAR(*s.iso, 550, 30);
    // The top lies just above the ball: 2 mm of air are 3.3 layers, of which two go.
    EXPECT_EQ(s.firstLayer, 2);
    const Vec3d mm = v.extentMm();
    EXPECT_NEAR(s.insideShare * mm.x * mm.y * mm.z, volume, 0.005 * volume);
    // Sign and size at the middle, in a corner, beside the surface.
    const Vec3d middle(10, 9, 9 - 2 * 0.6);
    for (int z = 0; z < v.size.z; ++z) {
        for (int y = 0; y < v.size.y; ++y) {
            for (int x = 0; x < v.size.x; ++x) {
                const double exact = length(Vec3d(x + 0.5, y + 0.5, z + 0.5) * v.voxelMm - middle) - 7;
                const double found = double(v.surface[v.index(x, y, z)]);
                if (std::abs(exact) < 0.6) {
                    EXPECT_NEAR(found, exact, 0.08);
                } else {
                    EXPECT_EQ(found < 0, exact < 0);
                }
                // The surface alone says where material is: voxels that it cuts hold whole material.
                if (exact < 0) {
                    EXPECT_NEAR(v.extinction[v.index(x, y, z)].y, 11.2f, exact > -0.7 ? 1e-3f : 0.9f);
                }
            }
        }
    }
    // Dark material in bright surroundings, by a value.
    Progress progress;
    const auto dark = acquireScan(
        recipe(ballRecipe(), R"({"iso": 500, "classify": {"materials": [{"sigma_s": 3}, "none"]}})"), progress);
    EXPECT_GT(dark.volume.surface[dark.volume.index(20, 18, dark.volume.size.z / 2)], 0);
    EXPECT_LT(dark.volume.surface[dark.volume.index(1, 1, 1)], 0);
}

TEST_F(AcquireScan, CropAndTop) {
    writeBall();
    const AcquiredScan s = acquire(ballRecipe(R"(, "crop": "4:36,2:18mm,:", "top": 3)"));
    EXPECT_EQ(s.crop.lo, Vec3i(4, 4, 0));
    EXPECT_EQ(s.volume.size, Vec3i(32, 32, 25));
    EXPECT_EQ(s.firstLayer, 5);
    const AcquiredScan automatic = acquire(ballRecipe(R"(, "top": "auto")"));
    EXPECT_EQ(automatic.firstLayer, 3);
    EXPECT_NE(refusal(ballRecipe(R"(, "top": 30)")).find("30.0"), std::string::npos);
}

TEST_F(AcquireScan, QuiltReportsItsSides) {
    CounterRng rng(3, 0);
    Bytes b;
    for (int i = 0; i < 40 * 36 * 30; ++i) { // smooth random stripes that do not repeat
        b.value<std::int16_t>(
            std::int16_t(500 + 400 * std::sin(0.31 * (i % 40) + 0.37 * (i / 40 % 36) + 0.05 * (i / 1440))));
    }
    b.write(file("a.raw"));
    const AcquiredScan s = acquire(ballRecipe(R"(, "tile": "quilt", "overlap": [10, 9])"));
    EXPECT_EQ(s.volume.size, Vec3i(30, 27, 30));
    ASSERT_TRUE(s.cut);
    EXPECT_GT(s.before.x + s.before.y, 1.5 * (s.after.x + s.after.y));
    const AcquiredScan same = acquire(ballRecipe(R"(, "tile": "quilt", "overlap": [10, 9])"));
    EXPECT_EQ(s.volume.contentHash(), same.volume.contentHash());
}

TEST_F(AcquireScan, MemoryIsRefusedBeforeItIsTaken) {
    // A file of 8 GB that takes no place on the disk.
    std::ofstream(file("a.raw")).put(0);
    std::filesystem::resize_file(file("a.raw"), std::uintmax_t(2048) * 2048 * 1024 * 2);
    const std::string big =
        R"("input": "a.raw", "raw": {"dims": [2048, 2048, 1024], "type": "int16"}, "spacing": 0.1, )" +
        std::string(kClasses);
    const std::string text = refusal(big + R"(, "voxel": 1)");
    EXPECT_NE(text.find("2048 x 2048 x 1024"), std::string::npos);
    EXPECT_NE(text.find("GB"), std::string::npos);
    EXPECT_NE(text.find("--max-memory"), std::string::npos);
    EXPECT_NE(refusal(big).find("--voxel"), std::string::npos);
    // A part of it is read alone. All zero: refused for that, not for its size.
    EXPECT_NE(refusal(big + R"(, "crop": "0:64,0:64,900:964")").find("nothing to tell materials by"),
              std::string::npos);
}

TEST_F(AcquireScan, NotFinite) {
    Bytes b;
    for (int i = 0; i < 4 * 5 * 6; ++i) {
        b.value<float>(i == 33 || i == 70 ? std::numeric_limits<float>::quiet_NaN() : float(i % 3));
    }
    b.write(file("a.raw"));
    const std::string r =
        R"("input": "a.raw", "raw": {"dims": [4, 5, 6], "type": "float32"}, "spacing": 1, )" + std::string(kClasses);
    const std::string text = refusal(r);
    EXPECT_NE(text.find("2 voxels are not finite, the first at 1, 3, 1"), std::string::npos) << text;
    EXPECT_EQ(acquire(r + R"(, "nan": 0)").replaced, 2u);
}

TEST_F(AcquireScan, WhatCannotBe) {
    writeBall();
    EXPECT_NE(refusal(ballRecipe(R"(, "iso": 5000)")).find("none lies on either side"), std::string::npos);
    EXPECT_NE(refusal(ballRecipe(R"(, "tile": "quilt", "overlap": 30)")).find("overlap"), std::string::npos);
    EXPECT_NE(refusal(ballRecipe(R"(, "crop": "0:99,,")")).find("crop"), std::string::npos);
    Progress cancelled;
    cancelled.cancel();
    EXPECT_THROW(acquireScan(recipe(ballRecipe()), cancelled), Cancelled);
    told_.clear();
    acquire(R"("input": "a.raw", "raw": {"dims": [40, 36, 30], "type": "int16"}, )" + std::string(kClasses));
    ASSERT_EQ(told_.size(), 1u); // nobody said how far apart voxels are
    EXPECT_NE(told_[0].find("--spacing"), std::string::npos);
}

TEST_F(AcquireScan, RecipesThatAreWrong) {
    const auto text = [&](const std::string& rest, const std::string& patch = "{}") {
        return messageOf<Error>([&] { parseScanRecipe(rest, patch, "r.json", ""); });
    };
    const std::string good = R"({"input": "a", "classify": {"materials": ["none", "Marble"]}})";
    EXPECT_NO_THROW(parseScanRecipe(good, "{}", "r.json", ""));
    const std::vector<std::pair<std::string, std::string>> patches{
        {R"({"vox": 1})", "'vox'"},
        {R"({"voxel": -1})", "'voxel'"},
        {R"({"voxel": [1, 2]})", "'voxel'"},
        {R"({"scale": "big"})", "'scale'"},
        {R"({"tile": "mirror"})", "none, blend, quilt"},
        {R"({"iso": true})", "'iso'"},
        {R"({"input": null})", "'input'"},
        {R"({"overlap": 0.5})", "'overlap'"},
        {R"({"classify": null})", "'classify'"},
        {R"({"classify": {"materials": ["none", "Marbel"]}})", "Marble"},
        {R"({"classify": {"materials": ["Marble"]}})", "two materials"},
        {R"({"classify": {"materials": [{"sigma_q": 1}, "none"]}})", "'classify.materials[0]': no field 'sigma_q'"},
        {R"({"classify": {"materials": [{"g": 1}, "none"]}})", "'classify.materials[0]': g is 1"},
        {R"({"classify": {"thresholds": [1, 2]}})", "thresholds"},
        {R"({"classify": {"method": "transfer"}})", "points"},
        {R"({"classify": {"points": [[1, 0]]}})", "2 fractions"},
        {R"({"classify": {"gradient": [5, 2]}})", "'classify.gradient'"},
        {R"({"classify": {"method": "kmeans"}})", "gmm"},
        {R"({"raw": {"type": "uint8"}})", "raw.dims"},
        {R"({"raw": {"dims": [1, 2, 3], "type": "uint9"}})", "uint9"},
        {R"({"raw": {"dims": [1, 2, 3.5]}})", "raw.dims"},
    };
    for (const auto& [patch, word] : patches) {
        const std::string message = text(good, patch);
        EXPECT_EQ(message.find("r.json: "), 0u) << message;
        EXPECT_NE(message.find(word), std::string::npos) << patch << ": " << message;
    }
    EXPECT_NE(text("{\"input\": ").find("r.json"), std::string::npos);
    EXPECT_NE(text("[]").find("object"), std::string::npos);
}

} // namespace
