// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/volume_sheet.h"

#include "stfLib/optics/semi_infinite.h"
#include "tools/stf/sheet.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace stf {

namespace {

constexpr double kMargin = 24, kGap = 44, kSide = 232;
const Rgb kVoid(0.05f, 0.06f, 0.08f);

std::string format(const char* pattern, double a, double b = 0, double c = 0) {
    char text[128];
    std::snprintf(text, sizeof text, pattern, a, b, c);
    return text;
}

// Diffuse reflectance of matched media by the root of their absorption share, along which it is nearly straight.
class ReflectanceTable {
public:
    ReflectanceTable() {
        for (std::size_t i = 0; i < values_.size(); ++i) {
            const double root = double(i) / double(values_.size() - 1);
            values_[i] = float(semiInfiniteReflectance(root * root, 1));
        }
    }
    float operator()(double absorption) const {
        const double at = std::sqrt(std::clamp(absorption, 0.0, 1.0)) * double(values_.size() - 1);
        const std::size_t i = std::min(std::size_t(at), values_.size() - 2);
        const float t = float(at - double(i));
        return values_[i] + (values_[i + 1] - values_[i]) * t;
    }

private:
    std::array<float, 129> values_{};
};

class Painter {
public:
    Painter(const BaseVolume& volume, const VolumeStatistics& statistics)
        : v_(volume), s_(statistics), mm_(volume.extentMm()), lowest_(maxComponent(statistics.extinctionMax)),
          sheet_(int(2 * kMargin + 4 * (kSide + kGap)), 10) {
        for (const Rgb& k : v_.extinction) {
            for (int c = 0; c < 3; ++c) {
                lowest_ = k[c] > 0 ? std::min(lowest_, double(k[c])) : lowest_;
            }
        }
        lowest_ = std::max(lowest_, 1e-9);
    }

    void write(const std::string& path);

private:
    Rgb colorOf(int x, int y, int z) const {
        const std::size_t i = v_.index(x, y, z);
        const bool outside = v_.surface.empty() ? maxComponent(v_.extinction[i]) == 0 : v_.surface[i] > 0;
        if (outside) {
            return kVoid;
        }
        const float g = v_.g.empty() ? 0.0f : v_.g[i];
        Rgb result;
        for (int c = 0; c < 3; ++c) {
            const double a = double(v_.albedo[i][c]), scattering = a * (1 - double(g));
            const double total = scattering + (1 - a);
            result[c] = total > 0 ? reflectance_((1 - a) / total) : 0.0f;
        }
        return result;
    }
    Rgb seenFromAbove(int x, int y) const {
        for (int z = 0; z < v_.size.z; ++z) {
            const Rgb c = colorOf(x, y, z);
            if (c != kVoid) {
                return c;
            }
        }
        return kVoid;
    }
    Rgb extinctionGrey(int x, int y, int z) const {
        const double low = lowest_, high = maxComponent(s_.extinctionMax);
        const double k = double(luminance(v_.extinction[v_.index(x, y, z)]));
        if (!(k > 0)) {
            return kVoid;
        }
        return Rgb(float(high > low * 1.01 ? 0.03 + 0.9 * std::log(k / low) / std::log(high / low) : 0.5));
    }

    // Height of a picture of a plane of w x h mm at the full width of a column.
    static double heightFor(double w, double h) { return kSide * h / w; }
    void panel(double x, double y, double width, double height, const std::string& title, int columns, int rows,
               const std::function<Rgb(int, int)>& value, double widthMm, double heightMm, const char* across,
               const char* down);
    double heading();
    double overview(double y);
    double slices(double y);
    double relief(double y);
    double histograms(double y);

