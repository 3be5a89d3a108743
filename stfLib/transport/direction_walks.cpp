// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/direction_walks.h"

#include "stfLib/base/parallel.h"
#include "stfLib/transport/direction_choice.h"
#include "stfLib/transport/group_statistics.h"
#include "stfLib/transport/read_noise.h"

namespace stf {

namespace {

constexpr double kTruncationShare = 0.1; // of the wanted error
// Noise differs from column to column, but what a dropped factor lacks has one sign over whole regions: where there are
// many columns a factor is worth more of it.
constexpr double kLeastCoherence = 0.25;
constexpr int kMaxRounds = 6;

double sq(double x) {
    return x * x;
}

void addPhotons(TileWalks& c, const DirectionSet& set, const std::vector<std::uint64_t>& wanted,
                std::vector<DirectionLight>& d) {
    std::vector<WalkJob> jobs;
    std::vector<std::size_t> of;
    for (std::size_t i = 0; i < d.size(); ++i) {
        const std::uint64_t g = std::uint64_t(c.walks.groups()), photons = (wanted[i] + g - 1) / g * g;
        if (photons > 0) {
            jobs.push_back({sourceOf(set, int(i)), i, d[i].photons, photons});
            of.push_back(i);
        }
    }
    const bool keepsSingle = c.medium.refracts() && c.medium.hasSurface();
    c.walks.run(jobs, keepsSingle, [&](std::size_t job, const std::vector<GroupResult>& r) {
        DirectionLight& x = d[of[job]];
        const double mu = double(jobs[job].source.towardsLight.z), flux = mu * c.tileArea;
        const double photons = double(jobs[job].photons), before = double(x.photons), after = before + photons;
        const ReadGroups read = readGroups(c.medium, r, c.walks.components(), c.filter);
        // The mean of all rounds, weighted by photons.
        x.noise = x.noise * sq(before / after) + noiseSquare(read.read) * sq(flux * photons / after);
        x.voxelNoise = x.voxelNoise * sq(before / after) + noiseSquare(read.voxels) * sq(flux * photons / after);
        x.photons += jobs[job].photons;
        x.perPhoton = x.noise * after;
        for (int h = 0; h < 2; ++h) {
            c.mean(x.half[h], r, &GroupResult::field, float(flux), float(before / after), float(photons / after),
                   h * c.walks.groups() / 2, (h + 1) * c.walks.groups() / 2);
        }
        if (keepsSingle) {
            c.mean(x.uncollided, r, &GroupResult::uncollided, float(flux), float(before / after),
                   float(photons / after));
        }
        x.below.resize(c.columns * 3);
        x.belowUncollided.resize(c.columns * 3);
        for (const GroupResult& g : r) {
            x.above += g.totals.above;
            for (std::size_t k = 0; k < c.columns * 3; ++k) {
                x.below[k] += g.totals.below[k];
                x.belowUncollided[k] += g.totals.belowUncollided[k];
            }
        }
    });
}

// Rms noise of the mean of the halves, relative to its rms: half of what they differ by, at a rank.
double halvesDiffer(const TileWalks& c, const std::vector<DirectionLight>& d, int rank) {
    const std::size_t voxels = c.medium.voxelCount(), n = std::size_t(c.walks.components());
    FactoredField half[2];
    for (int h = 0; h < 2; ++h) {
        std::vector<std::vector<float>> fluence(d.size(), std::vector<float>(voxels * 3));
        parallelFor(d.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                for (std::size_t k = 0; k < voxels * 3; ++k) {
                    fluence[i][k] = d[i].half[h][k / 3 * n + k % 3];
                }
                c.filter.apply(fluence[i], 3, c.fill);
            }
        });
        FactoriseOptions options;
        options.tolerance = 0;
        options.maxRank = rank;
        half[h] = factorise(fluence, 3, options);
    }
    constexpr std::size_t kGrain = 4096;
    std::vector<Vec2d> sums((voxels + kGrain - 1) / kGrain);
    parallelFor(voxels, kGrain, [&](std::size_t begin, std::size_t end) {
        Vec2d& sum = sums[begin / kGrain];
        for (std::size_t i = begin; i < end; ++i) {
            for (int k = 0; k < int(d.size()) * 3; ++k) {
                const double a = double(half[0].node(i, k / 3, k % 3)), b = double(half[1].node(i, k / 3, k % 3));
                sum = sum + Vec2d{(a - b) * (a - b), (a + b) * (a + b)};
            }
        }
    });
    Vec2d all;
    for (const Vec2d& s : sums) {
        all = all + s;
    }
    return all.y > 0 ? std::sqrt(all.x / all.y) : 0.0;
}

