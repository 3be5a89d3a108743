// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/semi_infinite.h"

#include "stfLib/optics/fresnel.h"
#include "stfLib/optics/gauss_legendre.h"
#include "stfLib/optics/h_function.h"

#include <cmath>
#include <vector>

namespace stf {

namespace {

// Cosines inside the medium with their weights, in two parts: Fresnel's reflectance has a kink (with a root's slope) at
// the angle of total reflection.
struct Nodes {
    std::vector<double> mu, weight;
    explicit Nodes(double critical) {
        const GaussLegendre rule(48);
        for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
            const double t = rule.nodes[i], w = rule.weights[i];
            if (critical > 0) {
                mu.push_back(critical * t * t);
                weight.push_back(critical * 2 * t * w);
            }
            mu.push_back(critical + (1 - critical) * t * t);
            weight.push_back((1 - critical) * 2 * t * w);
        }
    }
};

} // namespace

double semiInfiniteReflectance(double absorption, double ior) {
    const double albedo = 1 - std::clamp(absorption, 0.0, 1.0);
    if (albedo == 0) {
        return 0;
    }
    if (absorption <= 0) {
        return 1; // all that enters leaves
    }
    const HFunction h(absorption);
    if (ior == 1) {
        return h.reflectance(1);
    }
    const Nodes nodes(ior > 1 ? std::sqrt((ior - 1) * (ior + 1)) / ior : 0.0);
    const std::size_t n = nodes.mu.size();
    std::vector<double> values(n), inside(n), up(n), first(n);
    for (std::size_t i = 0; i < n; ++i) {
        values[i] = h(nodes.mu[i]);
        inside[i] = fresnelSplit<double>(nodes.mu[i], 1 / ior).reflectance;
        // Radiance times pi per flux that entered along the normal: (a / 4) H H / (mu + mu0) at mu0 = 1.
        first[i] = 0.25 * albedo * values[i] * h(1.0) / (nodes.mu[i] + 1);
    }
    // up = first + K inside up, by its series: each term is a round trip, of which (1 - F) leaves.
    up = first;
    double change = 1;
    for (int trip = 0; trip < 10000 && change > 1e-12; ++trip) {
        std::vector<double> next = first;
        change = 0;
        for (std::size_t i = 0; i < n; ++i) {
            double sum = 0;
            for (std::size_t j = 0; j < n; ++j) {
                sum += nodes.weight[j] * nodes.mu[j] * values[j] * inside[j] * up[j] / (nodes.mu[i] + nodes.mu[j]);
            }
            next[i] += 0.5 * albedo * values[i] * sum;
            change = std::max(change, std::abs(next[i] - up[i]));
        }
        up = next;
    }
    double leaving = 0;
    for (std::size_t i = 0; i < n; ++i) {
        leaving += 2 * nodes.weight[i] * nodes.mu[i] * (1 - inside[i]) * up[i];
    }
    return leaving;
}

Vec3d diffuseReflectance(const Material& m) {
    const Vec3d scattering = m.sigmaSPrime();
    Vec3d result;
    for (int c = 0; c < 3; ++c) {
        const double total = m.sigmaA[c] + scattering[c];
        result[c] = scattering[c] > 0 ? semiInfiniteReflectance(m.sigmaA[c] / total, m.ior) : 0.0;
    }
    return result;
}

Vec3d meanFreePathMm(const Material& m) {
    const Vec3d total = m.sigmaA + m.sigmaSPrime();
    return {1 / total.x, 1 / total.y, 1 / total.z};
}

Vec3d diffusionLengthMm(const Material& m) {
    const Vec3d total = m.sigmaA + m.sigmaSPrime();
    Vec3d result;
    for (int c = 0; c < 3; ++c) {
        result[c] = 1 / std::sqrt(3 * m.sigmaA[c] * total[c]);
    }
    return result;
}

} // namespace stf
