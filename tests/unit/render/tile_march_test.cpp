// SPDX-License-Identifier: Apache-2.0
// Straight pieces through tiles with tables made by hand: closed forms.
#include "stfLib/render/tile_march.h"

#include "stfLib/optics/fresnel.h"
#include "stfLib/optics/phase.h"
#include "tests/unit/support/statistics.h"

namespace stf::test {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kKappa = 2, kAlbedo = 0.8; // 1/mm

// One column of `layers` voxels, a tenth of a millimetre each.
BaseVolume column(int layers, double g = 0) {
    BaseVolume v;
    v.size = {1, 1, layers};
    v.voxelMm = Vec3d(0.1);
    v.extinction.assign(std::size_t(layers), Rgb(float(kKappa)));
    v.albedo.assign(std::size_t(layers), Rgb(float(kAlbedo)));
    v.g.assign(std::size_t(layers), float(g));
    return v;
}

// A field without light directions: fluence and flux of each layer by its number.
template<class Value>
FactoredField field(int layers, bool flux, Value value) {
    std::vector<float> values;
    for (int z = 0; z < layers; ++z) {
        const std::array<float, 4> at = value(z); // fluence, flux x, y, z
        for (int i = 0; i < (flux ? 4 : 1); ++i) {
            values.insert(values.end(), 3, at[std::size_t(i)]);
        }
    }
    return FactoredField::single(std::move(values), flux ? 12 : 3);
}

StfTable tableOf(const BaseVolume& v) {
    StfTable t;
    t.size = v.size;
    t.voxelMm = v.voxelMm;
    t.directions = DirectionSet(1, 1);
    return t;
}

const MarchLight kFromAbove{{0, 0, 1}, Rgb(0.0f), Rgb(1.0f)};
const Vec3f kToViewer = normalize(Vec3f(0.6f, 0, 0.8f));

Vec3f perMm(const BaseVolume& v, const Vec3f& towardsViewer) {
    return {-towardsViewer.x / float(v.voxelMm.x), -towardsViewer.y / float(v.voxelMm.y),
            towardsViewer.z / float(v.voxelMm.z)};
}

struct Marched {
    Estimate single, multiple, transmittance;
};

// Paths from the top to the bottom, in `pieces` segments.
Marched march(const BaseVolume& v, const StfTable& table, TransportForm form, const MarchLight& light,
              const Rgb& core = Rgb(0.0f), const Vec3f& viewer = kToViewer, int pieces = 3, int paths = 4096) {
    const TileMedium medium(v, form);
    TileMarch tile(medium, table);
    const float way = float(v.extentMm().z) / viewer.z;
    std::vector<double> single, multiple, transmittance;
    for (int i = 0; i < paths; ++i) {
        PixelSampler sampler(1, 2, std::uint32_t(i));
        tile.begin(sampler);
        for (int k = 0; k < pieces; ++k) {
            tile.setFrame(&light, 1, viewer);
            const float t = way * float(k) / float(pieces);
            if (!tile.segment(perMm(v, viewer) * t, perMm(v, viewer), way / float(pieces), core)) {
                break;
            }
        }
        const TileRadiance r = tile.finish();
        single.push_back(double(r.single.y));
        multiple.push_back(double(r.multiple.y));
        transmittance.push_back(double(tile.transmittance().y));
    }
    return {estimate(single), estimate(multiple), estimate(transmittance)};
}

std::array<float, 4> one(int) {
    return {1, 0, 0, 0};
}

TEST(TileMarch, ConstantFluence) {
    const BaseVolume v = column(20);
    StfTable t = tableOf(v);
    t.multiple = field(20, false, one);
    const Marched m = march(v, t, TransportForm::DE1, kFromAbove);
    const double seen = 1 - std::exp(-kKappa * 2 / 0.8);
    EXPECT_TRUE(agrees(m.multiple, kAlbedo / (4 * kPi) * seen, 0.002, 1e-6));
    EXPECT_TRUE(agrees(m.transmittance, 1 - seen, 0.05));
    EXPECT_EQ(m.single.mean, 0);
}

// Unbiased however long the way is.
TEST(TileMarch, RouletteKeepsTheMean) {
    const BaseVolume v = column(30);
    StfTable t = tableOf(v);
    t.multiple = field(30, false, one);
    const Marched m = march(v, t, TransportForm::DE1, kFromAbove, Rgb(0.0f), {0, 0, 1}, 3, 16384);
    EXPECT_TRUE(agrees(m.transmittance, std::exp(-kKappa * 3), 0.05));
    EXPECT_TRUE(agrees(m.multiple, kAlbedo / (4 * kPi) * (1 - std::exp(-kKappa * 3)), 0.001, 1e-6));
}

// Voxels hold means of a field that is linear in depth; what is read is that field, first and last layer included, and
// wherever the way is cut.
TEST(TileMarch, LinearFieldIsExact) {
    const BaseVolume v = column(10);
    for (const bool falling : {false, true}) {
        StfTable t = tableOf(v);
        const auto mean = [&](int z) { return falling ? 11.0f - float(z) - 0.5f : 1.0f + float(z) + 0.5f; };
        t.multiple = field(10, false, [&](int z) { return std::array<float, 4>{mean(z), 0, 0, 0}; });
        // INT (a + b z) k exp(-k z / mu) / mu dz over 1 mm, z in mm, ten layers.
        const double k = kKappa / 0.8, a = falling ? 11 : 1, b = falling ? -10 : 10, e = std::exp(-k);
        const double exact = kAlbedo / (4 * kPi) * (a * (1 - e) + b * (1 / k - e * (1 + 1 / k)));
        for (const int pieces : {1, 3, 7}) {
            EXPECT_TRUE(agrees(march(v, t, TransportForm::DE1, kFromAbove, Rgb(0.0f), kToViewer, pieces).multiple,
                               exact, 0.01, 1e-4 * exact))
                << pieces << " pieces";
        }
    }
}

// A voxel says nothing about its inside where it is thick: no extrapolation below zero or far above its mean.
TEST(TileMarch, ThickVoxelsAreNotExtrapolated) {
    BaseVolume v = column(2);
    v.voxelMm = Vec3d(2.0);
    StfTable t = tableOf(v);
    t.multiple = field(2, false, [](int z) { return std::array<float, 4>{z ? 100.0f : 1.0f, 0, 0, 0}; });
    const Marched m = march(v, t, TransportForm::DE1, kFromAbove, Rgb(0.0f), {0, 0, 1}, 1);
    const double e = std::exp(-4.0);
    EXPECT_TRUE(agrees(m.multiple, kAlbedo / (4 * kPi) * (1 - e + 100 * e * (1 - e)), 0.01, 1e-6));
}

// kappa' a' (I + 3 g' F.w) / 4 pi, negative values and all.
TEST(TileMarch, FluxOfLinearPhaseFunction) {
    const double g = 0.75, f = g * g, gPrime = g / (1 + g);
    const BaseVolume v = column(20, g);
    StfTable t = tableOf(v);
    const Vec3f flux(0.3f, 0.1f, -0.8f);
    const auto value = [&](int) { return std::array<float, 4>{1, flux.x, flux.y, flux.z}; };
    t.multiple = field(20, true, value);
    const double kappa = kKappa * (1 - kAlbedo * f), scattering = kKappa * kAlbedo * (1 - f);
    const double seen = (1 - std::exp(-kappa * 2 / 0.8)) / kappa;
    // The only light direction is the pole of one azimuth: its radial axis is the tile's x.
    const double source = 1 + 3 * gPrime * double(dot(flux, kToViewer));
    EXPECT_LT(source, 1);
    EXPECT_TRUE(agrees(march(v, t, TransportForm::DE1, kFromAbove).multiple, scattering / (4 * kPi) * source * seen,
                       0.002, 1e-6));

    // The published form has neither.
    t.form = TransportForm::Classic;
    t.multiple = field(20, false, one);
    EXPECT_TRUE(agrees(march(v, t, TransportForm::Classic, kFromAbove).multiple,
                       kAlbedo / (4 * kPi) * (1 - std::exp(-kKappa * 2 / 0.8)), 0.002, 1e-6));
}

TEST(TileMarch, CoreAndEmission) {
    BaseVolume v = column(20);
    StfTable t = tableOf(v);
    t.backlight = field(20, false, one);
    const MarchLight none{{0, 0, 1}, Rgb(0.0f), Rgb(0.0f)};
    const double seen = 1 - std::exp(-kKappa * 2 / 0.8);
    EXPECT_TRUE(
        agrees(march(v, t, TransportForm::DE1, none, Rgb(3.0f)).multiple, 3 * kAlbedo / (4 * kPi) * seen, 0.002, 1e-6));
    EXPECT_EQ(march(v, t, TransportForm::DE1, none).multiple.mean, 0) << "a black core";

    v.emission.assign(20, Rgb(0.5f));
    t.emitted = field(20, false, [](int) { return std::array<float, 4>{2, 0, 0, 0}; });
    EXPECT_TRUE(agrees(march(v, t, TransportForm::DE1, none).multiple, (0.5 / kKappa + 2 * kAlbedo / (4 * kPi)) * seen,
                       0.002, 1e-6));
    // Where there is nothing else, all of it arrives.
    v.extinction.assign(20, Rgb(0.0f));
    EXPECT_TRUE(agrees(march(v, t, TransportForm::DE1, none).multiple, 0.5 * 2 / 0.8, 0.002, 1e-5));
}

// A damaged or missing part is asked for only where it is needed.
TEST(TileMarch, ReadsWhatItNeeds) {
    const BaseVolume v = column(20);
    StfTable t = tableOf(v);
    t.multiple = field(20, false, one);
    int reads = 0;
    t.backlight = Lazy<FactoredField>(std::function<FactoredField()>([&] {
        ++reads;
        return field(20, false, one);
    }));
    march(v, t, TransportForm::DE1, kFromAbove);
    EXPECT_EQ(reads, 0);
    march(v, t, TransportForm::DE1, kFromAbove, Rgb(1.0f));
    EXPECT_EQ(reads, 1);
}

// The exact phase function and the light's own way through the tile, refracted by its top. In dE1 the way is that of
// the scaled medium, scattering is not scaled.
TEST(TileMarch, SingleScattering) {
    for (const double ior : {1.0, 1.5}) {
        for (const double g : {-0.5, 0.0, 0.75}) {
            BaseVolume v = column(20, g);
            v.ior.assign(20, float(ior));
            const MarchLight light{normalize(Vec3f(0.3f, -0.5f, 0.7f)), Rgb(1.0f), Rgb(0.0f)};
            const FresnelSplit split = fresnel(light.towards.z, float(ior));
            const Vec3f inside = -refract(-light.towards, {0, 0, 1}, float(ior), split);
            const double f = g > 0 ? g * g : 0, kappa = kKappa * (1 - kAlbedo * f);
            const double muO = 0.8, muI = double(inside.z);
            const double phase = double(henyeyGreenstein(float(g), -inside, kToViewer));
            const double exact = kKappa * kAlbedo / kappa * phase * double(1 - split.reflectance) *
                                 double(light.towards.z) / muI * muI / (muO + muI) *
                                 (1 - std::exp(-kappa * 2 * (1 / muO + 1 / muI)));
            const Marched m = march(v, tableOf(v), TransportForm::DE1, light);
            EXPECT_TRUE(agrees(m.single, exact, 0.02)) << "index " << ior << ", g " << g;
            EXPECT_EQ(m.multiple.mean, 0);
        }
    }
}

// Under refracting reliefs I_s is stored with its flux: the phase function around the mean direction, as wide as the
// directions are.
TEST(TileMarch, StoredSingleScattering) {
    const float g = 0.6f;
    const BaseVolume v = column(20, g);
    const MarchLight light{{0, 0, 1}, Rgb(2.0f), Rgb(0.0f)};
    const Vec3f direction = normalize(Vec3f(0.3f, 0.2f, -0.9f));
    for (const float concentration : {1.0f, 0.7f, 0.0f, 1.2f}) { // above 1: noise
        StfTable t = tableOf(v);
        const Vec3f flux = direction * concentration;
        t.single = field(20, true, [&](int) { return std::array<float, 4>{1, flux.x, flux.y, flux.z}; });
        const double kappa = kKappa * (1 - kAlbedo * double(g) * double(g));
        const double phase = double(henyeyGreenstein(g * std::min(1.0f, concentration), direction, kToViewer));
        const Marched m = march(v, t, TransportForm::DE1, light);
        EXPECT_TRUE(
            agrees(m.single, 2 * kKappa * kAlbedo * phase * (1 - std::exp(-kappa * 2 / 0.8)) / kappa, 0.002, 1e-5))
            << concentration;
    }
}

// Without a shift each path sees the columns as they are; with one, so much of a voxel's width of them.
TEST(TileMarch, LateralShift) {
    BaseVolume v = column(20);
    v.size = {2, 1, 20};
    v.extinction.clear();
    for (int i = 0; i < 40; ++i) {
        v.extinction.push_back(Rgb(i % 2 ? 2.0f : 0.0f));
    }
    v.albedo.assign(40, Rgb(0.0f));
    v.g.clear();
    const TileMedium medium(v, TransportForm::DE1);
    const StfTable table = tableOf(v);
    TileMarch tile(medium, table);
    for (const float shift : {0.0f, 0.5f, 1.0f}) {
        for (const float x : {0.5f, 1.5f, 1.9f}) {
            double mean = 0;
            constexpr int kPaths = 1024;
            for (int i = 0; i < kPaths; ++i) {
                PixelSampler sampler(3, 4, std::uint32_t(i));
                tile.begin(sampler, {shift, shift});
                tile.setFrame(nullptr, 0, {0, 0, 1});
                tile.segment({x, 0.5f, 0}, {0, 0, 10}, 0.5f);
                mean += double(tile.transmittance().x) / kPaths;
            }
            // At 1.9 the next column begins after .1: of a shift of s, (s / 2 - .1) / s lies there.
            const double beyond = x == 1.9f && shift > 0 ? 0.5 - 0.1 / double(shift) : 0.0;
            const double share = x < 1 ? 1.0 : std::max(0.0, beyond);
            EXPECT_NEAR(mean, share + (1 - share) * std::exp(-1.0), 0.005) << x;
        }
    }
}

TEST(TileMarch, ShiftFillsPixelsUpToAVoxel) {
    const Vec3d voxel(0.5, 0.25, 1);
    EXPECT_EQ(TileMarch::shiftFor(0, voxel).x, 1);
    EXPECT_EQ(TileMarch::shiftFor(0.25f, voxel).x, 0.5f);
    EXPECT_EQ(TileMarch::shiftFor(0.25f, voxel).y, 0);
    EXPECT_EQ(TileMarch::shiftFor(7, voxel).x, 0);
}

// The step that single scattering is taken from may lie frames back: it keeps the frame it was taken in.
TEST(TileMarch, ChosenStepKeepsItsFrame) {
    const BaseVolume v = column(10);
    const TileMedium medium(v, TransportForm::DE1);
    const StfTable table = tableOf(v);
    TileMarch tile(medium, table);
    std::vector<double> single;
    for (int i = 0; i < 65536; ++i) {
        PixelSampler sampler(5, 6, std::uint32_t(i));
        tile.begin(sampler);
        for (int k = 0; k < 2; ++k) {
            // The light shines through the first half only: in the second frame it stands below the horizon.
            const MarchLight light{k ? Vec3f(0, 0, -1) : Vec3f(0, 0, 1), Rgb(1.0f), Rgb(0.0f)};
            tile.setFrame(&light, 1, {0, 0, 1});
            tile.segment({0, 0, 5.0f * float(k)}, {0, 0, 10}, 0.5f);
        }
        single.push_back(double(tile.finish().single.y));
    }
    EXPECT_TRUE(agrees(estimate(single), kAlbedo / (4 * kPi) * 0.5 * (1 - std::exp(-2 * kKappa * 0.5)), 0.02));
}

} // namespace
} // namespace stf::test
