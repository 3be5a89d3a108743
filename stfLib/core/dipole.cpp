// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/dipole.h"

#include <limits>

namespace stf {

namespace {
constexpr double kPi = 3.14159265358979323846;

// z (1 + s d) exp(-s d) / d^3: one source of the dipole, seen at distance d.
float pole(float z, float s, float r2) {
    const float d2 = r2 + z * z, d = std::sqrt(d2);
    return z * (1 + s * d) * std::exp(-s * d) / (d2 * d);
}

// INT_0^R 2 pi r pole dr / (4 pi), from d/dr (e^{-s d} / d) = -(1 + s d) e^{-s d} r / d^3.
double poleDisc(double z, double s, double radius) {
    const double d = std::sqrt(radius * radius + z * z);
    return 0.5 * (std::exp(-s * z) - z * std::exp(-s * d) / d);
}

std::uint32_t bitsOf(float x) {
    std::uint32_t b = 0;
    std::memcpy(&b, &x, sizeof b);
    return b;
}

float fromBits(std::uint32_t b) {
    float x = 0;
    std::memcpy(&x, &b, sizeof x);
    return x;
}
} // namespace

Dipole::Dipole(double sigmaA, double sigmaSPrime) {
    const double total = sigmaA + sigmaSPrime;
    black_ = !(sigmaSPrime > 0);
    if (black_) {
        return;
    }
    albedo_ = float(sigmaSPrime / total);
    transport_ = float(std::sqrt(3 * sigmaA * total));
    zReal_ = float(1 / total);
    zVirtual_ = float((1 + 4.0 / 3.0) / total); // z_r (1 + 4 A / 3) with A = 1
    h_ = std::make_shared<HFunction>(sigmaA / total);
    diffuseAlbedo_ = h_->diffuseReflectance();
    auto table = std::make_shared<std::vector<float>>();
    // In the medium's own unit, so that microscopic and astronomic media have the same digits; a power of two, so that
    // the table of a medium is that of the medium in other units.
    const float unit = float(std::exp2(2 * std::round(std::log2(1 / total))));
    lowestR2_ = kLowest * unit;
    highestR2_ = kHighest * unit;
    firstEntry_ = bitsOf(lowestR2_) >> kFractionBits;
    for (std::uint32_t i = firstEntry_; i <= (bitsOf(highestR2_) >> kFractionBits) + 1; ++i) {
        table->push_back(kernel(fromBits(i << kFractionBits)));
    }
    table_ = table;
}

float Dipole::kernel(float r2) const {
    if (black_) {
        return 0;
    }
    return albedo_ / float(4 * kPi) * (pole(zReal_, transport_, r2) + pole(zVirtual_, transport_, r2));
}

double Dipole::discIntegral(double radius) const {
    if (black_) {
        return 0;
    }
    const double a = double(albedo_), s = double(transport_);
    return a * (poleDisc(double(zReal_), s, radius) + poleDisc(double(zVirtual_), s, radius));
}

double Dipole::planeIntegral() const {
    if (black_) {
        return 0;
    }
    const double s = double(transport_);
    return 0.5 * double(albedo_) * (std::exp(-s * double(zReal_)) + std::exp(-s * double(zVirtual_)));
}

double Dipole::diffusionLength() const {
    return transport_ > 0 ? 1 / double(transport_) : std::numeric_limits<double>::infinity();
}

} // namespace stf
