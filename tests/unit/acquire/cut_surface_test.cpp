// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/cut_surface.h"

#include "stfLib/base/random.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <queue>

using namespace stf;

namespace {

// Differences of smooth random pictures.
OverlapCost randomCost(int overlap, int length, int layers, bool circle, std::uint64_t seed) {
    OverlapCost c{overlap, length, layers, circle, {}};
    CounterRng rng(seed, 0);
    double k[6][4];
    for (auto& wave : k) {
        wave[0] = 2 * rng.uniform() - 1;
        wave[1] = circle ? std::floor(4 * rng.uniform()) * 2 * M_PI / length : rng.uniform() - 0.5;
        wave[2] = rng.uniform() - 0.5;
        wave[3] = 6.28 * rng.uniform();
    }
    c.difference.resize(std::size_t(overlap) * std::size_t(length) * std::size_t(layers));
    for (int z = 0; z < layers; ++z) {
        for (int y = 0; y < length; ++y) {
            for (int x = 0; x < overlap; ++x) {
                double sum = 0;
                for (const auto& wave : k) {
                    sum += std::sin(wave[0] * x + wave[1] * y + wave[2] * z + wave[3]);
                }
                c.difference[c.index(x, y, z)] = float(std::max(0.01, std::abs(sum)));
            }
        }
    }
    return c;
}

// Maximum flow by shortest augmenting paths in levels (Dinic 1970).
class FlowNetwork {
public:
    explicit FlowNetwork(std::size_t nodes) : edges_(nodes), level_(nodes), next_(nodes) {}
    void join(std::size_t a, std::size_t b, double forth, double back) {
        edges_[a].push_back({b, edges_[b].size(), forth});
        edges_[b].push_back({a, edges_[a].size() - 1, back});
    }
    double flow(std::size_t source, std::size_t sink) {
        double total = 0;
        while (findLevels(source, sink)) {
            std::fill(next_.begin(), next_.end(), 0);
            for (double f = push(source, sink, 1e300); f > 0; f = push(source, sink, 1e300)) {
                total += f;
            }
        }
        return total;
    }

private:
    struct Edge {
        std::size_t to, reverse;
        double capacity;
    };
    static constexpr double kNone = 1e-9;
    bool findLevels(std::size_t source, std::size_t sink) {
        std::fill(level_.begin(), level_.end(), -1);
        level_[source] = 0;
        std::queue<std::size_t> queue;
        queue.push(source);
        for (; !queue.empty(); queue.pop()) {
            for (const Edge& e : edges_[queue.front()]) {
                if (e.capacity > kNone && level_[e.to] < 0) {
                    level_[e.to] = level_[queue.front()] + 1;
                    queue.push(e.to);
                }
            }
        }
        return level_[sink] >= 0;
    }
    double push(std::size_t node, std::size_t sink, double most) {
        if (node == sink) {
            return most;
        }
        for (std::size_t& i = next_[node]; i < edges_[node].size(); ++i) {
            Edge& e = edges_[node][i];
            if (e.capacity > kNone && level_[e.to] == level_[node] + 1) {
                const double f = push(e.to, sink, std::min(most, e.capacity));
                if (f > 0) {
                    e.capacity -= f;
                    edges_[e.to][e.reverse].capacity += f;
                    return f;
                }
            }
        }
        return 0;
    }
    std::vector<std::vector<Edge>> edges_;
    std::vector<int> level_;
    std::vector<std::size_t> next_;
};

// The least cost of any cut, connected or not, by maximum flow: a bound from below that shares nothing with the search.
double minimumCut(const OverlapCost& c) {
    const std::size_t n = c.difference.size();
    FlowNetwork g(n + 2);
    for (int z = 0; z < c.layers; ++z) {
        for (int y = 0; y < c.length; ++y) {
            for (int x = 0; x < c.overlap; ++x) {
                const std::size_t a = c.index(x, y, z);
                const auto neighbour = [&](std::size_t b) {
                    const double w = double(c.difference[a]) + double(c.difference[b]);
                    g.join(a, b, w, w);
                };
                if (x + 1 < c.overlap) {
                    neighbour(c.index(x + 1, y, z));
                }
                if (y + 1 < c.length || c.circle) {
                    neighbour(c.index(x, (y + 1) % c.length, z));
                }
                if (z + 1 < c.layers) {
                    neighbour(c.index(x, y, z + 1));
                }
                if (x == 0) {
                    g.join(n, a, 1e9, 0);
                }
                if (x == c.overlap - 1) {
                    g.join(a, n + 1, 1e9, 0);
                }
            }
        }
    }
    return g.flow(n, n + 1);
}

// The cost of a cut from its definition: all faces between voxels of the two pictures.
double costOf(const OverlapCost& c, const std::vector<int>& cut) {
    const auto first = [&](int x, int y, int z) {
        return x < cut[std::size_t(y) + std::size_t(c.length) * std::size_t(z)];
    };
    double sum = 0;
    for (int z = 0; z < c.layers; ++z) {
        for (int y = 0; y < c.length; ++y) {
            for (int x = 0; x < c.overlap; ++x) {
                const auto face = [&](int i, int j, int k) {
                    if (first(x, y, z) != first(i, j, k)) {
                        sum += double(c.difference[c.index(x, y, z)]) + double(c.difference[c.index(i, j, k)]);
                    }
                };
                if (x + 1 < c.overlap) {
                    face(x + 1, y, z);
                }
                if (y + 1 < c.length || c.circle) {
                    face(x, (y + 1) % c.length, z);
                }
                if (z + 1 < c.layers) {
                    face(x, y, z + 1);
                }
            }
        }
    }
    return sum;
}

double bestFlat(const OverlapCost& c) {
    double best = 1e300;
    for (int x = 1; x < c.overlap; ++x) {
        best = std::min(best, costOf(c, std::vector<int>(std::size_t(c.length) * std::size_t(c.layers), x)));
    }
    return best;
}

TEST(CutSurface, CostsWhatItSays) {
    Progress progress;
    for (const bool circle : {false, true}) {
        const OverlapCost c = randomCost(9, 14, 5, circle, 3);
        const CutSurface s = cutOverlap(c, progress);
        EXPECT_NEAR(s.cost, costOf(c, s.cut), 1e-4 * s.cost);
        for (const int x : s.cut) {
            EXPECT_GE(x, 1);
            EXPECT_LT(x, 9);
        }
    }
}

// One layer of heights: the minimum over all heights, by trying all of them.
TEST(CutSurface, ExactForOneLayer) {
    Progress progress;
    const OverlapCost c = randomCost(5, 6, 1, false, 11);
    std::vector<int> cut(6, 1);
    double best = 1e300;
    for (int code = 0; code < 4096; ++code) {
        for (int y = 0, rest = code; y < 6; ++y, rest /= 4) {
            cut[std::size_t(y)] = 1 + rest % 4;
        }
        best = std::min(best, costOf(c, cut));
    }
    EXPECT_NEAR(cutOverlap(c, progress).cost, best, 1e-5 * best);
}

TEST(CutSurface, NearTheMinimumCut) {
    Progress progress;
    double worst = 0, mean = 0, flat = 0;
    int count = 0;
    for (const bool circle : {false, true}) {
        for (std::uint64_t seed = 0; seed < 8; ++seed) {
            const OverlapCost c = randomCost(12, 24, 16, circle, seed);
            const double found = cutOverlap(c, progress).cost, least = minimumCut(c);
            EXPECT_GE(found, least * (1 - 1e-6));
            worst = std::max(worst, found / least);
            mean += found / least;
            flat += bestFlat(c) / least;
            ++count;
        }
    }
    mean /= count;
    flat /= count;
    std::printf("             %.3f times the minimum cut on average, at most %.3f; flat cuts %.3f\n", mean, worst,
                flat);
    EXPECT_LE(worst, 1.25);
    EXPECT_LE(mean - 1, 0.6 * (flat - 1));
}

TEST(CutSurface, FindsAHiddenSeam) {
    // No difference along a wavy sheet, one everywhere else: the cut follows it.
    OverlapCost c{16, 40, 12, true, {}};
    const auto sheet = [](int y, int z) {
        return 8 + int(std::lround(5 * std::sin(2 * M_PI * y / 40.0) + z / 4.0 - 1));
    };
    for (int z = 0; z < 12; ++z) {
        for (int y = 0; y < 40; ++y) {
            for (int x = 0; x < 16; ++x) {
                c.difference.push_back(std::abs(x - sheet(y, z)) <= 1 ? 0.0f : 1.0f);
            }
        }
    }
    Progress progress;
    const CutSurface s = cutOverlap(c, progress);
    EXPECT_EQ(s.cost, 0);
}

TEST(CutSurface, RefusesAnOverlapOfOne) {
    Progress progress;
    EXPECT_THROW(cutOverlap(randomCost(1, 4, 4, false, 1), progress), Error);
    Progress cancelled;
    cancelled.cancel();
    EXPECT_THROW(cutOverlap(randomCost(4, 4, 4, false, 1), cancelled), Cancelled);
}

} // namespace
