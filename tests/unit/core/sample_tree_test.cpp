// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/sample_tree.h"

#include "stfLib/base/random.h"
#include "stfLib/core/boundary_samples.h"
#include "tests/unit/core/core_shapes.h"

#include <chrono>
#include <cmath>
#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

struct Cloud {
    SurfacePoints points;
    std::vector<Rgb> values;
};

// On a ball, with light that changes a lot.
Cloud cloud(std::size_t count, float radius) {
    const CoreShape s = ball(radius, count);
    Cloud c;
    CounterRng rng(2, 3);
    c.points.areas = s.samples.areas(s.points, s.triangles);
    for (const TrianglePlace& p : s.samples.places) {
        c.points.positions.push_back(pointAt(s.points, s.triangles[p.triangle], p));
        const float lit = std::max(0.0f, c.points.positions.back().z / radius);
        c.values.push_back(Rgb(lit * rng.uniform(), 1, lit > 0.9f ? 10.0f : 0.0f));
    }
    return c;
}

const Dipole kDipoles[3] = {{0.01, 2.0}, {0.1, 1.5}, {0, 1.0}};

// B, and R times the mean of the irradiance.
Vec3d quotient(const SampleTree& tree, const std::vector<Rgb>& sums, const Vec3f& at, float epsilon,
               std::size_t* terms = nullptr) {
    SampleTree::Kernels k;
    k.dipoles = kDipoles;
    std::vector<SampleTree::Term> list;
    Vec3d total, sum(0.0);
    tree.terms(at, k, epsilon, list, total);
    for (const SampleTree::Term& t : list) {
        sum += Vec3d(t.kernel) * Vec3d(sums[t.item]);
    }
    if (terms) {
        *terms += list.size();
    }
    return {sum.x / total.x, sum.y / total.y, sum.z / total.z};
}

Vec3d direct(const Cloud& c, const Vec3f& at) {
    Vec3d sum(0.0), total(0.0);
    for (std::size_t i = 0; i < c.values.size(); ++i) {
        const Vec3f d = c.points.positions[i] - at;
        for (int k = 0; k < 3; ++k) {
            const double w = double(kDipoles[k].tabulated(dot(d, d))) * double(c.points.areas[i]);
            sum[k] += w * double(c.values[i][k]);
            total[k] += w;
        }
    }
    return {sum.x / total.x, sum.y / total.y, sum.z / total.z};
}

TEST(SampleTree, WithoutErrorItIsTheDirectSum) {
    const Cloud c = cloud(1500, 20);
    const SampleTree tree(c.points.positions, c.points.areas);
    const std::vector<Rgb> sums = tree.itemSums(c.values);
    for (const Vec3f& at : {c.points.positions[0], c.points.positions[700], Vec3f(0, 0, 0), Vec3f(50, 1, 2)}) {
        const Vec3d exact = direct(c, at), told = quotient(tree, sums, at, 0);
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(told[k], exact[k], 1e-6 * exact[k] + 1e-12);
        }
    }
}

TEST(SampleTree, TheErrorIsWithinItsBound) {
    const Cloud c = cloud(3000, 20);
    const SampleTree tree(c.points.positions, c.points.areas);
    const std::vector<Rgb> sums = tree.itemSums(c.values);
    Vec3d mean(0.0);
    double area = 0;
    for (std::size_t i = 0; i < c.values.size(); ++i) {
        mean += Vec3d(c.values[i]) * double(c.points.areas[i]);
        area += double(c.points.areas[i]);
    }
    mean /= area;
    double last = 1e30;
    for (float epsilon : {1.0f, 0.3f, 0.1f, 0.03f, 0.01f}) {
        double worst = 0, rms = 0;
        std::size_t terms = 0, asked = 0;
        for (std::size_t i = 0; i < 3000 && i < c.values.size(); i += 23, ++asked) {
            const Vec3f at = c.points.positions[i];
            const Vec3d exact = direct(c, at), told = quotient(tree, sums, at, epsilon, &terms);
            for (int k = 0; k < 3; ++k) {
                const double off = std::abs(told[k] - exact[k]) / (exact[k] + mean[k]);
                EXPECT_LE(off, double(epsilon));
                worst = std::max(worst, off);
                rms += off * off;
            }
        }
        std::printf("epsilon %.2f: worst %.2g, rms %.2g, %zu terms of %zu\n", double(epsilon), worst,
                    std::sqrt(rms / double(3 * asked)), terms / asked, c.values.size());
        EXPECT_LE(worst, last * 1.2);
        last = worst;
    }
    EXPECT_LT(last, 1e-3);
}

TEST(SampleTree, TermsGrowMuchSlowerThanPoints) {
    // The same density of points on ever larger bodies: what is far away costs next to nothing.
    std::size_t first = 0, terms = 0;
    for (std::size_t n : {1000u, 10000u, 100000u}) {
        const Cloud c = cloud(n, 2 * std::sqrt(float(n) / 12.566f));
        const SampleTree tree(c.points.positions, c.points.areas);
        const std::vector<Rgb> sums = tree.itemSums(c.values);
        terms = 0;
        const auto start = std::chrono::steady_clock::now();
        constexpr std::size_t kAsked = 200;
        for (std::size_t i = 0; i < kAsked; ++i) {
            quotient(tree, sums, c.points.positions[i * (c.values.size() / kAsked)], 0.3f, &terms);
        }
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        terms /= kAsked;
        std::printf("%zu points: %zu terms, %.1f us a sum\n", c.values.size(), terms, 1e6 * seconds / double(kAsked));
        first = first ? first : terms;
    }
    EXPECT_LT(double(terms), 12 * double(first)) << "of a hundred times the points";
}

TEST(SampleTree, TotalsOfNodesAreExact) {
    const Cloud c = cloud(777, 3);
    const SampleTree tree(c.points.positions, c.points.areas);
    const std::vector<Rgb> sums = tree.itemSums(c.values);
    Vec3d all(0.0);
    for (std::size_t i = 0; i < c.values.size(); ++i) {
        all += Vec3d(c.values[i]) * double(c.points.areas[i]);
    }
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(double(sums[0][k]), all[k], 1e-5 * all[k]);
    }
    EXPECT_NEAR(double(tree.itemArea(0)), 4 * 3.14159265 * 9, 0.2);
    EXPECT_EQ(SampleTree().itemSums({}).size(), 0u);
}

} // namespace
