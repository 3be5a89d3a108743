// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/boundary_samples.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"
#include "stfLib/core/point_cells.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {

constexpr std::size_t kDartsPerSample = 12;
constexpr std::uint64_t kDartStream = 0x636f7265; // of random numbers
/// n darts of a saturated set with radius r cover the share n r^2 / area of a plane.
constexpr double kPacking = 0.60;

Vec3d areaVector(const std::vector<Vec3f>& points, const Vec3i& t) {
    const Vec3d a(points[std::size_t(t.x)]), b(points[std::size_t(t.y)]), c(points[std::size_t(t.z)]);
    return cross(b - a, c - a) * 0.5;
}

struct Darts {
    std::vector<TrianglePlace> places;
    std::vector<Vec3f> points, normals;
};

// Strata of equal area along the list of triangles, shuffled.
Darts throwDarts(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles,
                 const std::vector<double>& areas, double total, std::size_t count, std::uint64_t seed) {
    CounterRng rng(seed, kDartStream);
    Darts darts;
    double passed = 0;
    std::size_t t = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double at = (double(i) + double(rng.uniform())) / double(count) * total;
        while (t + 1 < triangles.size() && passed + areas[t] <= at) {
            passed += areas[t++];
        }
        const float r = std::sqrt(rng.uniform()), v = rng.uniform();
        darts.places.push_back({std::uint32_t(t), r * (1 - v), r * v});
    }
    for (std::size_t i = count; i > 1; --i) {
        std::swap(darts.places[i - 1], darts.places[std::size_t(rng.bits()) % i]);
    }
    for (const TrianglePlace& p : darts.places) {
        darts.points.push_back(pointAt(points, triangles[p.triangle], p));
        darts.normals.push_back(Vec3f(normalize(areaVector(points, triangles[p.triangle]))));
    }
    return darts;
}

} // namespace

double surfaceArea(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles) {
    double total = 0;
    for (const Vec3i& t : triangles) {
        const double a = length(areaVector(points, t));
        total += std::isfinite(a) ? a : 0.0;
    }
    return total;
}

BoundarySamples spreadSamples(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles, std::size_t wanted,
                              std::uint64_t seed) {
    BoundarySamples out;
    out.firstPart.push_back(0);
    double total = 0;
    for (const Vec3i& t : triangles) {
        const double a = length(areaVector(points, t));
        out.triangleAreas.push_back(std::isfinite(a) ? a : 0.0);
        total += out.triangleAreas.back();
    }
    if (!(total > 0) || wanted == 0) {
        return out;
    }
    const Darts darts = throwDarts(points, triangles, out.triangleAreas, total, wanted * kDartsPerSample, seed);
    const float radius = float(std::sqrt(kPacking * total / double(wanted)));
    const PointCells cells(darts.points, radius);
    std::vector<char> kept(darts.points.size(), 0), refused(darts.points.size(), 0);
    std::vector<std::size_t> samples;
    for (std::size_t i = 0; i < darts.points.size(); ++i) {
        if (refused[i]) {
            continue;
        }
        kept[i] = 1;
        samples.push_back(i);
        cells.near(darts.points[i], radius, [&](std::size_t j) {
            const Vec3f d = darts.points[j] - darts.points[i];
            refused[j] |= dot(d, d) < radius * radius && dot(darts.normals[i], darts.normals[j]) > 0 ? 1 : 0;
        });
    }

    // Each dart belongs to the nearest sample of its own side. Its refuser is near, so that there always is one.
    std::vector<std::uint32_t> number(darts.points.size(), 0);
    for (std::size_t s = 0; s < samples.size(); ++s) {
        number[samples[s]] = std::uint32_t(s);
    }
    std::vector<std::uint32_t> owner(darts.points.size());
    parallelFor(darts.points.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            float least = 1e30f;
            owner[i] = number[i];
            if (kept[i]) {
                continue;
            }
            cells.near(darts.points[i], radius, [&](std::size_t j) {
                const Vec3f d = darts.points[j] - darts.points[i];
                if (kept[j] && dot(d, d) < least && dot(darts.normals[i], darts.normals[j]) > 0) {
                    least = dot(d, d);
                    owner[i] = number[j];
                }
            });
        }
    });
    out.firstPart.assign(samples.size() + 1, 0);
    for (std::uint32_t o : owner) {
        ++out.firstPart[o + 1];
    }
    for (std::size_t s = 0; s < samples.size(); ++s) {
        out.firstPart[s + 1] += out.firstPart[s];
        out.places.push_back(darts.places[samples[s]]);
    }
    std::vector<std::uint32_t> next(out.firstPart.begin(), out.firstPart.end() - 1);
    out.parts.resize(darts.places.size());
    for (std::size_t i = 0; i < owner.size(); ++i) {
        out.parts[next[owner[i]]++] = darts.places[i];
    }
    return out;
}

std::vector<float> BoundarySamples::areas(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles) const {
    std::vector<double> area(count(), 0.0);
    double sum = 0;
    for (std::size_t i = 0; i < count(); ++i) {
        for (std::uint32_t k = firstPart[i]; k < firstPart[i + 1]; ++k) {
            const std::uint32_t t = parts[k].triangle;
            const double now = length(areaVector(points, triangles[t]));
            area[i] += triangleAreas[t] > 0 && std::isfinite(now) ? now / triangleAreas[t] : 0.0;
        }
        sum += area[i];
    }
    const double scale = sum > 0 ? surfaceArea(points, triangles) / sum : 0.0;
    std::vector<float> out(count());
    for (std::size_t i = 0; i < count(); ++i) {
        out[i] = float(area[i] * scale);
    }
    return out;
}

} // namespace stf
