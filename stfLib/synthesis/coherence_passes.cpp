// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/coherence_passes.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"

#include <atomic>
#include <cmath>

namespace stf {

namespace {

struct Choice {
    int entry;
    Vec2f offset;
};

class Corrector {
public:
    Corrector(const SurfaceGraph& g, const SurfaceSteps& steps, const ChartCover& cover, const Exemplar& ex,
              const CoherenceOptions& options, PatchLabels& labels)
        : g_(g), steps_(steps), cover_(cover), ex_(ex), options_(options), labels_(labels),
          own2_(float(std::max(ex.ownError * ex.ownError, 1e-4))), texelMm_(float(ex.texelMm.x)) {
        shown_.resize(g.size());
        parallelFor(g.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v) {
                shown_[v] = show(labels_.coord(cover_, v));
            }
        });
    }

    std::size_t run(Progress& progress) {
        std::size_t total = 0;
        for (int pass = 0; pass < options_.passes; ++pass) {
            std::atomic<std::size_t> changed{0};
            parallelFor(g_.size(), 4096, [&](std::size_t begin, std::size_t end) {
                std::size_t n = 0;
                for (std::size_t v = begin; v < end; ++v) {
                    n += turnOf(v, pass) && update(v);
                }
                changed += n;
            });
            total += changed;
            progress.update("coherence", double(pass + 1) / options_.passes);
        }
        return total;
    }

private:
    AppearanceImage::Value show(const Vec2f& mm) const {
        return ex_.stack[0].sample(mm.x / float(ex_.texelMm.x), mm.y / float(ex_.texelMm.y));
    }

    /// Whether v may change in a pass: it holds the least random number among its neighbours.
    bool turnOf(std::size_t v, int pass) const {
        const auto number = [&](std::size_t i) {
            return std::pair(hash32(options_.seed ^ 0x7475726eull, (std::uint64_t(pass) << 32) + i), i);
        };
        const auto own = number(v);
        for (int k = g_.first[v]; k < g_.first[v + 1]; ++k) {
            if (number(std::size_t(g_.neighbour[std::size_t(k)])) < own) {
                return false;
            }
        }
        return true;
    }

    float cost(std::size_t v, const Choice& c) const {
        const std::size_t entry = std::size_t(c.entry);
        const int chart = cover_.chart[entry];
        const Vec2f at = cover_.coord[entry] + c.offset;
        float sum = 0;
        for (int k = g_.first[v]; k < g_.first[v + 1]; ++k) {
            const std::size_t u = std::size_t(g_.neighbour[std::size_t(k)]);
            const int same = cover_.entryAt(int(u), chart);
            const Vec2f there =
                same >= 0 ? cover_.coord[std::size_t(same)] + c.offset : at + steps_.stepMm[std::size_t(k)];
            const Vec2f d = nearestImage(there - labels_.coord(cover_, u), ex_.tileMm());
            const float texels = std::sqrt(d.x * d.x + d.y * d.y) / texelMm_;
            if (texels > 1e-3f) {
                sum += squaredDistance(show(there), shown_[u]) +
                       float(options_.breakCost) * own2_ * std::min(1.0f, texels);
            }
        }
        // Stretch counts here as it does where seams are cut.
        return sum + own2_ * 4 * cover_.strain[entry];
    }

    bool update(std::size_t v) {
        bool beside = false;
        for (int k = g_.first[v]; k < g_.first[v + 1] && !beside; ++k) {
            const std::size_t u = std::size_t(g_.neighbour[std::size_t(k)]);
            beside = cover_.chart[std::size_t(labels_.entry[u])] != cover_.chart[std::size_t(labels_.entry[v])] ||
                     !(labels_.offset[u] == labels_.offset[v]);
        }
        if (!beside) {
            return false;
        }
        const Choice current{labels_.entry[v], labels_.offset[v]};
        Choice best = current;
        float least = cost(v, current);
        const auto attempt = [&](const Choice& c) {
            const float now = cost(v, c);
            if (now < least * 0.999f - 1e-6f * own2_) {
                least = now;
                best = c;
            }
        };
        for (int k = g_.first[v]; k < g_.first[v + 1]; ++k) {
            const std::size_t u = std::size_t(g_.neighbour[std::size_t(k)]);
            const int e = cover_.entryAt(int(v), cover_.chart[std::size_t(labels_.entry[u])]);
            if (e < 0) {
                continue;
            }
            attempt({e, labels_.offset[u]});
            const Vec2f c = cover_.coord[std::size_t(e)] + labels_.offset[u];
            const int x = ex_.wrapX(int(std::floor(c.x / float(ex_.texelMm.x)))),
                      y = ex_.wrapY(int(std::floor(c.y / float(ex_.texelMm.y))));
            const std::size_t t = std::size_t(y) * std::size_t(ex_.width) + std::size_t(x);
            for (int i = 0; i < std::min(options_.similar, ex_.similarCount); ++i) {
                const int s = ex_.similar[t * std::size_t(ex_.similarCount) + std::size_t(i)];
                if (s != int(t)) {
                    attempt({e, labels_.offset[u] + Vec2f(float(s % ex_.width - x) * float(ex_.texelMm.x),
                                                          float(s / ex_.width - y) * float(ex_.texelMm.y))});
                }
            }
        }
        if (best.entry == current.entry && best.offset == current.offset) {
            return false;
        }
        labels_.entry[v] = best.entry;
        labels_.offset[v] = best.offset;
        shown_[v] = show(labels_.coord(cover_, v));
        return true;
    }

    const SurfaceGraph& g_;
    const SurfaceSteps& steps_;
    const ChartCover& cover_;
    const Exemplar& ex_;
    const CoherenceOptions& options_;
    PatchLabels& labels_;
    std::vector<AppearanceImage::Value> shown_;
    float own2_, texelMm_;
};

} // namespace

std::size_t correctByCoherence(const SurfaceGraph& graph, const SurfaceSteps& steps, const ChartCover& cover,
                               const Exemplar& exemplar, const CoherenceOptions& options, PatchLabels& labels,
                               Progress& progress) {
    return Corrector(graph, steps, cover, exemplar, options, labels).run(progress);
}

} // namespace stf