// Filtered and factored. The norm weighs flux as the source does on the average over directions: 3 g'^2 |F|^2.
FactoredField factoriseFields(const TileWalks& c, const std::vector<DirectionLight>& d, FactoriseOptions options,
                              FactoriseReport& report) {
    const int n = c.walks.components();
    std::vector<std::vector<float>> values(d.size());
    parallelFor(d.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            values[i] = d[i].half[0];
            for (std::size_t k = 0; k < values[i].size(); ++k) {
                values[i][k] = 0.5f * (values[i][k] + d[i].half[1][k]);
            }
            c.finish(values[i], n);
        }
    });
    double gain = 1, readNoise = 0, voxelNoise = 0;
    if (n == 12) {
        options.weights.assign(c.medium.voxelCount() * 12, 1.0f);
        double g2 = 0;
        for (std::size_t i = 0; i < c.medium.voxelCount(); ++i) {
            const float g = c.medium.voxel(i).gScaled;
            g2 += double(g) * double(g);
            for (std::size_t k = 3; k < 12; ++k) {
                options.weights[i * 12 + k] = 3 * g * g; // of the squares
            }
        }
        // Tracks of all directions: the three components of a flux together vary as the fluence does.
        gain += 3 * g2 / double(c.medium.voxelCount());
    }
    options.noiseGram.assign(d.size() * d.size(), 0.0);
    for (std::size_t i = 0; i < d.size(); ++i) {
        // Summed over items, as the Gram matrix is.
        options.noiseGram[i * d.size() + i] = d[i].voxelNoise * gain * 3 * double(c.medium.voxelCount());
        readNoise += d[i].noise;
        voxelNoise += d[i].voxelNoise;
    }
    const double coherence = std::max(kLeastCoherence, 1 / std::sqrt(double(c.columns)));
    options.noiseRead = voxelNoise > 0 ? coherence * std::min(1.0, readNoise / voxelNoise) : 1.0;
    FactoredField field = factorise(values, n, options, &report);
    // Noise that has the shape of the field itself passes the truncation: it is seen where both halves are factored
    // for themselves. That of what is read is less.
    report.noise = field.empty() || !(voxelNoise > 0)
                       ? 0.0
                       : halvesDiffer(c, d, field.rank) * std::sqrt(gain * readNoise / voxelNoise);
    return field;
}

} // namespace

std::vector<DirectionLight> walkDirections(TileWalks& c, StfTable& t) {
    const int n = t.directions.count();
    std::vector<DirectionLight> d(static_cast<std::size_t>(n));
    std::vector<std::uint64_t> wanted(std::size_t(n),
                                      c.columns == 1 ? 2400 : std::max<std::uint64_t>(8000, c.columns * 2));
    c.walks.expect(c.walks.photons() + 4 * double(n) * double(wanted[0]));
    FactoriseReport report;
    FactoriseOptions options;
    options.tolerance = kTruncationShare * double(c.options.quality) / c.weight;
    FactoredField field;
    for (int round = 0; round < kMaxRounds; ++round) {
        addPhotons(c, t.directions, wanted, d);
        field = factoriseFields(c, d, options, report);
        // Where nothing but noise was found, that is what is left.
        report.noise = (field.empty() ? 1.0 : report.noise) * c.weight;
        report.truncation *= c.weight;
        // Directions and filter stay as they are; noise, and what drowns in it and is dropped, fall with photons.
        const double fixed = sq(t.error.directions) + sq(t.error.filter);
        const double target = std::max(0.25, 1 - fixed / sq(c.options.quality)) * sq(c.options.quality);
        const double noise = sq(report.noise) + sq(report.truncation);
        t.error.noise = report.noise;
        t.error.truncation = report.truncation;
        const double spent = c.walks.photons(), left = double(c.options.maxPhotons) - spent;
        if (noise <= target || left < double(n) * c.walks.groups() || round + 1 == kMaxRounds) {
            break;
        }
        // Photons in proportion to what a photon varies by (Neyman 1934: the least work for the summed variance).
        const double factor = std::min(12.0, 1.15 * noise / target);
        double total = 0, spread = 0;
        for (const DirectionLight& x : d) {
            total += double(x.photons);
            spread += std::sqrt(x.perPhoton);
        }
        const double more = std::min(left, total * factor - total);
        for (std::size_t i = 0; i < d.size(); ++i) {
            const double aim = (total + more) * std::sqrt(d[i].perPhoton) / std::max(spread, 1e-300);
            wanted[i] = aim > double(d[i].photons) ? std::uint64_t(aim - double(d[i].photons)) : 0;
        }
        c.walks.expect(spent + more);
    }
    t.multiple = std::move(field);
    if (c.medium.refracts() && c.medium.hasSurface()) {
        std::vector<std::vector<float>> single;
        for (DirectionLight& x : d) {
            c.finish(x.uncollided, c.walks.components()); // slivers and voids beside the surface are read, too
            single.push_back(std::move(x.uncollided));
        }
        t.single = factorise(single, c.walks.components(), options);
    }
    return d;
}

} // namespace stf
