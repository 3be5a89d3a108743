// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/make_samples.h"

#include "stfLib/base/random.h"

#include <cmath>

#define STB_PERLIN_IMPLEMENTATION
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stb_perlin.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;

// Gradient noise over the tile, periodic in x and y: `cells` lattice cells (a power of two) along the tile.
struct TileNoise {
    double tile; // mm
    std::uint32_t seed;
    float operator()(const Vec3d& mm, int cells, std::uint32_t salt) const {
        const double f = cells / tile;
        // The lattice repeats every `cells` in z too; an offset by the salt keeps octaves apart.
        return stb_perlin_noise3_seed(float(mm.x * f), float(mm.y * f), float(mm.z * f), cells, cells, 0,
                                      int((seed * 7919u + salt * 104729u) & 0xff));
    }
};

double smoothStep(double lo, double hi, double x) {
    const double t = std::clamp((x - lo) / (hi - lo), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

BaseVolume blank(const char* name, const SampleOptions& options, const Vec3i& size, double voxelMm) {
    BaseVolume v;
    v.name = name;
    v.size = options.size == Vec3i(0, 0, 0) ? size : options.size;
    v.voxelMm = Vec3d(options.voxelMm > 0 ? options.voxelMm : voxelMm);
    const double n = double(v.size.x) * double(v.size.y) * double(v.size.z);
    if (minComponent(v.size) < 1 || n > double(kMaxVoxels)) {
        throw Error("sample size is not usable (1 to " + std::to_string(kMaxVoxels) + " voxels)");
    }
    v.extinction.resize(v.voxelCount());
    v.albedo.resize(v.voxelCount());
    return v;
}

// Grey extinction, colour by absorption: walks then carry all channels at once, without spectral noise.
void setMedium(BaseVolume& v, std::size_t i, const Vec3d& sigmaA, double extinction, double coverage) {
    v.extinction[i] = Rgb(float(extinction * coverage));
    v.albedo[i] = Rgb(Vec3d(1.0) - sigmaA / extinction);
}

template<class F>
void forEachVoxel(const BaseVolume& v, F f) {
    for (int z = 0; z < v.size.z; ++z) {
        for (int y = 0; y < v.size.y; ++y) {
            for (int x = 0; x < v.size.x; ++x) {
                f(v.index(x, y, z), Vec3d((x + 0.5) * v.voxelMm.x, (y + 0.5) * v.voxelMm.y, (z + 0.5) * v.voxelMm.z));
            }
        }
    }
}

BaseVolume makeMarble(const SampleOptions& options) {
    BaseVolume v = blank("marble", options, {96, 96, 20}, 0.4);
    // Reduced albedo of marble (Jensen et al. 2001) at the extinction of its green channel, taken with g = 0.
    const double extinction = 2.624;
    const Vec3d sigmaA{0.0025, 0.0041, 0.0062};
    // Veins: iron-stained calcite, absorbing a hundred times as much; stains run out of them.
    const Vec3d veinA{0.34, 0.46, 0.60}, stainA{0.014, 0.036, 0.085};
    const TileNoise noise{v.extentMm().x, options.seed};
    forEachVoxel(v, [&](std::size_t i, const Vec3d& mm) {
        // Domain warping bends the veins; it is periodic since the noise is.
        const double w = 0.16 * noise.tile;
        const Vec3d p = mm + Vec3d(noise(mm, 2, 1), noise(mm, 2, 2), noise(mm, 2, 3)) * w +
                        Vec3d(noise(mm, 8, 4), noise(mm, 8, 5), noise(mm, 8, 6)) * (0.14 * w);
        const double broad = std::abs(noise(p, 2, 7) + 0.08 * noise(p, 16, 11));
        const double fine = std::abs(noise(p, 4, 8) + 0.20 * noise(p, 16, 9));
        const double strength = smoothStep(-0.35, 0.30, noise(mm, 4, 10));
        double vein = (0.25 + 0.75 * strength) * std::exp(-std::pow(broad / 0.030, 2));
        vein += 0.5 * smoothStep(0.1, 0.7, 1 - strength) * std::exp(-std::pow(fine / 0.022, 2));
        vein = std::min(1.0, vein);
        const double stain = smoothStep(0.28, 0.0, broad) * (0.25 + 0.75 * strength);
        setMedium(v, i, sigmaA + stainA * stain + veinA * vein, extinction, 1.0);
    });
    v.coreSigmaA = sigmaA + stainA * 0.25 + veinA * 0.02;
    v.coreSigmaSPrime = Vec3d(extinction) - v.coreSigmaA;
    return v;
}

// Height of the wax above the valleys, 0..1: a rosette on a lattice, unchanged by every symmetry of the square.
double waxHeight(double u, double w) {
    const double cu = std::cos(2 * kPi * u), cw = std::cos(2 * kPi * w);
    const double dome = smoothStep(-0.75, 1.25, cu + cw);
    const double ring = std::exp(-std::pow((cu + cw - 0.55) / 0.22, 2));
    const double stud = smoothStep(1.15, 1.8, -(cu + cw));
    return std::clamp((0.55 * dome + 0.30 * ring + 0.65 * stud) / 0.70, 0.0, 1.0); // its highest point is 0.70
}

BaseVolume makeWax(const SampleOptions& options) {
    BaseVolume v = blank("wax", options, {64, 64, 32}, 10.0 / 64);
    const double extinction = 2.0;
    const Vec3d sigmaA{0.0035, 0.017, 0.085};
    const Vec3d extent = v.extentMm();
    const double relief = std::min(1.6, 0.4 * extent.z);
    v.surface.resize(v.voxelCount());
    // Depth of the wax surface below the tile's top; the highest point touches the top.
    const auto depthAt = [&](double x, double y) { return relief * (1 - waxHeight(x / extent.x, y / extent.y)); };
    forEachVoxel(v, [&](std::size_t i, const Vec3d& mm) {
        const double e = 0.25 * v.voxelMm.x;
        const double sx = (depthAt(mm.x + e, mm.y) - depthAt(mm.x - e, mm.y)) / (2 * e);
        const double sy = (depthAt(mm.x, mm.y + e) - depthAt(mm.x, mm.y - e)) / (2 * e);
        // Distance to the tangent plane: exact for a plane, and positive outside.
        v.surface[i] = float((depthAt(mm.x, mm.y) - mm.z) / std::sqrt(1 + sx * sx + sy * sy));
        // Coefficients are those of the wax: the surface says where it is. Voxels that it may cut have them, too.
        setMedium(v, i, sigmaA, extinction, double(v.surface[i]) > v.voxelMm.x ? 0.0 : 1.0);
    });
    v.coreSigmaA = sigmaA;
    v.coreSigmaSPrime = Vec3d(extinction) - sigmaA;
    return v;
}

// A core like the volume's mean.
void setCore(BaseVolume& v, const Rgb& extinction, const SampleOptions& options) {
    const Vec3d kappa(extinction), albedo(options.albedo);
    v.coreSigmaA = kappa * (Vec3d(1.0) - albedo);
    v.coreSigmaSPrime = kappa * albedo * (1.0 - double(options.g));
}

BaseVolume makeUniform(const SampleOptions& options) {
    BaseVolume v = blank("uniform", options, {1, 1, 32}, 0.25);
    std::fill(v.extinction.begin(), v.extinction.end(), options.extinction);
    std::fill(v.albedo.begin(), v.albedo.end(), options.albedo);
    if (options.g != 0) {
        v.g.assign(v.voxelCount(), options.g);
    }
    setCore(v, options.extinction, options);
    return v;
}

BaseVolume makeRandom(const SampleOptions& options) {
    if (!(options.ratio >= 1 && options.ratio <= 1e12) || !(options.tau >= 0 && options.tau <= 1e6)) {
        throw Error("a random sample takes a ratio of 1 to 1e12 and a mean optical depth of 0 to 1e6");
    }
    BaseVolume v = blank("random", options, {64, 64, 32}, 1);
    CounterRng rng(options.seed, 0);
    double sum = 0;
    std::vector<double> kappa(v.voxelCount());
    for (double& k : kappa) {
        k = std::exp(double(rng.uniform()) * std::log(options.ratio));
        sum += k;
    }
    const double mean = options.tau / v.extentMm().z, scale = mean * double(v.voxelCount()) / sum;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.extinction[i] = Rgb(float(kappa[i] * scale));
    }
    std::fill(v.albedo.begin(), v.albedo.end(), options.albedo);
    if (options.g != 0) {
        v.g.assign(v.voxelCount(), options.g);
    }
    setCore(v, Rgb(float(mean)), options);
    return v;
}

} // namespace

const std::vector<SampleInfo>& sampleNames() {
    static const std::vector<SampleInfo> names{
        {"marble", "white marble with rust-coloured veins, 38 x 38 x 8 mm"},
        {"wax", "warm wax with a raised rosette pattern, 10 x 10 x 5 mm"},
        {"uniform", "homogeneous medium by --extinction, --albedo, --g"},
        {"random", "voxels of independent log-uniform extinction by --ratio, --tau, --albedo, --g"},
    };
    return names;
}

BaseVolume makeSample(const std::string& name, const SampleOptions& options) {
    BaseVolume v;
    if (name == "marble") {
        v = makeMarble(options);
    } else if (name == "wax") {
        v = makeWax(options);
    } else if (name == "uniform") {
        v = makeUniform(options);
    } else if (name == "random") {
        v = makeRandom(options);
    } else {
        std::string known;
        for (const SampleInfo& info : sampleNames()) {
            known += (known.empty() ? "" : ", ") + info.name;
        }
        throw Error("no sample named '" + name + "' (known: " + known + ")");
    }
    validate(v);
    return v;
}

} // namespace stf
