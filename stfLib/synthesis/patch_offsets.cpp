// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/patch_offsets.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"
#include "stfLib/synthesis/patch_labels.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stf {

namespace {

constexpr int kMembers = 2400;     ///< of a chart that are looked at
constexpr int kCoarseSamples = 96; ///< of its overlap, in the first comparison
constexpr int kFineSamples = 800;  ///< and in the second
constexpr int kJumpSamples = 40;   ///< whose texels alike become candidates
constexpr int kRandomCandidates = 48;
constexpr int kFinalists = 24;
constexpr int kBins = 16;                  ///< of the usage map, along each axis
constexpr int kBells = 32;                 ///< of the map of what is shown nearby: places along each axis
constexpr std::size_t kQuantiles = 16;     ///< of a parameter's distribution
constexpr std::size_t kBudgetSamples = 40; ///< of a chart, for what it adds to distributions
constexpr double kWantedKs = 0.03;         ///< what the surface's distributions may be off
constexpr double kWantedDeltaR = 0.01;
constexpr float kNoticed = 0.02f; ///< of an ordinary chart's area: what shows less is not seen to repeat
constexpr float kCap = 8;         ///< a mismatch counts at most this many times the sample's own: then it is a break
constexpr double kVisible = 2.5;  ///< steps of lightness, over a neighbourhood
constexpr float kRival = 0.12f;   ///< of remoteness: where two charts may meet

/// A place where a chart overlaps another that has chosen.
struct Constraint {
    Vec2f own;    ///< coordinate in the chart, mm
    Vec2f wanted; ///< what is shown there, mm
    float weight;
    int other;
};

struct Candidate {
    Vec2f offset;
    float cost = 0;
};

class Chooser {
public:
    Chooser(const SurfaceGraph& g, const ChartCover& cover, const Exemplar& ex, double mmPerUnit,
            const OffsetOptions& options)
        : g_(g), cover_(cover), ex_(ex), options_(options), mmPerUnit_(mmPerUnit), offset_(cover.charts.size()),
          chosen_(cover.charts.size(), 0), core_(cover.charts.size()), usage_(std::size_t(kBins * kBins), 0.0f) {
        tile_ = {float(ex.tileMm().x), float(ex.tileMm().y)};
        // Of a sample without places that are alike every seam is seen: its own error is no measure then. Where it is
        // zero (a sample that repeats itself), a hundredth of a step of lightness is a mismatch.
        const double own = std::min(ex.ownError, kVisible);
        own2_ = float(std::max(own * own, 1e-4));
        // And where every seam is seen, repetition is the lesser evil.
        variety_ = float(std::pow(kVisible / std::max(ex.ownError, kVisible), 8));
        findCores();
        sortParameters();
    }

    std::vector<Vec2f> run(Progress& progress) {
        const std::vector<int> order = growthOrder();
        const std::size_t total = order.size() * std::size_t(1 + options_.sweeps);
        std::size_t done = 0;
        for (int sweep = 0; sweep <= options_.sweeps; ++sweep) {
            for (int c : order) {
                if (chosen_[std::size_t(c)]) {
                    use(c, -1);
                }
                offset_[std::size_t(c)] = choose(c, sweep);
                chosen_[std::size_t(c)] = 1;
                use(c, 1);
                if (++done % 16 == 0) {
                    progress.update("patches", double(done) / double(total));
                }
            }
        }
        return offset_;
    }

private:
    /// Members that are nearer to this chart's middle than to any other's: about what it will show.
    void findCores() {
        for (std::size_t v = 0; v < g_.size(); ++v) {
            int best = cover_.first[v];
            for (int e = best + 1; e < cover_.first[v + 1]; ++e) {
                best = cover_.remoteness[std::size_t(e)] < cover_.remoteness[std::size_t(best)] ? e : best;
            }
            core_[std::size_t(cover_.chart[std::size_t(best)])].push_back(best);
        }
        for (std::vector<int>& c : core_) {
            // Thinned evenly: the usage map is coarse.
            const std::size_t stride = c.size() / 600 + 1;
            coreWeight_.push_back(float(stride));
            std::size_t n = 0;
            for (std::size_t i = 0; i < c.size(); i += stride) {
                c[n++] = c[i];
            }
            c.resize(n);
        }
        // The charts that show most set what is ordinary.
        std::vector<float> area;
        for (std::size_t c = 0; c < core_.size(); ++c) {
            area.push_back(coreWeight_[c] * float(core_[c].size()));
        }
        weight_ = area;
        std::sort(area.begin(), area.end(), std::greater<>());
        double sum = 0, total = std::accumulate(area.begin(), area.end(), 0.0), ordinary = 1;
        for (float a : area) {
            sum += double(a);
            ordinary = double(a);
            if (sum >= 0.5 * total) {
                break;
            }
        }
        for (float& w : weight_) {
            w = float(std::min(1.0, double(w) / std::max(1.0, ordinary)));
        }
    }

