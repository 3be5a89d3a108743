// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/volume_statistics.h"

#include "stfLib/optics/material.h"
#include "stfLib/optics/semi_infinite.h"

#include <cmath>
#include <limits>

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;

bool holdsMaterial(const BaseVolume& v, std::size_t i) {
    return v.surface.empty() ? maxComponent(v.extinction[i]) > 0 : v.surface[i] < 0;
}

// Sums of squared differences of neighbours along an axis: across the wrap, and inside.
template<class Value>
double seamRatio(const BaseVolume& v, int axis, Value value) {
    const int n = v.size[axis];
    if (n < 3) {
        return 1;
    }
    double wrap = 0, inside = 0;
    for (int z = 0; z < v.size.z; ++z) {
        for (int k = 0; k < v.size[1 - axis]; ++k) {
            for (int i = 0; i < n; ++i) {
                const int j = (i + 1) % n;
                const std::size_t a = axis == 0 ? v.index(i, k, z) : v.index(k, i, z);
                const std::size_t b = axis == 0 ? v.index(j, k, z) : v.index(k, j, z);
                const double d = value(a) - value(b);
                (j == 0 ? wrap : inside) += d * d;
            }
        }
    }
    inside /= n - 1;
    return inside > 0 ? std::sqrt(wrap / inside) : wrap > 0 ? std::numeric_limits<double>::infinity() : 1;
}

SurfaceStatistics surfaceStatistics(const BaseVolume& v) {
    const std::vector<float> depths = surfaceDepths(v);
    SurfaceStatistics s;
    double sum = 0, squares = 0, steepest = 0;
    std::size_t count = 0, overhangs = 0;
    s.highestMm = std::numeric_limits<double>::infinity();
    const auto at = [&](int x, int y) {
        return double(depths[std::size_t(x) + std::size_t(v.size.x) * std::size_t(y)]);
    };
    for (int y = 0; y < v.size.y; ++y) {
        for (int x = 0; x < v.size.x; ++x) {
            const double d = at(x, y);
            if (d < 0) {
                continue;
            }
            ++count;
            sum += d;
            squares += d * d;
            s.highestMm = std::min(s.highestMm, d);
            s.lowestMm = std::max(s.lowestMm, d);
            const double dx = at((x + 1) % v.size.x, y), dy = at(x, (y + 1) % v.size.y);
            if (dx >= 0 && dy >= 0) {
                steepest = std::max(steepest, std::hypot((dx - d) / v.voxelMm.x, (dy - d) / v.voxelMm.y));
            }
            bool met = false;
            for (int z = 0; z < v.size.z; ++z) {
                const bool material = holdsMaterial(v, v.index(x, y, z));
                if (met && !material) {
                    ++overhangs;
                    break;
                }
                met = met || material;
            }
        }
    }
    const double columns = double(depths.size());
    s.emptyShare = 1 - double(count) / columns;
    s.overhangShare = double(overhangs) / columns;
    if (count == 0) {
        s.highestMm = 0;
        return s;
    }
    s.meanMm = sum / double(count);
    s.rmsMm = std::sqrt(std::max(0.0, squares / double(count) - s.meanMm * s.meanMm));
    s.steepest = std::atan(steepest) * 180 / kPi;
    return s;
}

void addOpticalDepths(const BaseVolume& v, VolumeStatistics& s) {
    s.opticalDepthMin = Vec3d(std::numeric_limits<double>::infinity());
    for (int y = 0; y < v.size.y; ++y) {
        for (int x = 0; x < v.size.x; ++x) {
            Vec3d depth(0.0);
            for (int z = 0; z < v.size.z; ++z) {
                depth += Vec3d(v.extinction[v.index(x, y, z)]) * v.voxelMm.z;
            }
            s.opticalDepthMean += depth;
            for (int c = 0; c < 3; ++c) {
                s.opticalDepthMin[c] = std::min(s.opticalDepthMin[c], depth[c]);
                s.opticalDepthMax[c] = std::max(s.opticalDepthMax[c], depth[c]);
            }
        }
    }
    s.opticalDepthMean /= double(v.size.x) * v.size.y;
}

} // namespace

MeanCoefficients meanCoefficients(const BaseVolume& v) {
    MeanCoefficients m;
    double ior = 0;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        if (maxComponent(v.extinction[i]) > 0) {
            const double g = v.g.empty() ? 0 : double(v.g[i]);
            const Vec3d s(v.extinction[i] * v.albedo[i]);
            m.sigmaSPrime += s * (1 - g);
            m.sigmaA += Vec3d(v.extinction[i]) - s;
            ior += v.ior.empty() ? 1 : double(v.ior[i]);
            ++m.filled;
        }
    }
    if (m.filled > 0) {
        m.sigmaA /= double(m.filled);
        m.sigmaSPrime /= double(m.filled);
        m.ior = ior / double(m.filled);
    }
    return m;
}

