// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/factored_field.h"

#include "stfLib/base/error.h"
#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"

#include <gtest/gtest.h>

using namespace stf;

namespace {

using Values = std::vector<std::vector<float>>;

float normal(CounterRng& rng) {
    return std::sqrt(-2 * std::log(rng.uniformPositive())) * std::cos(6.2831853f * rng.uniform());
}

// A field of exact rank (but for rounding to float), its parts of falling size.
Values ofRank(int rank, int directions, int items, int components, double fall = 0.3, double scale = 1) {
    CounterRng rng(7, std::uint64_t(rank));
    const std::size_t count = std::size_t(items * components);
    std::vector<std::vector<double>> a{std::size_t(rank), std::vector<double>(count)};
    for (auto& v : a) {
        for (double& x : v) {
            x = double(normal(rng));
        }
    }
    Values values{std::size_t(directions), std::vector<float>(count)};
    for (auto& v : values) {
        std::vector<double> b;
        for (int k = 0; k < rank; ++k) {
            b.push_back(double(normal(rng)) * std::pow(fall, k) * scale);
        }
        for (std::size_t i = 0; i < count; ++i) {
            double sum = 0;
            for (int k = 0; k < rank; ++k) {
                sum += a[std::size_t(k)][i] * b[std::size_t(k)];
            }
            v[i] = float(sum);
        }
    }
    return values;
}

// Root mean square over all values, weighted.
double rms(const Values& values, const std::vector<float>& weights = {}) {
    double sum = 0, count = 0;
    for (const auto& v : values) {
        for (std::size_t i = 0; i < v.size(); ++i) {
            sum += double(v[i]) * double(v[i]) * (weights.empty() ? 1.0 : double(weights[i]));
        }
        count += double(v.size());
    }
    return std::sqrt(sum / count);
}

// What a field says at the nodes, less the values.
Values difference(const FactoredField& field, const Values& values) {
    Values d = values;
    for (std::size_t n = 0; n < values.size(); ++n) {
        for (std::size_t i = 0; i < values[n].size() && !field.empty(); ++i) {
            const std::size_t width = std::size_t(field.components);
            d[n][i] -= field.node(i / width, int(n), int(i % width));
        }
    }
    return d;
}

FactoriseOptions tolerance(double t) {
    FactoriseOptions o;
    o.tolerance = t;
    return o;
}

// ---- factorisation

TEST(Factorise, RecoversAFieldOfLowRank) {
    const Values values = ofRank(3, 9, 500, 3);
    FactoriseReport report;
    const FactoredField field = factorise(values, 3, tolerance(0), &report);
    EXPECT_EQ(field.rank, 3);
    EXPECT_EQ(field.directions, 9);
    EXPECT_EQ(field.items(), 500u);
    EXPECT_EQ(field.bytes(), (500u * 3 * 3 + 9 * 3) * sizeof(float));
    EXPECT_LT(rms(difference(field, values)), 3e-7 * rms(values));
    EXPECT_LT(report.truncation, 1e-6);
    EXPECT_EQ(report.noise, 0);
}

TEST(Factorise, SmallestRankWithinTheToleranceAndItsTrueError) {
    const Values values = ofRank(9, 9, 700, 12, 0.4);
    int last = 0;
    for (double t : {0.5, 0.1, 0.03, 0.01, 0.003}) {
        FactoriseReport report;
        const FactoredField field = factorise(values, 12, tolerance(t), &report);
        const double error = rms(difference(field, values)) / rms(values);
        EXPECT_LE(error, t);
        EXPECT_NEAR(report.truncation / error, 1, 1e-6) << field.rank;
        EXPECT_GE(field.rank, last);
        last = field.rank;
        FactoriseOptions fewer = tolerance(t);
        fewer.maxRank = field.rank - 1;
        const FactoredField less = factorise(values, 12, fewer, &report);
        EXPECT_EQ(less.rank, field.rank - 1);
        EXPECT_GT(report.truncation, t) << "one less would not do";
    }
    EXPECT_GT(last, 4);
}

TEST(Factorise, BestOfItsRank) {
    // No other two factors: those of a field that is turned a little are worse.
    const Values values = ofRank(5, 8, 300, 3, 0.6);
    FactoriseOptions o = tolerance(0);
    o.maxRank = 2;
    const FactoredField best = factorise(values, 3, o);
    const double error = rms(difference(best, values));
    for (int k = 0; k < 8; ++k) {
        FactoredField other = best;
        for (std::size_t i = 0; i < other.basis.size(); i += 2) {
            other.basis[i] += (int(i / 2) == k ? 0.02f : 0.0f) * std::abs(best.basis[0]);
        }
        EXPECT_GT(rms(difference(other, values)), error);
    }
}

TEST(Factorise, WeightsChooseWhatIsKept) {
    // Two items with directions of their own; the norm sees almost only one.
    const Values values{{2, 2, 2, 0, 0, 0}, {0, 0, 0, 3, 3, 3}};
    FactoriseOptions o = tolerance(0.1);
    FactoriseReport report;
    EXPECT_EQ(factorise(values, 3, o).rank, 2);
    o.weights = {1, 1, 1, 1e-4f, 1e-4f, 1e-4f};
    const FactoredField field = factorise(values, 3, o, &report);
    EXPECT_EQ(field.rank, 1);
    EXPECT_NEAR(field.node(0, 0, 1), 2, 1e-6f);
    EXPECT_NEAR(field.node(1, 1, 1), 0, 1e-6f);
    EXPECT_NEAR(report.truncation, rms(difference(field, values), o.weights) / rms(values, o.weights), 1e-7);
    // The other way round.
    o.weights = {1e-4f, 1e-4f, 1e-4f, 1, 1, 1};
    EXPECT_NEAR(factorise(values, 3, o).node(1, 1, 1), 3, 1e-6f);
    // Weights of zero still give values.
    o = tolerance(0);
    o.weights = {1, 1, 1, 0, 0, 0};
    const FactoredField half = factorise({{1, 2, 3, 4, 5, 6}, {2, 4, 6, 8, 10, 12}}, 3, o);
    EXPECT_NEAR(half.node(1, 1, 2), 12, 1e-5f);
}

// Signal of rank 4 and white noise of known size.
TEST(Factorise, KeepsSignalAndDropsNoise) {
    const int directions = 20, items = 4000, components = 3;
    const Values clean = ofRank(4, directions, items, components, 0.25);
    for (double share : {0.01, 0.05, 0.2}) {
        const double sigma = share * rms(clean);
        Values noisy = clean;
        CounterRng rng(11, std::uint64_t(1e4 * share));
        for (auto& v : noisy) {
            for (float& x : v) {
                x += float(sigma) * normal(rng);
            }
        }
        FactoriseOptions o = tolerance(1e-4);
        o.noiseGram.assign(std::size_t(directions * directions), 0.0);
        for (int d = 0; d < directions; ++d) {
            o.noiseGram[std::size_t(d * directions + d)] = sigma * sigma * items * components;
        }
        FactoriseReport report;
        const FactoredField field = factorise(noisy, components, o, &report);
        // The true rank, but for a factor whose own share of the signal is below that of the noise in it.
        int expected = 0;
        double left = 1;
        for (int k = 1; k <= 4; ++k) {
            FactoriseOptions first = tolerance(0);
            first.maxRank = k;
            FactoriseReport r;
            factorise(clean, components, first, &r);
            expected += left - r.truncation * r.truncation > share * share / directions;
            left = r.truncation * r.truncation;
        }
        EXPECT_EQ(field.rank, expected) << share;
        EXPECT_TRUE(share > 0.01 || expected == 4);
        // Noise that is left: that of so many factors of `directions`, of variance sigma^2 each.
        EXPECT_NEAR(report.noise / (share * std::sqrt(double(field.rank) / directions)), 1, 0.02);
        const double error = rms(difference(field, clean)) / rms(clean);
        const double said = std::hypot(report.noise, report.truncation);
        EXPECT_LT(error, 0.6 * share);
        EXPECT_NEAR(error / said, 1, 0.05)
            << share << ": noise " << report.noise << " truncation " << report.truncation;
    }
}

// Noise that differs between directions: a strong but merely noisy direction is not taken for signal.
TEST(Factorise, FactorsAreThoseOfTheSignalNotOfTheNoise) {
    const int directions = 6, items = 20000;
    const Values clean = ofRank(1, directions, items, 3);
    Values noisy = clean;
    CounterRng rng(13, 0);
    FactoriseOptions o = tolerance(0.01);
    o.noiseGram.assign(std::size_t(directions * directions), 0.0);
    const double sigma = 3 * rms(clean); // of direction 2, the others are clean
    for (float& x : noisy[2]) {
        x += float(sigma) * normal(rng);
    }
    o.noiseGram[2 * 6 + 2] = sigma * sigma * items * 3;
    const FactoredField field = factorise(noisy, 3, o);
    ASSERT_EQ(field.rank, 1);
    const FactoredField truth = factorise(clean, 3, tolerance(0));
    ASSERT_EQ(truth.rank, 1);
    double product = 0, a = 0, b = 0;
    for (int d = 0; d < directions; ++d) {
        const double x = double(field.basis[std::size_t(d)]), y = double(truth.basis[std::size_t(d)]);
        product += x * y, a += x * x, b += y * y;
    }
    EXPECT_GT(product / std::sqrt(a * b), 0.999) << "the same direction";
}

TEST(Factorise, NothingButNoise) {
    Values values(8, std::vector<float>(3000));
    CounterRng rng(17, 0);
    for (auto& v : values) {
        for (float& x : v) {
            x = normal(rng);
        }
    }
    FactoriseOptions o;
    o.noiseGram.assign(64, 0.0);
    for (int d = 0; d < 8; ++d) {
        o.noiseGram[std::size_t(d * 9)] = 3000 * 1.0;
    }
    FactoriseReport report;
    const FactoredField field = factorise(values, 3, o, &report);
    EXPECT_TRUE(field.empty());
    EXPECT_TRUE(std::isfinite(report.truncation) && std::isfinite(report.noise));
}

TEST(Factorise, TheSameForAnyNumberOfThreads) {
    const Values values = ofRank(6, 11, 9000, 3, 0.5);
    std::vector<FactoredField> fields;
    for (int threads : {1, 2, 5}) {
        setThreadCount(threads);
        fields.push_back(factorise(values, 3, tolerance(0.001)));
    }
    setThreadCount(0);
    for (const FactoredField& f : fields) {
        EXPECT_TRUE(f.factors == fields[0].factors);
        EXPECT_TRUE(f.basis == fields[0].basis);
    }
}

TEST(Factorise, SignDoesNotDependOnTheField) {
    // The largest coefficient of each basis vector is positive.
    for (int rank : {1, 3}) {
        const FactoredField f = factorise(ofRank(rank, 7, 100, 3), 3, tolerance(0));
        for (int k = 0; k < f.rank; ++k) {
            float largest = 0;
            for (int d = 0; d < 7; ++d) {
                const float b = f.basis[std::size_t(d * f.rank + k)];
                largest = std::abs(b) > std::abs(largest) ? b : largest;
            }
            EXPECT_GT(largest, 0);
        }
    }
}

TEST(Factorise, FactorsFitHalfPrecisionAtAnyScale) {
    for (double scale : {1e-30, 1e-5, 1.0, 1e30}) {
        const Values values = ofRank(3, 6, 200, 12, 0.1, scale);
        const FactoredField f = factorise(values, 12, tolerance(1e-6));
        ASSERT_EQ(f.rank, 3);
        for (int k = 0; k < f.rank; ++k) {
            float largest = 0;
            for (std::size_t i = 0; i < f.items(); ++i) {
                for (int c = 0; c < 12; ++c) {
                    largest = std::max(largest, std::abs(f.factors[(i * 3 + std::size_t(k)) * 12 + std::size_t(c)]));
                }
            }
            EXPECT_GE(largest, 4095.9f);
            EXPECT_LE(largest, 8192.1f);
        }
        EXPECT_LT(rms(difference(f, values)), 1e-6 * rms(values)) << scale;
    }
}

TEST(Factorise, ZeroFieldsAndZeroColumns) {
    FactoriseReport report;
    const Values zero(4, std::vector<float>(30, 0.0f));
    const FactoredField none = factorise(zero, 3, {}, &report);
    EXPECT_TRUE(none.empty());
    EXPECT_EQ(none.items(), 0u);
    EXPECT_EQ(report.truncation, 0);
    FoldedLight light;
    light.clear(none);
    light.add(none, DirectionSet(2, 4), {0, 0, 1}, Rgb(1.0f), {0, 0, 1});
    EXPECT_TRUE(light.dark());
    EXPECT_EQ(none.at(5, light).fluence, Rgb(0.0f));
    EXPECT_EQ(none.rgb(5, DirectionSet(2, 4).weights({0, 0, 1})), Rgb(0.0f));
    EXPECT_EQ(none.node(5, 1, 2), 0);

    // Light directions without light, items without light, a component that is zero.
    Values values = ofRank(2, 5, 40, 3);
    std::fill(values[3].begin(), values[3].end(), 0.0f);
    for (auto& v : values) {
        v[0] = v[1] = v[2] = 0;
        for (std::size_t i = 1; i < v.size(); i += 3) {
            v[i] = 0;
        }
    }
    const FactoredField field = factorise(values, 3, tolerance(0));
    EXPECT_EQ(field.rank, 2);
    for (float x : field.factors) {
        ASSERT_TRUE(std::isfinite(x));
    }
    for (float x : field.basis) {
        ASSERT_TRUE(std::isfinite(x));
    }
    EXPECT_EQ(field.node(7, 3, 0), 0);
    EXPECT_EQ(field.node(0, 1, 0), 0);
    EXPECT_EQ(field.node(9, 2, 1), 0);

    EXPECT_TRUE(factorise({}, 3, {}).empty());
    EXPECT_TRUE(factorise({{}, {}}, 3, {}).empty());
    EXPECT_EQ(factorise({{1, 2, 3}}, 3, {}).rank, 1);
}

TEST(Factorise, RefusesWhatDoesNotFit) {
    EXPECT_THROW(factorise({{1, 2, 3}, {1, 2}}, 3, {}), Error);
    EXPECT_THROW(factorise({{1, 2, 3, 4}}, 3, {}), Error);
    EXPECT_THROW(factorise({{1, 2, std::nanf("")}}, 3, {}), Error);
    EXPECT_THROW(factorise({{1, 2, HUGE_VALF}}, 3, {}), Error);
    FactoriseOptions o;
    o.noiseGram = {1, 2};
    EXPECT_THROW(factorise({{1, 2, 3}}, 3, o), Error);
    o = {};
    o.weights = {1};
    EXPECT_THROW(factorise({{1, 2, 3}}, 3, o), Error);
}

// ---- lights

// A field with flux on a direction set, and what it holds at the nodes.
struct Lit {
    DirectionSet set;
    FactoredField field;
    explicit Lit(int azimuths, int components = 12)
        : set(5, azimuths), field(factorise(ofRank(4, set.count(), 60, components, 0.7), components, tolerance(0))) {}