    template<class Body>
    void forMembers(int c, const Body& body) const {
        const ChartCover::Chart& chart = cover_.charts[std::size_t(c)];
        // A stride without common structure with the order of growth.
        const int stride = chart.count / kMembers + 1;
        for (int i = 0; i < chart.count; i += stride) {
            body(cover_.member[std::size_t(chart.first + i)], cover_.entryOfMember[std::size_t(chart.first + i)]);
        }
    }

    /// Every chart after those with which it overlaps most.
    std::vector<int> growthOrder() const {
        const std::size_t n = cover_.charts.size();
        std::vector<std::vector<std::pair<int, float>>> overlap(n);
        parallelFor(n, 8, [&](std::size_t begin, std::size_t end) {
            std::vector<float> shared(n, 0.0f);
            std::vector<int> met;
            for (std::size_t c = begin; c < end; ++c) {
                forMembers(int(c), [&](int v, int) {
                    for (int e = cover_.first[std::size_t(v)]; e < cover_.first[std::size_t(v) + 1]; ++e) {
                        const std::size_t o = std::size_t(cover_.chart[std::size_t(e)]);
                        if (o != c) {
                            if (shared[o] == 0) {
                                met.push_back(int(o));
                            }
                            shared[o] += 1;
                        }
                    }
                });
                std::sort(met.begin(), met.end());
                for (int o : met) {
                    overlap[c].push_back({o, shared[std::size_t(o)]});
                    shared[std::size_t(o)] = 0;
                }
                met.clear();
            }
        });
        std::vector<float> gain(n, 0.0f);
        std::vector<char> taken(n, 0);
        // Largest gain first; a heap with stale entries.
        using Item = std::tuple<float, int, int>; // gain, size, -number
        std::vector<Item> heap;
        const auto push = [&](std::size_t c) {
            heap.push_back({gain[c], cover_.charts[c].count, -int(c)});
            std::push_heap(heap.begin(), heap.end());
        };
        for (std::size_t c = 0; c < n; ++c) {
            push(c);
        }
        std::vector<int> order;
        while (!heap.empty()) {
            std::pop_heap(heap.begin(), heap.end());
            const std::size_t c = std::size_t(-std::get<2>(heap.back()));
            const float had = std::get<0>(heap.back());
            heap.pop_back();
            if (taken[c] || had != gain[c]) {
                continue;
            }
            taken[c] = 1;
            order.push_back(int(c));
            for (const auto& [o, shared] : overlap[c]) {
                if (!taken[std::size_t(o)]) {
                    gain[std::size_t(o)] += shared;
                    push(std::size_t(o));
                }
            }
        }
        return order;
    }

    std::size_t bin(const Vec2f& mm) const {
        const float u = mm.x / tile_.x, v = mm.y / tile_.y;
        const int x = int((u - std::floor(u)) * kBins), y = int((v - std::floor(v)) * kBins);
        return std::size_t(std::clamp(y, 0, kBins - 1) * kBins + std::clamp(x, 0, kBins - 1));
    }