std::vector<float> surfaceDepths(const BaseVolume& v) {
    std::vector<float> depths(std::size_t(v.size.x) * std::size_t(v.size.y), -1.0f);
    for (int y = 0; y < v.size.y; ++y) {
        for (int x = 0; x < v.size.x; ++x) {
            float& depth = depths[std::size_t(x) + std::size_t(v.size.x) * std::size_t(y)];
            for (int z = 0; z < v.size.z && depth < 0; ++z) {
                const std::size_t i = v.index(x, y, z);
                if (!holdsMaterial(v, i)) {
                    continue;
                }
                if (z == 0) {
                    depth = 0;
                } else if (v.surface.empty()) {
                    depth = float(z * v.voxelMm.z);
                } else {
                    const double above = double(v.surface[v.index(x, y, z - 1)]), here = double(v.surface[i]);
                    depth = float((z - 0.5 + above / (above - here)) * v.voxelMm.z);
                }
            }
        }
    }
    return depths;
}

double shareFromBelow(double sigmaA, double sigmaSPrime, double ior, double thicknessMm) {
    const double total = sigmaA + sigmaSPrime;
    if (!(sigmaSPrime > 0)) {
        return 0;
    }
    if (!(sigmaA > 0)) {
        // The limit of little absorption: what two-flux theory lets through a slab that only scatters.
        return 1 / (1 + 0.75 * sigmaSPrime * thicknessMm);
    }
    const double r = semiInfiniteReflectance(sigmaA / total, ior);
    const double e = std::exp(-2 * thicknessMm * std::sqrt(3 * sigmaA * total));
    return (1 - r * r) * e / (1 - r * r * e);
}

double thicknessForShare(double sigmaA, double sigmaSPrime, double ior, double share) {
    const double total = sigmaA + sigmaSPrime;
    if (!(sigmaSPrime > 0)) {
        return 0;
    }
    if (!(sigmaA > 0)) {
        return std::numeric_limits<double>::infinity();
    }
    const double r = semiInfiniteReflectance(sigmaA / total, ior);
    const double e = share / (1 - r * r + share * r * r);
    return std::max(0.0, -0.5 * std::log(e) / std::sqrt(3 * sigmaA * total));
}

double periodicityError(const BaseVolume& v, int axis) {
    double worst = 1;
    bool any = false;
    const auto take = [&](double ratio) {
        worst = any ? std::max(worst, ratio) : ratio;
        any = true;
    };
    const auto scattering = [&](std::size_t i) { return double(luminance(v.extinction[i] * v.albedo[i])); };
    const auto absorption = [&](std::size_t i) {
        return double(luminance(v.extinction[i] * (Rgb(1.0f) - v.albedo[i])));
    };
    take(seamRatio(v, axis, scattering));
    take(seamRatio(v, axis, absorption));
    if (!v.surface.empty()) {
        // Far from the surface the distance says nothing that anyone sees.
        const double band = 2 * maxComponent(v.voxelMm);
        take(seamRatio(v, axis, [&](std::size_t i) { return std::clamp(double(v.surface[i]), -band, band); }));
    }
    return worst;
}

VolumeStatistics statisticsOf(const BaseVolume& v) {
    VolumeStatistics s;
    s.extinctionMin = Vec3d(std::numeric_limits<double>::infinity());
    std::size_t material = 0;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        for (int c = 0; c < 3; ++c) {
            s.extinctionMin[c] = std::min(s.extinctionMin[c], double(v.extinction[i][c]));
            s.extinctionMax[c] = std::max(s.extinctionMax[c], double(v.extinction[i][c]));
        }
        if (maxComponent(v.extinction[i]) > 0) {
            s.albedoMean += Vec3d(v.albedo[i]);
        }
        material += holdsMaterial(v, i) ? 1 : 0;
    }
    addOpticalDepths(v, s);
    const auto range = [](const std::vector<float>& values, double& lowest, double& highest) {
        if (!values.empty()) {
            const auto [low, high] = std::minmax_element(values.begin(), values.end());
            lowest = double(*low);
            highest = double(*high);
        }
    };
    range(v.g, s.gMin, s.gMax);
    range(v.ior, s.iorMin, s.iorMax);
    s.mean = meanCoefficients(v);
    s.filledShare = double(s.mean.filled) / double(v.voxelCount());
    if (s.mean.filled > 0) {
        s.albedoMean /= double(s.mean.filled);
    }
    s.thicknessMm = v.extentMm().z * double(material) / double(v.voxelCount());
    Material mean;
    mean.sigmaA = s.mean.sigmaA;
    mean.sigmaS = s.mean.sigmaSPrime;
    s.diffusionLengthMm = diffusionLengthMm(mean);
    for (int c = 0; c < 3; ++c) {
        s.reflectanceFromCore[c] = shareFromBelow(mean.sigmaA[c], mean.sigmaS[c], s.mean.ior, s.thicknessMm);
    }
    s.periodicity[0] = periodicityError(v, 0);
    s.periodicity[1] = periodicityError(v, 1);
    s.bytes = (v.extinction.size() + v.albedo.size() + v.emission.size()) * sizeof(Rgb) +
              (v.g.size() + v.ior.size() + v.surface.size()) * sizeof(float);
    if (!v.surface.empty() || v.hasRelief()) {
        s.surface = surfaceStatistics(v);
    }
    return s;
}

} // namespace stf