    Vec3f flux(std::size_t item, int node, int channel) const {
        return {field.node(item, node, 3 + channel), field.node(item, node, 6 + channel),
                field.node(item, node, 9 + channel)};
    }
    // Straight from the nodes.
    FieldValue direct(std::size_t item, const Vec3f& light, const Rgb& irradiance, const Vec3f& viewer) const {
        FieldValue v;
        const DirectionWeights w = set.weights(light);
        for (int i = 0; i < w.count; ++i) {
            for (int c = 0; c < 3; ++c) {
                v.fluence[c] += irradiance[c] * w.weight[i] * field.node(item, w.index[i], c);
                if (!field.hasFlux()) {
                    continue;
                }
                Vec3f f = flux(item, w.index[i], c);
                if (set.azimuths() == 1) {
                    // Radial and tangential, in the half plane of the node: across the pole it points the other way.
                    const float r = std::hypot(light.x, light.y), side = i < w.count - w.across ? 1.0f : -1.0f;
                    const Vec3f radial = side * (r > 0 ? Vec3f(light.x / r, light.y / r, 0) : Vec3f(1, 0, 0));
                    const Vec3f tangential = cross(Vec3f(0, 0, 1), radial);
                    EXPECT_LT(length(cross(radial, tangential) - Vec3f(0, 0, 1)), 1e-6f);
                    f = radial * f.x + tangential * f.y + Vec3f(0, 0, 1) * f.z;
                }
                v.fluxAlong[c] += irradiance[c] * w.weight[i] * dot(f, viewer);
            }
        }
        return v;
    }
};

void expectNear(const Rgb& a, const Rgb& b, float tolerance) {
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(a[c], b[c], tolerance);
    }
}