    void use(int c, float sign) {
        for (int e : core_[std::size_t(c)]) {
            const Vec2f shown = cover_.coord[std::size_t(e)] + offset_[std::size_t(c)];
            const double weight = double(sign * coreWeight_[std::size_t(c)]);
            usage_[bin(shown)] += float(weight);
            used_ += weight;
            const std::size_t t = texel(shown);
            for (Distribution& d : distributions_) {
                d.shown[d.quantile[t]] += weight;
            }
            shownResponse_ += Vec3d(ex_.response[t]) * weight;
        }
    }

    std::vector<Constraint> constraintsOf(int c) const {
        std::vector<Constraint> out;
        forMembers(c, [&](int v, int own) {
            const float r = cover_.remoteness[std::size_t(own)];
            float nearest = r;
            for (int e = cover_.first[std::size_t(v)]; e < cover_.first[std::size_t(v) + 1]; ++e) {
                nearest = std::min(nearest, cover_.remoteness[std::size_t(e)]);
            }
            for (int e = cover_.first[std::size_t(v)]; e < cover_.first[std::size_t(v) + 1]; ++e) {
                const int o = cover_.chart[std::size_t(e)];
                if (o == c || !chosen_[std::size_t(o)]) {
                    continue;
                }
                // Two charts meet where both middles are about as near, and no third one is nearer.
                const float d = (r - cover_.remoteness[std::size_t(e)]) / kRival;
                const float third = (std::max(r, cover_.remoteness[std::size_t(e)]) - nearest) / (2 * kRival);
                const float w = std::exp(-0.5f * (d * d + third * third));
                if (w > 0.02f) {
                    out.push_back(
                        {cover_.coord[std::size_t(own)], cover_.coord[std::size_t(e)] + offset_[std::size_t(o)], w, o});
                }
            }
        });
        return out;
    }

    /// Every so many of a list, at most `most`.
    static std::vector<Constraint> thinned(const std::vector<Constraint>& all, std::size_t most) {
        std::vector<Constraint> out;
        const std::size_t stride = all.size() / most + 1;
        for (std::size_t i = stride / 2; i < all.size(); i += stride) {
            out.push_back(all[i]);
        }
        return out;
    }

    std::vector<Candidate> candidates(int c, int sweep, const std::vector<Constraint>& constraints) const {
        std::vector<Candidate> out;
        CounterRng rng(options_.seed ^ 0x6f6666736574ull, std::uint64_t(c) * 64 + std::uint64_t(sweep));
        for (int i = 0; i < kRandomCandidates; ++i) {
            const float u = rng.uniform(), v = rng.uniform();
            out.push_back({{u * tile_.x, v * tile_.y}});
        }
        if (chosen_[std::size_t(c)]) {
            out.push_back({offset_[std::size_t(c)]});
        }
        // A neighbour continued: the mean over the overlap with it.
        std::vector<std::pair<int, std::pair<Vec2f, float>>> mean;
        for (const Constraint& k : constraints) {
            auto it = std::find_if(mean.begin(), mean.end(), [&](const auto& m) { return m.first == k.other; });
            if (it == mean.end()) {
                mean.push_back({k.other, {{0, 0}, 0.0f}});
                it = mean.end() - 1;
            }
            it->second.first = it->second.first + (k.wanted - k.own) * k.weight;
            it->second.second += k.weight;
        }
        for (const auto& m : mean) {
            out.push_back({m.second.first * (1 / m.second.second)});
        }
        // All neighbours at once, near what the chart shows now: drift is spread instead of piling up where fronts
        // meet.
        if (chosen_[std::size_t(c)] && !constraints.empty()) {
            Vec2f sum{0, 0};
            float weight = 0;
            for (const Constraint& k : constraints) {
                const Vec2f d = nearestImage(k.wanted - k.own - offset_[std::size_t(c)], ex_.tileMm());
                const float w = k.weight * std::exp(-(d.x * d.x + d.y * d.y) / (0.02f * tile_.x * tile_.y));
                sum = sum + d * w;
                weight += w;
            }
            if (weight > 0) {
                for (float share : {1.0f, 1.6f, 0.5f}) {
                    out.push_back({offset_[std::size_t(c)] + sum * (share / weight)});
                }
            }
            for (int i = 0; i < 12; ++i) {
                const float u = rng.uniform() - 0.5f, v = rng.uniform() - 0.5f;
                out.push_back({offset_[std::size_t(c)] + Vec2f(u * tile_.x, v * tile_.y) * 0.1f});
            }
        }
        // What is alike, in detail and in structure.
        const Vec2f texel{float(ex_.texelMm.x), float(ex_.texelMm.y)};
        for (const Constraint& k : thinned(constraints, kJumpSamples)) {
            const int x = ex_.wrapX(int(std::floor(k.wanted.x / texel.x))),
                      y = ex_.wrapY(int(std::floor(k.wanted.y / texel.y)));
            const std::size_t t = std::size_t(y) * std::size_t(ex_.width) + std::size_t(x);
            for (const std::vector<int>* similar : {&ex_.similar, &ex_.similarCoarse}) {
                for (int i = 0; i < ex_.similarCount; ++i) {
                    const int s = (*similar)[t * std::size_t(ex_.similarCount) + std::size_t(i)];
                    if (s != int(t)) {
                        const Vec2f jump{float(s % ex_.width - x) * texel.x, float(s / ex_.width - y) * texel.y};
                        out.push_back({k.wanted + jump - k.own});
                    }
                }
            }
        }
        return out;
    }

