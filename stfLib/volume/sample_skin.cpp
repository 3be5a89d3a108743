// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/sample_parts.h"
#include "stfLib/volume/samples.h"

#include "stfLib/base/random.h"
#include "stfLib/optics/property_table.h"
#include "stfLib/volume/material_blend.h"

#include <cmath>

namespace stf {

namespace {

constexpr double kEpidermisMm = 0.09;
constexpr double kDermisMm = 1.3; // the fat begins below it

// A point in each cell of a square lattice over the tile, and how far a place is from the border between the two that
// are nearest (F2 - F1 of Worley 1996, "A Cellular Texture Basis Function"), in cells; periodic.
class CellBorders {
public:
    CellBorders(int cells, const Vec3d& extentMm, std::uint32_t seed) : cells_(cells), extent_(extentMm) {
        CounterRng rng(seed, 300 + std::uint64_t(cells));
        for (int i = 0; i < cells * cells; ++i) {
            const double x = 0.1 + 0.8 * double(rng.uniform());
            points_.push_back({x, 0.1 + 0.8 * double(rng.uniform())});
        }
    }

    double operator()(double xMm, double yMm) const {
        const double x = xMm / extent_.x * cells_, y = yMm / extent_.y * cells_;
        const int cx = int(std::floor(x)), cy = int(std::floor(y));
        double first = 1e30, second = 1e30;
        for (int j = cy - 2; j <= cy + 2; ++j) {
            for (int i = cx - 2; i <= cx + 2; ++i) {
                const Vec2d& p = points_[std::size_t(wrap(j) * cells_ + wrap(i))];
                const double d = std::hypot(i + p.x - x, j + p.y - y);
                second = std::min(second, std::max(first, d));
                first = std::min(first, d);
            }
        }
        return second - first;
    }

private:
    int wrap(int i) const { return ((i % cells_) + cells_) % cells_; }

    int cells_;
    Vec3d extent_;
    std::vector<Vec2d> points_;
};

// Depth of the skin's surface below the tile's top, mm.
class SkinRelief {
public:
    SkinRelief(const BaseVolume& v, std::uint32_t seed)
        : noise_(v, seed), coarse_(6, v.extentMm(), seed), fine_(14, v.extentMm(), seed + 1), extent_(v.extentMm()),
          height_(std::min(1.0, v.extentMm().z / 2.4)) {
        CounterRng rng(seed, 400);
        for (int i = 0; i < 9; ++i) {
            const double x = double(rng.uniform()) * extent_.x;
            pores_.push_back({{x, double(rng.uniform()) * extent_.y, 0}, 0.07 + 0.05 * double(rng.uniform())});
        }
    }

    double operator()(double x, double y) const {
        const Vec3d mm(x, y, 0);
        // Bent a little, or the cells would show their straight borders.
        const double bx = x + 0.16 * double(noise_(mm, 8, 1)), by = y + 0.16 * double(noise_(mm, 8, 2));
        const double primary = std::exp(-std::pow(coarse_(bx, by) / 0.13, 2));
        const double secondary = std::exp(-std::pow(fine_(bx, by) / 0.20, 2));
        const double soft = 0.5 - 0.5 * noise_.fractal(mm, 4, 2, 5);
        return height_ * (0.03 + 0.05 * soft + 0.13 * primary + 0.05 * secondary + 0.28 * pore(x, y));
    }
    /// 0 to 1 into a pore.
    double pore(double x, double y) const {
        const double inside = depthInBalls(pores_, Vec3d(x, y, 0), extent_);
        return smoothStep(-0.10, 0.07, inside);
    }

private:
    TileNoise noise_;
    CellBorders coarse_, fine_;
    Vec3d extent_;
    double height_;
    std::vector<Ball> pores_;
};

} // namespace

BaseVolume makeSkin(const SampleOptions& options) {
    BaseVolume v = blankSample("skin", options, {72, 72, 24}, 0.1);
    const PropertyTable& table = PropertyTable::builtIn();
    const std::vector<Material> materials{table.find("tissue/Epidermis"), table.find("tissue/Dermis"),
                                          table.find("tissue/Fat"), table.find("tissue/Blood")};
    const std::size_t kinds = materials.size();
    const Relief relief(v, SkinRelief(v, options.seed));
    const TileNoise noise(v, options.seed);
    const double h = v.voxelMm.z;
    // The share of a voxel above a depth at which one layer gives way to the next.
    const auto above = [h](double depth, double border) { return std::clamp((border - depth) / h + 0.5, 0.0, 1.0); };
    std::vector<float> fractions(v.voxelCount() * kinds, 0.0f);
    v.surface.resize(v.voxelCount());
    forEachVoxel(v, [&](std::size_t i, const Vec3d& mm) {
        v.surface[i] = float(relief.distance(i, mm.z));
        const double depth = mm.z - relief.depth(i); // below the skin's surface
        if (depth < -2 * h) {
            return;
        }
        // Papillae carry the dermis up into the epidermis; freckled pigment comes and goes with its thickness.
        const double thickness = kEpidermisMm * (1 + 0.45 * double(noise(mm, 8, 10)) + 0.35 * double(noise(mm, 2, 11)));
        const double epidermis = above(depth, thickness);
        const double fatBorder = kDermisMm + 0.22 * noise.fractal(Vec3d(mm.x, mm.y, 0), 4, 2, 12);
        const double dermis = above(depth, fatBorder) - epidermis;
        // Vessels: a fine plexus below the epidermis, and larger ones at the bottom of the dermis.
        const Vec3d bent = mm + Vec3d(noise(mm, 4, 20), noise(mm, 4, 21), noise(mm, 4, 22)) * 0.5;
        const double fine = std::abs(double(noise(bent, 8, 23))), large = std::abs(double(noise(bent, 4, 24)));
        const double upper = smoothStep(0.12, 0.2, depth) * smoothStep(0.55, 0.35, depth);
        const double lower = smoothStep(0.6, 0.9, depth) * smoothStep(1.6, 1.3, depth);
        const double blood =
            0.020 * std::exp(-std::pow(fine / 0.10, 2)) * upper + 0.10 * std::exp(-std::pow(large / 0.06, 2)) * lower;
        float* const f = fractions.data() + i * kinds;
        f[0] = float(epidermis);
        f[1] = float(dermis * (1 - blood));
        f[2] = float(std::max(0.0, 1 - epidermis - dermis));
        f[3] = float(dermis * blood);
    });
    blendMaterials(v, materials, fractions);
    v.coreSigmaA = materials[2].sigmaA;
    v.coreSigmaSPrime = materials[2].sigmaSPrime();
    return v;
}

} // namespace stf