const Vec3f kLights[] = {{0, 0, 1}, {0.3f, -0.2f, 0.9f}, {-0.6f, 0.1f, 0.4f}, {0.01f, 0.02f, 1}, {-0.1f, -0.9f, 0.05f}};
const Vec3f kViewers[] = {{0, 0, 1}, {0.5f, 0.4f, 0.7f}, {-0.9f, 0.1f, 0.1f}};

TEST(FoldedLight, IsTheFieldAtTheLightsDirection) {
    for (int azimuths : {1, 2, 6}) {
        for (int components : {3, 12}) {
            const Lit lit(azimuths, components);
            FoldedLight light;
            for (const Vec3f& l : kLights) {
                for (const Vec3f& v : kViewers) {
                    const Vec3f towards = normalize(l), viewer = normalize(v);
                    const Rgb irradiance(1, 2, 0.5f);
                    light.clear(lit.field);
                    light.add(lit.field, lit.set, towards, irradiance, viewer);
                    EXPECT_FALSE(light.dark());
                    for (std::size_t item : {std::size_t(0), std::size_t(33), std::size_t(59)}) {
                        const FieldValue expected = lit.direct(item, towards, irradiance, viewer);
                        const FieldValue got = lit.field.at(item, light);
                        expectNear(got.fluence, expected.fluence, 1e-5f);
                        expectNear(got.fluxAlong, expected.fluxAlong, 1e-5f);
                        EXPECT_TRUE(components == 12 || got.fluxAlong == Rgb(0.0f));
                        expectNear(lit.field.rgb(item, lit.set.weights(towards)) * irradiance, got.fluence, 1e-5f);
                    }
                }
            }
        }
    }
}