    /// What the constraints ask for, in an image: the same for every candidate.
    std::vector<AppearanceImage::Value> wantedIn(const AppearanceImage& image,
                                                 const std::vector<Constraint>& constraints) const {
        std::vector<AppearanceImage::Value> wanted;
        for (const Constraint& k : constraints) {
            wanted.push_back(
                image.sample(k.wanted.x * (1 / float(ex_.texelMm.x)), k.wanted.y * (1 / float(ex_.texelMm.y))));
        }
        return wanted;
    }

    float mismatch(const std::vector<Constraint>& constraints, const std::vector<AppearanceImage::Value>& wanted,
                   const Vec2f& offset, const AppearanceImage& image) const {
        if (constraints.empty()) {
            return 0;
        }
        const float px = 1 / float(ex_.texelMm.x), py = 1 / float(ex_.texelMm.y);
        float sum = 0, weight = 0;
        for (std::size_t i = 0; i < constraints.size(); ++i) {
            const Constraint& k = constraints[i];
            const Vec2f a = k.own + offset;
            const float d = squaredDistance(image.sample(a.x * px, a.y * py), wanted[i]);
            sum += k.weight * std::min(d, kCap * kCap * own2_);
            weight += k.weight;
        }
        return sum / weight / own2_;
    }

    /// What of each parameter's distribution a texel belongs to, in quantiles of the sample.
    void sortParameters() {
        const std::size_t texels = ex_.texelCount();
        for (const std::vector<float>& values : ex_.parameters) {
            std::vector<float> sorted = values;
            std::sort(sorted.begin(), sorted.end());
            Distribution d;
            d.quantile.resize(texels);
            d.share.assign(kQuantiles, 0.0);
            d.shown.assign(kQuantiles, 0.0);
            for (std::size_t t = 0; t < texels; ++t) {
                // Equal values fall into one quantile, which then holds more than its part.
                const std::size_t rank =
                    std::size_t(std::lower_bound(sorted.begin(), sorted.end(), values[t]) - sorted.begin());
                const std::size_t q = rank * kQuantiles / texels;
                d.quantile[t] = std::uint8_t(q);
                d.share[q] += 1 / double(texels);
            }
            distributions_.push_back(std::move(d));
        }
        for (const Rgb& r : ex_.response) {
            meanResponse_ += Vec3d(r) / double(texels);
        }
    }

    std::size_t texel(const Vec2f& mm) const {
        const int x = ex_.wrapX(int(std::floor(mm.x / float(ex_.texelMm.x)))),
                  y = ex_.wrapY(int(std::floor(mm.y / float(ex_.texelMm.y))));
        return std::size_t(y) * std::size_t(ex_.width) + std::size_t(x);
    }

