// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/optics/h_function.h"
#include "stfLib/optics/phase.h"
#include "stfLib/volume/make_samples.h"
#include "tests/unit/support/files.h"
#include "tests/unit/volume/volumes.h"
#include "tools/stf/map_stf.h"
#include "tools/stf/map_walk.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <algorithm>

using namespace stf;
using namespace stf::test;

namespace {

constexpr double kPi = 3.14159265358979323846;

MapOptions parsed(std::vector<std::string> words) {
    CLI::App app;
    MapArguments arguments;
    arguments.addTo(app);
    words.insert(words.begin(), "volume.vdb");
    std::reverse(words.begin(), words.end()); // as CLI11 takes them
    app.parse(words);
    return arguments.parse();
}

MapResult walked(const BaseVolume& volume, const std::vector<std::string>& words) {
    Progress progress;
    return mapByWalks(volume, parsed(words), progress);
}
MapResult tabulated(const BaseVolume& volume, const std::vector<std::string>& words) {
    Progress progress;
    return mapByTable(volume, parsed(words), progress);
}

void expectMean(const MapResult& r, double expected, double systematic) {
    for (int c = 0; c < 3; ++c) {
        EXPECT_LE(r.mean.error[c], 0.01 * expected) << "too noisy to tell";
        EXPECT_LE(std::abs(r.mean.value[c] - expected), 4 * r.mean.error[c] + systematic * expected)
            << r.mean.value[c] << " +- " << r.mean.error[c] << ", expected " << expected;
    }
}

// Light from 37 degrees, view from 53 degrees, not in one plane.
const std::vector<std::string> kOblique{"--light", "0.6,0,0.8", "--view", "0,0.8,0.6"};
constexpr double kLight = 0.8, kView = 0.6;

std::vector<std::string> oblique(std::vector<std::string> words) {
    words.insert(words.end(), kOblique.begin(), kOblique.end());
    return words;
}

TEST(MapOptions, DirectionsAreOfUnitLength) {
    const MapOptions o = parsed({"--light", "3,0,4", "--photons", "1e5"});
    EXPECT_NEAR(o.towardsLight.x, 0.6, 1e-6);
    EXPECT_NEAR(o.towardsLight.z, 0.8, 1e-6);
    EXPECT_EQ(o.towardsViewer, Vec3f(0, 0, 1));
    EXPECT_EQ(o.photons, 100000u);
}

TEST(MapOptions, RefusesWhatIsNoMap) {
    const std::vector<std::pair<std::vector<std::string>, std::string>> bad{
        {{"--light", "0,0,-1"}, "--light"},
        {{"--light", "0,0,0"}, "--light"},
        {{"--view", "1,0,0"}, "--view"},
        {{"--view", "nan,0,1"}, "--view"},
        {{"--photons", "10"}, "--photons"},
        {{"--photons", "100.5"}, "--photons"},
        {{"--samples", "1"}, "--samples"},
        {{"--quality", "0"}, "--quality"},
        {{"--method", "magic"}, "magic"},
        {{"--form", "dE7"}, "--form"},
        {{"--threads", "-1"}, "--threads"},
        {{"--reflectance", "--method", "stf"}, "--reflectance"},
        {{"--reflectance", "--out", "a.exr"}, "--reflectance"},
    };
    for (const auto& [words, told] : bad) {
        const std::string message = messageOf<CLI::ParseError>([&, w = words] { parsed(w); });
        EXPECT_NE(message.find(told), std::string::npos) << "'" << message << "' does not name " << told;
    }
}

TEST(Map, RefusesReliefIndexAndEmission) {
    const BaseVolume flat = homogeneous({2, 2, 4}, {1, 1, 1}, Rgb(1.0f), Rgb(0.5f));
    BaseVolume relief = flat, glass = flat, lamp = flat;
    relief.surface.assign(relief.voxelCount(), -1);
    relief.surface[0] = 0.4f;
    glass.ior.assign(glass.voxelCount(), 1.5f);
    lamp.emission.assign(lamp.voxelCount(), Rgb(1.0f));
    for (const auto& [volume, told] :
         {std::pair(&relief, "relief"), std::pair(&glass, "index of refraction of 1.5"), std::pair(&lamp, "emits")}) {
        for (const char* method : {"walk", "stf"}) {
            const std::string message = messageOf<Error>(
                [&, v = volume] { std::string(method) == "walk" ? walked(*v, {}) : tabulated(*v, {}); });
            EXPECT_NE(message.find(told), std::string::npos) << message;
        }
    }
}

// Hardly any light is scattered twice: closed form.
TEST(Map, SingleScatteringLimit) {
    const double tau = 1, albedo = 1e-3;
    const float g = 0.5f;
    const BaseVolume v = homogeneous({3, 2, 20}, {2, 1, 0.05}, Rgb(1.0f), Rgb(float(albedo)), g);
    const double cosine = 0.8 * 0.6; // between the light's way and the viewer's, both from above: backwards
    const double phase = double(henyeyGreenstein(g, {-0.6f, 0, -0.8f}, {0, 0.8f, 0.6f}));
    EXPECT_NEAR(phase, (1 - 0.25) / (4 * kPi * std::pow(1.25 + cosine, 1.5)), 1e-6);
    const double expected =
        albedo * phase * kLight / (kLight + kView) * (1 - std::exp(-tau * (1 / kLight + 1 / kView)));
    expectMean(walked(v, oblique({"--photons", "200000"})), expected, albedo);
    expectMean(tabulated(v, oblique({"--samples", "2048", "--form", "classic", "--quality", "0.3"})), expected, albedo);
}

// Chandrasekhar's law of diffuse reflection of a half-infinite, isotropic medium.
TEST(Map, ThickSlabIsThatOfTheHFunction) {
    const double albedo = 0.9;
    const BaseVolume v = homogeneous({1, 1, 300}, {1, 1, 0.05}, Rgb(1.0f), Rgb(float(albedo)));
    const HFunction h(1 - albedo);
    const double expected = albedo / (4 * kPi) * h(kView) * h(kLight) * kLight / (kView + kLight);
    const MapResult walks = walked(v, oblique({"--photons", "100000"}));
    expectMean(walks, expected, 0);
    EXPECT_LE(std::abs(walks.reflectance.value.x - h.reflectance(kLight)), 4 * walks.reflectance.error.x);
    expectMean(tabulated(v, oblique({"--samples", "8192", "--quality", "0.005"})), expected, 0.01);
}

// One map by light that walks, one by tables and lines of sight: nothing is shared but the medium.
TEST(Map, MethodsAgreeOnAHeterogeneousTile) {
    SampleOptions options;
    options.size = {6, 5, 12};
    options.voxelMm = 0.5;
    options.ratio = 20;
    options.tau = 3;
    options.albedo = Rgb(0.95f, 0.8f, 0.5f);
    options.seed = 3;
    const BaseVolume v = makeSample("random", options);
    const MapResult a = walked(v, oblique({"--photons", "1000000"}));
    const MapResult b = tabulated(v, oblique({"--samples", "4096", "--quality", "0.01"}));
    ASSERT_EQ(a.columns.size(), 30u);
    ASSERT_EQ(b.columns.size(), 30u);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(b.mean.value[c], a.mean.value[c],
                    4 * std::hypot(a.mean.error[c], b.mean.error[c]) + 0.01 * a.mean.value[c]);
        double squares = 0, noise = 0, spread = 0;
        for (std::size_t i = 0; i < a.columns.size(); ++i) {
            squares += std::pow(b.columns[i].value[c] - a.columns[i].value[c], 2);
            noise += std::pow(a.columns[i].error[c], 2) + std::pow(b.columns[i].error[c], 2);
            spread += std::pow(a.columns[i].value[c] - a.mean.value[c], 2);
        }
        const double n = double(a.columns.size()), mean = a.mean.value[c];
        EXPECT_GT(std::sqrt(spread / n), 0.05 * mean) << "the tile is too even to tell columns apart";
        EXPECT_LT(std::sqrt(noise / n), 0.01 * mean);
        EXPECT_LT(std::sqrt(squares / n), 0.02 * mean) << "channel " << c;
    }
}