TEST(FoldedLight, TurnsWithTheLightWhereAzimuthIsAveraged) {
    const Lit lit(1);
    const float a = 0.7f, turn = 1.9f;
    const auto turned = [](float angle, float r, float z) {
        return Vec3f(r * std::cos(angle), r * std::sin(angle), z);
    };
    FoldedLight one, other;
    one.clear(lit.field);
    one.add(lit.field, lit.set, turned(a, 0.6f, 0.8f), Rgb(1.0f), turned(0.2f, 0.8f, 0.6f));
    other.clear(lit.field);
    other.add(lit.field, lit.set, turned(a + turn, 0.6f, 0.8f), Rgb(1.0f), turned(0.2f + turn, 0.8f, 0.6f));
    for (std::size_t i = 0; i < 60; ++i) {
        expectNear(lit.field.at(i, one).fluence, lit.field.at(i, other).fluence, 1e-5f);
        expectNear(lit.field.at(i, one).fluxAlong, lit.field.at(i, other).fluxAlong, 1e-5f);
    }
}

// The flux of light in a slab lies in the plane of incidence: radial odd over the pole, zero at it.
TEST(FoldedLight, RadialFluxIsSmoothOverThePole) {
    const DirectionSet set(7, 1);
    Values values;
    for (int d = 0; d < set.count(); ++d) {
        const float t = set.polarAngle(d);
        const float radial = -std::sin(t) * std::cos(t), down = -std::cos(t) * std::cos(t);
        values.push_back({1, 1, 1, radial, radial, radial, 0, 0, 0, down, down, down});
    }
    const FactoredField field = factorise(values, 12, tolerance(1e-6));
    for (float t = 0; t < 0.3f; t += 0.01f) {
        const Vec3f towards(std::sin(t) * std::cos(2.0f), std::sin(t) * std::sin(2.0f), std::cos(t));
        FoldedLight light;
        light.clear(field);
        light.add(field, set, towards, Rgb(1.0f), {std::cos(2.0f), std::sin(2.0f), 0});
        EXPECT_NEAR(field.at(0, light).fluxAlong.x, -std::sin(t) * std::cos(t), 5e-4f) << t;
    }
}