    /// How far the distributions of parameters, and mean reflectance, of the whole surface would be off if the charts
    /// yet to choose made up for nothing: 1 where a target is just met. One chart among hundreds hardly matters, one of
    /// a few does.
    float imbalance(int c, const Vec2f& offset) const {
        const std::vector<int>& core = core_[std::size_t(c)];
        const std::size_t stride = core.size() / kBudgetSamples + 1, count = (core.size() + stride - 1) / stride;
        if (count == 0) {
            return 0;
        }
        const double own = double(coreWeight_[std::size_t(c)]) * double(core.size()), each = own / double(count);
        std::size_t places[kBudgetSamples + 1];
        Vec3d response = shownResponse_ - meanResponse_ * (used_ + own);
        for (std::size_t i = 0; i < count; ++i) {
            places[i] = texel(cover_.coord[std::size_t(core[i * stride])] + offset);
            response += Vec3d(ex_.response[places[i]]) * each;
        }
        double worst = 0;
        for (const Distribution& d : distributions_) {
            double part[kQuantiles] = {};
            for (std::size_t i = 0; i < count; ++i) {
                part[d.quantile[places[i]]] += each;
            }
            double above = 0;
            for (std::size_t q = 0; q < kQuantiles; ++q) {
                above += d.shown[q] + part[q] - d.share[q] * (used_ + own);
                worst = std::max(worst, std::abs(above) / kWantedKs);
            }
        }
        for (int k = 0; k < 3; ++k) {
            if (meanResponse_[k] > 0) {
                worst = std::max(worst, std::abs(response[k]) / meanResponse_[k] / kWantedDeltaR);
            }
        }
        worst /= double(g_.size());
        return float(worst * worst);
    }

    float overuse(int c, const Vec2f& offset) const {
        if (!(used_ > 0)) {
            return 0;
        }
        const double fair = used_ / (kBins * kBins);
        double sum = 0, n = 0;
        const std::vector<int>& core = core_[std::size_t(c)];
        const std::size_t stride = core.size() / 64 + 1;
        for (std::size_t i = 0; i < core.size(); i += stride) {
            sum += double(usage_[bin(cover_.coord[std::size_t(core[i])] + offset)]);
            n += 1;
        }
        // Less than a whole tile shown so far: every place is either used or not.
        return n > 0 ? float(sum / n / (fair + 1e-3 * used_) - 1) : 0;
    }

    /// How much charts nearby show the same place, over the tile of offsets: a bell around the offset of each, on a
    /// lattice, for there are many charts nearby where the surface is thin and branched, and many candidates.
    std::vector<float> repetitionMap(int c) const {
        std::vector<float> map(std::size_t(kBells * kBells), 0.0f);
        const Vec3f p = g_.points[std::size_t(cover_.charts[std::size_t(c)].seed)];
        const float side = std::min(tile_.x, tile_.y), reach = 3.5f * side;
        float alongX[kBells], alongY[kBells];
        const auto bell = [](float at, float(&out)[kBells]) {
            for (int i = 0; i < kBells; ++i) {
                const float d = (float(i) + 0.5f) / kBells - at, u = d - std::nearbyint(d);
                out[i] = std::exp(-u * u / (0.2f * 0.2f));
            }
        };
        for (std::size_t o = 0; o < cover_.charts.size(); ++o) {
            if (int(o) == c || !chosen_[o] || !(weight_[o] > kNoticed)) {
                continue;
            }
            const float d = float(mmPerUnit_) * length(g_.points[std::size_t(cover_.charts[o].seed)] - p);
            // Charts that overlap may well show neighbouring places: only what is further off repeats.
            if (d < reach && d > 0.8f * cover_.charts[std::size_t(c)].radiusMm) {
                const float w = weight_[o] * std::exp(-0.25f * d * d / (side * side));
                bell(offset_[o].x / tile_.x, alongX);
                bell(offset_[o].y / tile_.y, alongY);
                for (int y = 0; y < kBells; ++y) {
                    const float row = w * alongY[y];
                    for (int x = 0; x < kBells; ++x) {
                        map[std::size_t(y * kBells + x)] += row * alongX[x];
                    }
                }
            }
        }
        return map;
    }

