// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/core_walk.h"

#include "stfLib/base/hemisphere.h"
#include "stfLib/base/parallel.h"

#include <algorithm>
#include <array>

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
constexpr int kCells = 40;                   ///< of distances, along the longest side
constexpr int kMaxSteps = 20000;             ///< of a walk: what is left then is lost
constexpr double kExtrapolation = 0.7104461; ///< mean free paths, of Milne's problem
constexpr double kJumpPaths = 5;             ///< mean free paths: least radius of a jump
constexpr double kJumpAlbedo = 0.98;         ///< below it, the decay is no longer that of diffusion, and walks end soon
constexpr double kAlike = 1.2;               ///< channels within this factor of a common scattering walk together
constexpr float kRouletteBelow = 0.1f;

Vec3f evenDirection(CounterRng& rng) {
    const float z = 1 - 2 * rng.uniform(), phi = 2 * kPi * rng.uniform(), r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
}

// Inverse distribution of mu H(mu), H of the conservative medium.
std::array<float, 257> milneTable() {
    constexpr int kFine = 1 << 14;
    const HFunction h(0.0);
    std::vector<double> sum(kFine + 1, 0.0);
    for (int i = 0; i < kFine; ++i) {
        const double mu = (i + 0.5) / kFine;
        sum[std::size_t(i) + 1] = sum[std::size_t(i)] + mu * h(mu);
    }
    std::array<float, 257> table{};
    std::size_t k = 0;
    for (std::size_t i = 0; i < table.size(); ++i) {
        const double wanted = sum.back() * double(i) / 256;
        while (k + 1 < kFine && sum[k + 1] < wanted) {
            ++k;
        }
        table[i] = float((double(k) + (wanted - sum[k]) / (sum[k + 1] - sum[k])) / kFine);
    }
    return table;
}

} // namespace

DistanceCells::DistanceCells(const RayMesh& mesh) : box_(mesh.innerBounds()) {
    if (box_.empty()) {
        return;
    }
    const Vec3f extent = box_.hi - box_.lo;
    cell_ = std::max(maxComponent(extent) / float(kCells), 1e-30f);
    for (int a = 0; a < 3; ++a) {
        size_[a] = std::max(1, int(std::ceil(extent[a] / cell_)));
    }
    const std::size_t row = std::size_t(size_.x);
    distances_.resize(row * std::size_t(size_.y) * std::size_t(size_.z));
    parallelFor(distances_.size() / row, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r) {
            for (std::size_t x = 0; x < row; ++x) {
                const Vec3f middle = Vec3f(float(x), float(r % std::size_t(size_.y)), float(r / std::size_t(size_.y)));
                distances_[r * row + x] =
                    mesh.innerDistance(box_.lo + (middle + Vec3f(0.5f)) * cell_, 2 * box_.diagonal() + cell_);
            }
        }
    });
}

float DistanceCells::atLeast(const Vec3f& point) const {
    const Vec3f p = (point - box_.lo) / cell_;
    Vec3i i;
    for (int a = 0; a < 3; ++a) {
        if (!(p[a] >= 0 && p[a] < float(size_[a]))) {
            return -1;
        }
        i[a] = int(p[a]);
    }
    const Vec3f from = p - Vec3f(float(i.x) + 0.5f, float(i.y) + 0.5f, float(i.z) + 0.5f);
    const std::size_t index =
        std::size_t(i.x) + std::size_t(size_.x) * (std::size_t(i.y) + std::size_t(size_.y) * std::size_t(i.z));
    return distances_[index] - length(from) * cell_;
}

CoreWalk::Diffusion::Diffusion(double sigmaA, double sigmaSPrime) {
    const double total = sigmaA + sigmaSPrime;
    if (!(total > 0)) {
        return;
    }
    beyond = kExtrapolation / total;
    const double albedo = sigmaSPrime / total, absorption = sigmaA / total;
    double lo = 0, hi = 1;
    for (int i = 0; i < 80; ++i) {
        const double k = 0.5 * (lo + hi), k2 = k * k;
        // artanh(k) / k - 1, by its series where the difference would lose its digits.
        const double excess = k < 0.05 ? k2 * (1.0 / 3 + k2 * (0.2 + k2 / 7)) : std::atanh(k) / k - 1;
        (albedo * excess < absorption ? lo : hi) = k;
    }
    decay = absorption > 0 ? 0.5 * (lo + hi) * total : 0.0;
}

double CoreWalk::Diffusion::survival(double radius) const {
    const double x = decay * radius;
    if (x < 1e-6) {
        return 1;
    }
    if (x > 600) {
        return 0;
    }
    // u = sinh(k r) / r within, u + beyond u' = 1 at the surface (no light comes in).
    const double sinh = std::sinh(x);
    const double slope = x < 1e-2 ? x * x * x / 3 / radius : decay * std::cosh(x) - sinh / radius;
    return x / (sinh + beyond * slope);
}

float CoreWalk::milneCosine(float u) {
    static const std::array<float, 257> table = milneTable();
    const float at = u * 256;
    const std::size_t i = std::min<std::size_t>(255, std::size_t(at));
    return table[i] + (table[i + 1] - table[i]) * (at - float(i));
}

