// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/direction_choice.h"

#include "stfLib/transport/group_statistics.h"

#include <algorithm>
#include <array>
#include <map>

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
constexpr int kPolars[] = {4, 5, 6, 8, 10, 13, 17, 22, 30};
constexpr int kAzimuths[] = {4, 8, 16, 32};
// Where azimuths are tested: oblique enough for shadows, and still much light.
constexpr float kRing = 55 * kPi / 180;
constexpr std::uint64_t kPilot = 1ull << 40; // numbers of pilot sources, apart from those of the table

using Groups = std::vector<std::vector<float>>;

WalkSource source(float theta, float phi, bool anyAzimuth) {
    WalkSource s;
    s.kind = anyAzimuth ? WalkSource::Kind::AnyAzimuth : WalkSource::Kind::Direction;
    s.towardsLight = {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
    return s;
}

// Fluence per perpendicular irradiance, up to a constant, averaged over blocks of voxels, of every group.
Groups blocks(const TileMedium& m, const std::vector<GroupResult>& results, int components, float cosine,
              const Vec3i& block) {
    const Vec3i& size = m.size();
    const Vec3i count{(size.x + block.x - 1) / block.x, (size.y + block.y - 1) / block.y,
                      (size.z + block.z - 1) / block.z};
    Groups out;
    for (const GroupResult& r : results) {
        std::vector<float> sum(std::size_t(count.x) * std::size_t(count.y) * std::size_t(count.z) * 3, 0.0f);
        std::size_t i = 0;
        for (int z = 0; z < size.z; ++z) {
            for (int y = 0; y < size.y; ++y) {
                for (int x = 0; x < size.x; ++x, ++i) {
                    const std::size_t b = std::size_t(x / block.x) +
                                          std::size_t(count.x) * (std::size_t(y / block.y) +
                                                                  std::size_t(count.y) * std::size_t(z / block.z));
                    for (std::size_t c = 0; c < 3; ++c) {
                        sum[b * 3 + c] += r.field[i * std::size_t(components) + c] * m.fill(i) * cosine;
                    }
                }
            }
        }
        out.push_back(std::move(sum));
    }
    return out;
}

// a - sum of w_i n_i, group by group.
Groups difference(Groups a, const std::vector<std::pair<const Groups*, float>>& terms) {
    for (std::size_t g = 0; g < a.size(); ++g) {
        for (const auto& [values, weight] : terms) {
            for (std::size_t i = 0; i < a[g].size(); ++i) {
                a[g][i] -= weight * (*values)[g][i];
            }
        }
    }
    return a;
}

class Pilots {
public:
    Pilots(const TileMedium& m, WalkGroups& walks, std::uint64_t photons)
        : medium_(m), walks_(walks), photons_(photons) {}

    std::vector<Groups> fields(const std::vector<WalkSource>& sources, const Vec3i& block) {
        std::vector<WalkJob> jobs;
        for (const WalkSource& s : sources) {
            jobs.push_back({s, kPilot + next_++, 0, photons_});
        }
        std::vector<Groups> out;
        walks_.run(jobs, false, [&](std::size_t job, const std::vector<GroupResult>& results) {
            out.push_back(blocks(medium_, results, walks_.components(), sources[job].towardsLight.z, block));
        });
        return out;
    }

private:
    const TileMedium& medium_;
    WalkGroups& walks_;
    std::uint64_t photons_, next_ = 0;
};

// Squared relative error of a number of polar nodes.
double polarError(Pilots& pilots, const DirectionSet& set, const Vec3i& block) {
    const int n = set.polars();
    const float step = 0.5f * kPi / float(n);
    std::vector<WalkSource> sources;
    for (int i = 0; i < n; ++i) {
        sources.push_back(source(float(i) * step, 0, true));
    }
    // The last two gaps, where light grazes, and one in the middle that stands for the others.
    const int gaps[] = {n - 1, n - 2, (n - 2) / 2};
    for (const int gap : gaps) {
        sources.push_back(source((float(gap) + 0.5f) * step, 0, true));
    }
    const std::vector<Groups> f = pilots.fields(sources, block);
    double signal = 0;
    for (int i = 0; i < n; ++i) {
        signal += commonSquare(f[std::size_t(i)]) / n;
    }
    double error = 0;
    for (int k = 0; k < 3; ++k) {
        std::vector<std::pair<const Groups*, float>> terms;
        const DirectionWeights w = set.weights(sources[std::size_t(n + k)].towardsLight);
        for (int i = 0; i < w.count; ++i) {
            terms.emplace_back(&f[std::size_t(w.index[i])], w.weight[i]);
        }
        const double share = k < 2 ? 1.0 : double(n - 2);
        error += share / n * commonSquare(difference(f[std::size_t(n + k)], terms));
    }
    return signal > 0 ? std::max(0.0, error / signal) : 0.0;
}

// Walks around one ring, each direction once.
class Ring {
public:
    Ring(Pilots& pilots, const Vec3i& block) : pilots_(pilots), block_(block) {}

    /// Squared relative error of a number of azimuths; 1: the average over them.
    double error(int azimuths) {
        const int steps = 64; // directions are named by 64ths of the circle
        if (azimuths == 1) {
            const std::vector<Groups> any = pilots_.fields({source(kRing, 0, true)}, block_);
            need({0, steps / 4});
            double sum = 0;
            for (const int a : {0, steps / 4}) {
                sum += 0.5 * commonSquare(difference(at_[a], {{&any[0], 1.0f}}));
            }
            const double signal = commonSquare(any[0]);
            return signal > 0 ? std::max(0.0, sum / signal) : 0.0;
        }
        const int gap = steps / azimuths;
        std::vector<int> nodes;
        for (int a = 0; a < azimuths; ++a) {
            nodes.push_back(a * gap);
        }
        const int tests[] = {gap / 2, (gap / 2 + steps / 2 + gap * (azimuths / 8)) % steps};
        std::vector<int> all = nodes;
        all.insert(all.end(), std::begin(tests), std::end(tests));
        need(all);
        double sum = 0, signal = 0;
        for (const int t : tests) {
            const auto node = [&](int k) { return &at_[((t - gap / 2 + k * gap) % steps + steps) % steps]; };
            // Lagrange's cubic in the middle of four.
            sum +=
                0.5 * commonSquare(difference(
                          at_[t],
                          {{node(-1), -1 / 16.0f}, {node(0), 9 / 16.0f}, {node(1), 9 / 16.0f}, {node(2), -1 / 16.0f}}));
            signal += 0.5 * commonSquare(at_[t]);
        }
        return signal > 0 ? std::max(0.0, sum / signal) : 0.0;
    }

private:
    void need(const std::vector<int>& directions) {
        std::vector<WalkSource> sources;
        std::vector<int> missing;
        for (const int a : directions) {
            if (!at_.count(a) && std::find(missing.begin(), missing.end(), a) == missing.end()) {
                sources.push_back(source(kRing, 2 * kPi * float(a) / 64, false));
                missing.push_back(a);
            }
        }
        std::vector<Groups> f = pilots_.fields(sources, block_);
        for (std::size_t i = 0; i < f.size(); ++i) {
            at_[missing[i]] = std::move(f[i]);
        }
    }
    Pilots& pilots_;
    Vec3i block_;
    std::map<int, Groups> at_;
};

} // namespace