    float repeated(const std::vector<float>& map, const Vec2f& offset) const {
        const auto place = [](float of, int& low, int& high) {
            const float u = (of - std::floor(of)) * kBells - 0.5f, f = std::floor(u);
            low = (int(f) + kBells) % kBells;
            high = (low + 1) % kBells;
            return u - f;
        };
        int x0, x1, y0, y1;
        const float u = place(offset.x / tile_.x, x0, x1), v = place(offset.y / tile_.y, y0, y1);
        const auto at = [&](int x, int y) { return map[std::size_t(y * kBells + x)]; };
        return (1 - v) * ((1 - u) * at(x0, y0) + u * at(x1, y0)) + v * ((1 - u) * at(x0, y1) + u * at(x1, y1));
    }

    Vec2f choose(int c, int sweep) const {
        const std::vector<Constraint> all = constraintsOf(c);
        std::vector<Candidate> list = candidates(c, sweep, all);
        const std::vector<Constraint> few = thinned(all, kCoarseSamples), many = thinned(all, kFineSamples);
        const std::vector<float> shownNearby = repetitionMap(c);
        const AppearanceImage& coarse = ex_.stack[std::min<std::size_t>(1, ex_.stack.size() - 1)];
        const std::vector<AppearanceImage::Value> wantedByFew = wantedIn(coarse, few),
                                                  wantedByMany = wantedIn(ex_.stack[0], many);
        std::vector<float> other(list.size());
        parallelFor(list.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                other[i] = variety_ * (float(options_.usage) * overuse(c, list[i].offset) +
                                       float(options_.repetition) * repeated(shownNearby, list[i].offset)) +
                           float(options_.balance) * imbalance(c, list[i].offset);
                list[i].cost = mismatch(few, wantedByFew, list[i].offset, coarse) + other[i];
            }
        });
        std::vector<std::size_t> best(list.size());
        for (std::size_t i = 0; i < best.size(); ++i) {
            best[i] = i;
        }
        const std::size_t finalists = std::min<std::size_t>(kFinalists, best.size());
        std::partial_sort(best.begin(), best.begin() + std::ptrdiff_t(finalists), best.end(),
                          [&](std::size_t a, std::size_t b) {
                              return list[a].cost != list[b].cost ? list[a].cost < list[b].cost : a < b;
                          });
        parallelFor(finalists, 2, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                Candidate& k = list[best[i]];
                k.cost = mismatch(many, wantedByMany, k.offset, ex_.stack[0]) + other[best[i]];
            }
        });
        std::size_t winner = best[0];
        for (std::size_t i = 1; i < finalists; ++i) {
            winner = list[best[i]].cost < list[winner].cost ? best[i] : winner;
        }
        const Vec2f o = list[winner].offset;
        return {o.x - tile_.x * std::floor(o.x / tile_.x), o.y - tile_.y * std::floor(o.y / tile_.y)};
    }

    const SurfaceGraph& g_;
    const ChartCover& cover_;
    const Exemplar& ex_;
    const OffsetOptions& options_;
    double mmPerUnit_;
    std::vector<Vec2f> offset_;
    std::vector<char> chosen_;
    std::vector<std::vector<int>> core_; ///< entries, thinned
    std::vector<float> coreWeight_;      ///< vertices per entry of it
    std::vector<float> weight_;          ///< what a chart shows against an ordinary one, at most 1
    std::vector<float> usage_;
    double used_ = 0;
    /// A parameter's quantile per texel, the share of each, and by how many vertices it is shown.
    struct Distribution {
        std::vector<std::uint8_t> quantile;
        std::vector<double> share, shown;
    };
    std::vector<Distribution> distributions_;
    Vec3d meanResponse_, shownResponse_; ///< of the sample; summed over the vertices shown
    Vec2f tile_;
    float own2_, variety_; ///< square of a seam's unit; 0 to 1, how many places are alike
};

} // namespace

std::vector<Vec2f> chooseOffsets(const SurfaceGraph& graph, const ChartCover& cover, const Exemplar& exemplar,
                                 double mmPerUnit, const OffsetOptions& options, Progress& progress) {
    return Chooser(graph, cover, exemplar, mmPerUnit, options).run(progress);
}

} // namespace stf