CoreWalk::CoreWalk(const CoreMaterial& m, const RayMesh& mesh, double mmPerUnit)
    : mesh_(mesh), sigmaA_(m.sigmaA * mmPerUnit), sigmaS_(m.sigmaSPrime * mmPerUnit) {
    for (int c = 0; c < 3; ++c) {
        diffusion_[c] = Diffusion(sigmaA_[c], sigmaS_[c]);
    }
    int order[3] = {0, 1, 2};
    std::sort(order, order + 3, [&](int a, int b) { return sigmaS_[a] < sigmaS_[b]; });
    for (int i = 0; i < 3;) {
        Group g;
        const double least = sigmaS_[order[i]];
        double most = least;
        while (i < 3 && sigmaS_[order[i]] <= least * kAlike * kAlike) {
            most = sigmaS_[order[i]];
            g.channel[order[i++]] = true;
        }
        g.scattering = std::sqrt(least * most);
        double albedo = 1;
        for (int c = 0; c < 3; ++c) {
            albedo = g.channel[c] && sigmaS_[c] > 0 ? std::min(albedo, sigmaS_[c] / (sigmaA_[c] + sigmaS_[c])) : albedo;
        }
        g.jumpFrom = g.scattering > 0 && albedo >= kJumpAlbedo ? float(kJumpPaths / least) : 1e30f;
        groups_.push_back(g);
    }
    distances_ = std::make_shared<const DistanceCells>(mesh);
    rounding_ = 1e-6f * std::max(distances_->box().diagonal(),
                                 std::max(length(distances_->box().lo), length(distances_->box().hi)));
}

CoreWalk::Exit CoreWalk::walk(const Group& group, const Vec3f& from, const Vec3f& inward, std::uint32_t triangle,
                              CounterRng& rng) const {
    Exit out;
    Rgb weight(group.channel[0] ? 1.0f : 0.0f, group.channel[1] ? 1.0f : 0.0f, group.channel[2] ? 1.0f : 0.0f);
    const Rgb sigmaA(sigmaA_), sigmaS(sigmaS_);
    const float scattering = float(group.scattering);
    const DistanceCells& cells = *distances_;
    const Box3f& box = cells.box();
    Vec3f x, y;
    orthonormalBasis(inward, x, y);
    const float u = rng.uniform(), v = rng.uniform();
    const Vec3f local = cosineHemisphere({u, v});
    Vec3f p = from, d = x * local.x + y * local.y + inward * local.z;
    for (int step = 0; step < kMaxSteps; ++step) {
        const float flight = scattering > 0 ? rng.exponential() / scattering : 1e30f;
        if (!(flight < cells.atLeast(p))) {
            Ray ray;
            ray.origin = p;
            ray.direction = d;
            ray.tFar = flight;
            RayHit hit;
            bool found = mesh_.intersect(ray, hit, 2);
            if (found && step == 0 && hit.triangle == triangle) {
                // Not where it starts: rather that than a start at a depth, which stiff media would feel.
                ray.tNear = hit.t + rounding_;
                found = mesh_.intersect(ray, hit, 2) && hit.triangle != triangle;
            }
            if (found) {
                for (int c = 0; c < 3; ++c) {
                    weight[c] *= std::exp(-(sigmaS[c] - scattering + sigmaA[c]) * hit.t);
                }
                out.left = true;
                out.point = p + d * hit.t;
                out.normal = hit.geometricNormal;
                out.weight = weight;
                return out;
            }
        }
        if (!(flight < 1e30f)) {
            return out;
        }
        p += d * flight;
        for (int a = 0; a < 3; ++a) {
            if (!(p[a] >= box.lo[a] - rounding_ && p[a] <= box.hi[a] + rounding_)) {
                return out; // through a hole
            }
        }
        float largest = 0;
        for (int c = 0; c < 3; ++c) {
            weight[c] *= weight[c] > 0
                             ? sigmaS[c] / scattering * std::exp(-(sigmaS[c] - scattering + sigmaA[c]) * flight)
                             : 0.0f;
            largest = std::max(largest, weight[c]);
        }
        if (largest < kRouletteBelow) {
            if (!(rng.uniform() * kRouletteBelow < largest)) {
                return out;
            }
            weight *= kRouletteBelow / largest;
        }
        d = evenDirection(rng);
        // A point behind the boundary by rounding is nowhere near the middle of a ball.
        float radius = cells.atLeast(p);
        if (radius < group.jumpFrom && 2 * group.jumpFrom < cells.cell()) {
            radius = mesh_.innerDistance(p, box.diagonal());
        }
        radius -= rounding_;
        if (radius > group.jumpFrom) {
            // The direction is even already; it becomes the way to the ball's surface.
            p += d * radius;
            for (int c = 0; c < 3; ++c) {
                weight[c] *= weight[c] > 0 ? float(diffusion_[c].survival(double(radius))) : 0.0f;
            }
            orthonormalBasis(d, x, y);
            const float mu = milneCosine(rng.uniform()), phi = 2 * kPi * rng.uniform(), r = std::sqrt(1 - mu * mu);
            d = x * (r * std::cos(phi)) + y * (r * std::sin(phi)) + d * mu;
        }
    }
    return out;
}

} // namespace stf