TEST(Map, ReflectanceAloneIsThatOfTheMap) {
    const BaseVolume v = homogeneous({2, 2, 8}, {1, 1, 0.25}, Rgb(1.0f), Rgb(0.9f));
    const MapResult map = walked(v, {"--photons", "64000"});
    const MapResult alone = walked(v, {"--photons", "64000", "--reflectance"});
    const double sigma = std::hypot(map.reflectance.error.x, alone.reflectance.error.x);
    EXPECT_LT(sigma, 0.01 * map.reflectance.value.x);
    EXPECT_NEAR(alone.reflectance.value.x, map.reflectance.value.x, 4 * sigma);
    EXPECT_TRUE(alone.columns.empty());
    EXPECT_FALSE(nlohmann::json::parse(mapJson(parsed({"--reflectance"}), alone)).contains("mean"));
}

TEST(Map, ThreadsDoNotMatter) {
    const BaseVolume v = homogeneous({2, 2, 4}, {1, 1, 0.5}, Rgb(1.0f), Rgb(0.9f));
    MapResult results[2];
    for (int threads : {1, 2}) {
        setThreadCount(threads);
        results[threads - 1] = walked(v, {"--photons", "6400"});
    }
    setThreadCount(0);
    EXPECT_EQ(results[0].mean.value, results[1].mean.value);
    EXPECT_EQ(results[0].columns[3].error, results[1].columns[3].error);
}

TEST(Map, ImageHoldsBothLayers) {
    const BaseVolume v = homogeneous({3, 2, 4}, {1, 1, 0.5}, Rgb(1.0f), Rgb(0.9f, 0.5f, 0.1f));
    const MapResult r = walked(v, {"--photons", "6400"});
    const test::TemporaryFolder folder;
    writeMap(r, folder.file("map.exr"));
    Imf::InputFile file(folder.file("map.exr").c_str());
    for (const char* name : {"radiance.R", "radiance.G", "radiance.B", "stderr.R", "stderr.G", "stderr.B"}) {
        ASSERT_NE(file.header().channels().findChannel(name), nullptr) << name;
        EXPECT_EQ(file.header().channels().findChannel(name)->type, Imf::FLOAT);
    }
    float green[6] = {}, error[6] = {};
    Imf::FrameBuffer frame;
    for (const auto& [name, to] : {std::pair("radiance.G", green), std::pair("stderr.B", error)}) {
        frame.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(to), sizeof(float), 3 * sizeof(float)));
    }
    file.setFrameBuffer(frame);
    file.readPixels(0, 1);
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_EQ(green[i], float(r.columns[i].value.y));
        EXPECT_EQ(error[i], float(r.columns[i].error.z));
    }
}

TEST(Map, CancelThrows) {
    const BaseVolume v = homogeneous({1, 1, 4}, {1, 1, 1}, Rgb(1.0f), Rgb(0.9f));
    Progress progress;
    progress.cancel();
    EXPECT_THROW(mapByWalks(v, parsed({}), progress), Cancelled);
    EXPECT_THROW(mapByTable(v, parsed({}), progress), Cancelled);
}

} // namespace