TEST(FoldedLight, ManyLightsAreTheSumOfSingleOnes) {
    for (int azimuths : {1, 6}) {
        const Lit lit(azimuths);
        FoldedLight all, one;
        all.clear(lit.field);
        std::vector<FieldValue> sum(60);
        float strength = 0.3f;
        const Vec3f viewer = normalize(Vec3f(0.2f, -0.5f, 0.9f));
        for (const Vec3f& l : kLights) {
            strength += 0.4f;
            const Rgb irradiance(strength, 1, 2 - strength);
            all.add(lit.field, lit.set, normalize(l), irradiance, viewer);
            one.clear(lit.field);
            one.add(lit.field, lit.set, normalize(l), irradiance, viewer);
            for (std::size_t i = 0; i < sum.size(); ++i) {
                sum[i].fluence += lit.field.at(i, one).fluence;
                sum[i].fluxAlong += lit.field.at(i, one).fluxAlong;
            }
        }
        for (std::size_t i = 0; i < sum.size(); ++i) {
            expectNear(lit.field.at(i, all).fluence, sum[i].fluence, 3e-5f);
            expectNear(lit.field.at(i, all).fluxAlong, sum[i].fluxAlong, 3e-5f);
        }
    }
}

TEST(FoldedLight, DarkUntilLightArrives) {
    const Lit lit(6);
    FoldedLight light;
    EXPECT_TRUE(light.dark());
    EXPECT_EQ(lit.field.at(3, light).fluence, Rgb(0.0f)) << "never cleared";
    light.clear(lit.field);
    light.add(lit.field, lit.set, {0, 0, -1}, Rgb(1.0f), {0, 0, 1});
    light.add(lit.field, lit.set, {0, 0, 1}, Rgb(0.0f), {0, 0, 1});
    EXPECT_TRUE(light.dark());
    EXPECT_EQ(lit.field.at(3, light).fluence, Rgb(0.0f));
    light.add(lit.field, lit.set, {0, 0, 1}, Rgb(0, 1, 0), {0, 0, 1});
    EXPECT_FALSE(light.dark());
    EXPECT_EQ(lit.field.at(3, light).fluence.x, 0);
    EXPECT_NE(lit.field.at(3, light).fluence.y, 0);
    light.clear(lit.field);
    EXPECT_TRUE(light.dark());
}

TEST(FactoredField, SingleHasNoLightDirections) {
    std::vector<float> values(24);
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = float(i);
    }
    const FactoredField f = FactoredField::single(values, 12);
    EXPECT_EQ(f.rank, 1);
    EXPECT_EQ(f.directions, 1);
    EXPECT_EQ(f.items(), 2u);
    EXPECT_EQ(f.node(1, 0, 3), 15);
    FoldedLight light;
    light.clear(f);
    light.add(f, DirectionSet(1, 1), {0, 0, 1}, Rgb(1.0f), {0.5f, 0.25f, 2}); // any vector: the flux is linear in it
    EXPECT_EQ(f.at(1, light).fluence, Rgb(12, 13, 14));
    EXPECT_EQ(f.at(1, light).fluxAlong.x, 15 * 0.5f + 18 * 0.25f + 21 * 2);
    EXPECT_TRUE(FactoredField::single({}, 3).empty());
}

} // namespace