    const BaseVolume& v_;
    const VolumeStatistics& s_;
    const Vec3d mm_;
    double lowest_; ///< extinction above 0, 1/mm
    const ReflectanceTable reflectance_;
    Sheet sheet_;
};

// Where the n-th picture of a row begins.
double column(int n) {
    return kMargin + n * (kSide + kGap) + 18;
}

void Painter::panel(double x, double y, double width, double height, const std::string& title, int columns, int rows,
                    const std::function<Rgb(int, int)>& value, double widthMm, double heightMm, const char* across,
                    const char* down) {
    sheet_.text(x, y - 6, title, 12, Sheet::Align::Left, true);
    sheet_.picture(x, y, width, height, columns, rows, value);
    sheet_.frame(x, y, width, height);
    sheet_.text(x, y + height + 13, "0", 10);
    sheet_.text(x + width / 2, y + height + 13, across, 10, Sheet::Align::Middle);
    sheet_.text(x + width, y + height + 13, lengthText(widthMm), 10, Sheet::Align::Right);
    sheet_.text(x - 5, y + 9, "0", 10, Sheet::Align::Right);
    if (height > 40) {
        sheet_.text(x - 5, y + height / 2 + 4, down, 10, Sheet::Align::Right);
    }
    sheet_.text(x + width + 3, y + height, height > 14 ? lengthText(heightMm) : "", 9);
}

double Painter::heading() {
    sheet_.text(kMargin, 34, v_.name.empty() ? "base volume" : v_.name, 20, Sheet::Align::Left, true);
    const auto rgb = [](const char* name, const char* unit, const Vec3d& c) {
        return name + format("  %.3g  %.3g  %.3g", c.x, c.y, c.z) + unit;
    };
    const std::string lines[2][5] = {
        {format("%.0f x %.0f x %.0f voxels", v_.size.x, v_.size.y, v_.size.z) + ", " + lengthText(mm_.x) + " x " +
             lengthText(mm_.y) + " x " + lengthText(mm_.z) + " deep",
         rgb("extinction to", " /mm", s_.extinctionMax), rgb("albedo, mean", "", s_.albedoMean),
         rgb("optical depth, mean", "", s_.opticalDepthMean),
         format("g %.3g to %.3g", s_.gMin, s_.gMax) + format(",  ior %.3g to %.3g", s_.iorMin, s_.iorMax)},
        {"diffusion length  " + lengthText(s_.diffusionLengthMm.x) + " / " + lengthText(s_.diffusionLengthMm.y) +
             " / " + lengthText(s_.diffusionLengthMm.z),
         format("reflectance that the core gives  %.2g / %.2g / %.2g %%", 100 * s_.reflectanceFromCore.x,
                100 * s_.reflectanceFromCore.y, 100 * s_.reflectanceFromCore.z),
         format("periodicity error  %.2f along x, %.2f along y", s_.periodicity[0], s_.periodicity[1]),
         format("filled  %.1f %%", 100 * s_.filledShare), format("memory  %.1f MB", double(s_.bytes) / 1e6)}};
    for (int i = 0; i < 2; ++i) {
        for (int k = 0; k < 5; ++k) {
            sheet_.text(kMargin + i * 2 * (kSide + kGap), 58 + 17 * k, lines[i][k]);
        }
    }
    return 158;
}

double Painter::overview(double y) {
    const double height = heightFor(mm_.x, mm_.y);
    // Twice as wide as the others: seams show where tiles meet.
    panel(
        column(0), y, 2 * kSide + kGap, (2 * kSide + kGap) * mm_.y / mm_.x, "Four tiles from above", 2 * v_.size.x,
        2 * v_.size.y, [&](int i, int j) { return seenFromAbove(i % v_.size.x, j % v_.size.y); }, 2 * mm_.x, 2 * mm_.y,
        "x", "y");
    const double below = y + height + kGap;
    for (int k = 0; k < 4; ++k) {
        const int z = std::min(v_.size.z - 1, (2 * k + 1) * v_.size.z / 8);
        panel(
            column(2 + k % 2), k < 2 ? y : below, kSide, height, "Depth " + lengthText((z + 0.5) * v_.voxelMm.z),
            v_.size.x, v_.size.y, [&](int i, int j) { return colorOf(i, j, z); }, mm_.x, mm_.y, "x", "y");
    }
    const double bottom = std::max(y + (2 * kSide + kGap) * mm_.y / mm_.x, below + height);
    sheet_.scaleBar(column(0), bottom + 24, kSide, 2 * mm_.x / (2 * kSide + kGap));
    return bottom + 24 + kGap;
}

double Painter::slices(double y) {
    const double alongX = heightFor(mm_.x, mm_.z), alongY = heightFor(mm_.y, mm_.z);
    const int midX = v_.size.x / 2, midY = v_.size.y / 2;
    panel(
        column(0), y, kSide, alongX, "Slice at y = " + lengthText((midY + 0.5) * v_.voxelMm.y), v_.size.x, v_.size.z,
        [&](int i, int j) { return colorOf(i, midY, j); }, mm_.x, mm_.z, "x", "z");
    panel(
        column(1), y, kSide, alongY, "Slice at x = " + lengthText((midX + 0.5) * v_.voxelMm.x), v_.size.y, v_.size.z,
        [&](int i, int j) { return colorOf(midX, i, j); }, mm_.y, mm_.z, "y", "z");
    panel(
        column(2), y, kSide, alongX, "Extinction (log) of the first", v_.size.x, v_.size.z,
        [&](int i, int j) { return extinctionGrey(i, midY, j); }, mm_.x, mm_.z, "x", "z");
    panel(
        column(3), y, kSide, alongY, "Extinction (log) of the second", v_.size.y, v_.size.z,
        [&](int i, int j) { return extinctionGrey(midX, i, j); }, mm_.y, mm_.z, "y", "z");
    return y + std::max(alongX, alongY) + 24 + kGap;
}

double Painter::relief(double y) {
    if (!s_.surface) {
        return y;
    }
    const std::vector<float> depths = surfaceDepths(v_);
    const auto at = [&](int x, int z) {
        const int i = (x + v_.size.x) % v_.size.x, j = (z + v_.size.y) % v_.size.y;
        return depths[std::size_t(i) + std::size_t(v_.size.x) * std::size_t(j)];
    };
    const double range = std::max(1e-9, s_.surface->lowestMm - s_.surface->highestMm);
    const double height = heightFor(mm_.x, mm_.y);
    panel(
        column(0), y, kSide, height,
        "Height, " + lengthText(s_.surface->highestMm) + " to " + lengthText(s_.surface->lowestMm) + " deep", v_.size.x,
        v_.size.y,
        [&](int i, int j) {
            const double d = double(at(i, j));
            return d < 0 ? kVoid : Rgb(float(0.02 + 0.93 * (s_.surface->lowestMm - d) / range));
        },
        mm_.x, mm_.y, "x", "y");
    panel(
        column(1), y, kSide, height, "Normals", v_.size.x, v_.size.y,
        [&](int i, int j) {
            if (at(i, j) < 0) {
                return kVoid;
            }
            const Vec3d slope((double(at(i + 1, j)) - double(at(i - 1, j))) / (2 * v_.voxelMm.x),
                              (double(at(i, j + 1)) - double(at(i, j - 1))) / (2 * v_.voxelMm.y), 1);
            // As normal maps are: 0.5 + 0.5 n, in the encoded values.
            const Vec3d encoded = (normalize(slope) + Vec3d(1.0)) * 0.5;
            return Rgb(float(std::pow(encoded.x, 2.2)), float(std::pow(encoded.y, 2.2)),
                       float(std::pow(encoded.z, 2.2)));
        },
        mm_.x, mm_.y, "x", "y");
    const SurfaceStatistics& s = *s_.surface;
    const double x = column(2);
    sheet_.text(x, y + 14, "Surface", 12, Sheet::Align::Left, true);
    const std::string lines[] = {"mean depth  " + lengthText(s.meanMm), "rms height  " + lengthText(s.rmsMm),
                                 format("steepest  %.0f degrees", s.steepest),
                                 format("columns without material  %.1f %%", 100 * s.emptyShare),
                                 format("columns with voids inside  %.1f %%", 100 * s.overhangShare)};
    for (int k = 0; k < 5; ++k) {
        sheet_.text(x, y + 36 + 17 * k, lines[k]);
    }
    return y + height + 24 + kGap;
}

double Painter::histograms(double y) {
    constexpr int kBins = 80;
    constexpr double kHeight = 110;
    const double low = std::log10(lowest_) - 0.1;
    const double high = std::max(low + 0.2, std::log10(std::max(1e-9, maxComponent(s_.extinctionMax))) + 0.1);
    const auto draw = [&](double x, const std::string& title, double from, double to, const auto& valueOf,
                          const std::string& left, const std::string& right) {
        std::vector<double> counts[3];
        double largest = 1;
        for (int c = 0; c < 3; ++c) {
            counts[c].assign(kBins, 0);
            for (std::size_t i = 0; i < v_.voxelCount(); ++i) {
                if (v_.extinction[i][c] > 0) {
                    const double at = (valueOf(i, c) - from) / (to - from) * kBins;
                    counts[c][std::size_t(std::clamp(int(at), 0, kBins - 1))] += 1;
                }
            }
            largest = std::max(largest, *std::max_element(counts[c].begin(), counts[c].end()));
        }
        const double width = 2 * kSide + kGap;
        sheet_.text(x, y - 6, title, 12, Sheet::Align::Left, true);
        sheet_.fill(x, y, width, kHeight, Rgb(0.78f));
        for (int b = 0; b < kBins; ++b) {
            for (int c = 0; c < 3; ++c) {
                // Square root: rare values show beside common ones.
                const double h = kHeight * std::sqrt(counts[c][std::size_t(b)] / largest);
                const Rgb color(c == 0 ? 0.55f : 0.06f, c == 1 ? 0.36f : 0.06f, c == 2 ? 0.6f : 0.06f);
                sheet_.fill(x + (b + c / 3.0) * width / kBins, y + kHeight - h, width / kBins / 3, h, color);
            }
        }
        sheet_.frame(x, y, width, kHeight);
        sheet_.text(x, y + kHeight + 13, left, 10);
        sheet_.text(x + width, y + kHeight + 13, right, 10, Sheet::Align::Right);
    };
    draw(
        column(0), "Extinction, /mm (log); bars grow with the root of the count", low, high,
        [&](std::size_t i, int c) { return std::log10(double(v_.extinction[i][c])); },
        format("%.2g", std::pow(10, low)), format("%.2g", std::pow(10, high)));
    draw(
        column(2), "Albedo", 0, 1, [&](std::size_t i, int c) { return double(v_.albedo[i][c]); }, "0", "1");
    return y + kHeight + 34;
}

void Painter::write(const std::string& path) {
    // Once to learn how high the sheet is, once to draw it.
    double bottom = 0;
    for (int pass = 0; pass < 2; ++pass) {
        sheet_ = Sheet(int(2 * kMargin + 4 * (kSide + kGap)), std::max(10, int(bottom)));
        bottom = histograms(relief(slices(overview(heading()))));
    }
    sheet_.write(path);
}

} // namespace

void writeVolumeSheet(const BaseVolume& volume, const VolumeStatistics& statistics, const std::string& path) {
    Painter(volume, statistics).write(path);
}

} // namespace stf