WalkSource sourceOf(const DirectionSet& set, int node) {
    WalkSource s;
    s.kind = set.azimuths() == 1 ? WalkSource::Kind::AnyAzimuth : WalkSource::Kind::Direction;
    s.towardsLight = set.direction(node);
    return s;
}

DirectionChoice chooseDirections(const TileMedium& medium, WalkGroups& walks, double tolerance, int polars,
                                 int azimuths, std::uint64_t photons) {
    Pilots pilots(medium, walks, photons);
    const Vec3i& size = medium.size();
    const bool oneColumn = size.x == 1 && size.y == 1;
    const double squared = tolerance * tolerance;

    double azimuthError = 0;
    int a = 1;
    if (!oneColumn) {
        Ring ring(pilots, {2, 2, 2});
        a = azimuths > 0 ? azimuths : 1;
        // Half of the tolerance's square for each of the two.
        azimuthError = azimuths > 1 && 64 % azimuths != 0 ? 0.0 : ring.error(a);
        for (const int candidate : kAzimuths) {
            if (azimuths > 0 || azimuthError <= 0.5 * squared) {
                break;
            }
            a = candidate;
            azimuthError = ring.error(a);
        }
    }

    double error = 0;
    int p = polars;
    if (polars > 0) {
        error = polars >= 3 ? polarError(pilots, DirectionSet(p, 1, medium.topIor()), {size.x, size.y, 1}) : 0.0;
    } else {
        for (const int candidate : kPolars) {
            p = candidate;
            error = polarError(pilots, DirectionSet(p, 1, medium.topIor()), {size.x, size.y, 1});
            if (error <= 0.5 * squared) {
                break;
            }
        }
    }
    return {DirectionSet(p, a, medium.topIor()), std::sqrt(error + azimuthError)};
}

} // namespace stf
