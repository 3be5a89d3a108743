// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/patch_labels.h"

#include "stfLib/base/parallel.h"
#include "stfLib/synthesis/min_cut.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <unordered_set>

namespace stf {

namespace {

constexpr float kUnknown = 20; ///< cost of a link whose other label does not reach so far, in own errors

class Expander {
public:
    Expander(const SurfaceGraph& g, const ChartCover& cover, const std::vector<Vec2f>& offsets, const Exemplar& ex,
             const SeamOptions& options)
        : g_(g), cover_(cover), offsets_(offsets), ex_(ex), options_(options),
          perOwn_(1 / float(std::max(ex.ownError, 1e-2))), slot_(g.size(), -1) {
        sampleAppearance();
        labels_.resize(g.size());
        for (std::size_t v = 0; v < g.size(); ++v) {
            int best = cover.first[v];
            for (int e = best + 1; e < cover.first[v + 1]; ++e) {
                best = unary(e) < unary(best) ? e : best;
            }
            labels_[v] = best;
        }
    }

    PatchLabels run(Progress& progress) {
        const std::vector<std::vector<int>> classes = colourClasses();
        const std::size_t total = cover_.charts.size() * std::size_t(options_.sweeps);
        std::atomic<std::size_t> done{0};
        for (int sweep = 0; sweep < options_.sweeps; ++sweep) {
            for (const std::vector<int>& charts : classes) {
                parallelFor(charts.size(), 1, [&](std::size_t begin, std::size_t) {
                    expand(charts[begin]);
                    progress.update("seams", double(++done) / double(total));
                });
            }
        }
        PatchLabels out;
        out.entry = labels_;
        out.offset.resize(g_.size());
        for (std::size_t v = 0; v < g_.size(); ++v) {
            out.offset[v] = offsets_[std::size_t(cover_.chart[std::size_t(labels_[v])])];
        }
        return out;
    }

private:
    void sampleAppearance() {
        const float px = 1 / float(ex_.texelMm.x), py = 1 / float(ex_.texelMm.y);
        appearance_.resize(cover_.coord.size());
        parallelFor(cover_.coord.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t e = begin; e < end; ++e) {
                const Vec2f c = cover_.coord[e] + offsets_[std::size_t(cover_.chart[e])];
                appearance_[e] = ex_.stack[0].sample(c.x * px, c.y * py);
            }
        });
    }

    float unary(int e) const {
        return float(options_.strainCost) * cover_.strain[std::size_t(e)] +
               float(options_.remoteCost) * cover_.remoteness[std::size_t(e)] * cover_.remoteness[std::size_t(e)];
    }

    /// Difference between what two entries of one vertex would show there.
    float seen(int a, int b) const {
        return perOwn_ * std::sqrt(squaredDistance(appearance_[std::size_t(a)], appearance_[std::size_t(b)]));
    }

    /// What a seam between the charts of two entries of one vertex costs for its length: nothing where both show one
    /// continued place.
    float length(int a, int b) const {
        const auto at = [&](int e) {
            return cover_.coord[std::size_t(e)] + offsets_[std::size_t(cover_.chart[std::size_t(e)])];
        };
        const Vec2f d = nearestImage(at(a) - at(b), ex_.tileMm());
        const float texels = std::sqrt(d.x * d.x + d.y * d.y) / float(ex_.texelMm.x);
        return float(options_.lengthCost) * std::min(1.0f, texels);
    }

    /// Cost of a link between u of chart a and v of chart b.
    float seam(std::size_t u, int a, std::size_t v, int b) const {
        if (a == b) {
            return 0;
        }
        const int ua = cover_.entryAt(int(u), a), ub = cover_.entryAt(int(u), b);
        const int va = cover_.entryAt(int(v), a), vb = cover_.entryAt(int(v), b);
        const bool known[2] = {ua >= 0 && ub >= 0, va >= 0 && vb >= 0};
        if (!known[0] && !known[1]) {
            return kUnknown;
        }
        const float atU = known[0] ? seen(ua, ub) : seen(va, vb), atV = known[1] ? seen(va, vb) : atU;
        return atU + atV + (known[0] ? length(ua, ub) : length(va, vb));
    }

    /// A vertex's own patch against the one that expands.
    struct Contrast {
        int entry; ///< of the chart that expands
        float seen, length;
    };

    void expand(int p) {
        const ChartCover::Chart& chart = cover_.charts[std::size_t(p)];
        std::vector<int> nodes;
        for (int i = 0; i < chart.count; ++i) {
            const int v = cover_.member[std::size_t(chart.first + i)];
            if (cover_.chart[std::size_t(labels_[std::size_t(v)])] != p) {
                slot_[std::size_t(v)] = int(nodes.size());
                nodes.push_back(v);
            }
        }
        if (nodes.empty()) {
            return;
        }
        // Source: keep; sink: take p. Most links have both ends in one patch: what they need is known per node.
        std::vector<Contrast> contrast(nodes.size());
        for (std::size_t n = 0; n < nodes.size(); ++n) {
            const int own = labels_[std::size_t(nodes[n])];
            contrast[n].entry = cover_.entryAt(nodes[n], p);
            contrast[n].seen = seen(own, contrast[n].entry);
            contrast[n].length = length(own, contrast[n].entry);
        }
        MinCut cut(nodes.size());
        for (std::size_t n = 0; n < nodes.size(); ++n) {
            const std::size_t v = std::size_t(nodes[n]);
            const int own = labels_[v], a = cover_.chart[std::size_t(own)];
            cut.addTerminal(n, unary(contrast[n].entry) - unary(own));
            for (int k = g_.first[v]; k < g_.first[v + 1]; ++k) {
                const std::size_t u = std::size_t(g_.neighbour[std::size_t(k)]);
                const int b = cover_.chart[std::size_t(labels_[u])];
                const int m = slot_[u];
                if (m < 0) {
                    cut.addTerminal(n, seam(v, p, u, b) - seam(v, a, u, b));
                } else if (m > int(n)) {
                    // Costs of (keep, keep), (keep, take), (take, keep); (take, take) has none.
                    float kk = 0, kt, tk;
                    if (a == b) {
                        const Contrast &atV = contrast[n], &atU = contrast[std::size_t(m)];
                        kt = tk = atV.seen + atU.seen + atV.length;
                    } else {
                        kk = seam(v, a, u, b);
                        kt = seam(v, a, u, p);
                        tk = seam(v, p, u, b);
                    }
                    // kk + (tk - kk) [v takes] - tk [u takes] + (kt + tk - kk) [v keeps and u takes].
                    cut.addTerminal(n, tk - kk);
                    cut.addTerminal(std::size_t(m), -tk);
                    const float arc = kt + tk - kk;
                    cut.addPair(n, std::size_t(m), std::max(0.0f, arc));
                }
            }
        }
        cut.solve();
        for (std::size_t n = 0; n < nodes.size(); ++n) {
            const std::size_t v = std::size_t(nodes[n]);
            slot_[v] = -1;
            if (cut.onSink(n)) {
                labels_[v] = cover_.entryAt(int(v), p);
            }
        }
    }

    /// Charts in classes of which no two touch.
    std::vector<std::vector<int>> colourClasses() const {
        std::unordered_set<std::uint64_t> pairs;
        std::mutex mutex;
        parallelFor(g_.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
            std::unordered_set<std::uint64_t> found;
            std::uint64_t last = ~0ull;
            for (std::size_t v = begin; v < end; ++v) {
                const auto meet = [&](int e, std::size_t u) {
                    for (int f = cover_.first[u]; f < cover_.first[u + 1]; ++f) {
                        const std::uint64_t a = std::uint64_t(cover_.chart[std::size_t(e)]),
                                            b = std::uint64_t(cover_.chart[std::size_t(f)]);
                        const std::uint64_t key = std::min(a, b) << 32 | std::max(a, b);
                        if (a != b && key != last) {
                            found.insert(key);
                            last = key;
                        }
                    }
                };
                for (int e = cover_.first[v]; e < cover_.first[v + 1]; ++e) {
                    meet(e, v);
                    for (int k = g_.first[v]; k < g_.first[v + 1]; ++k) {
                        meet(e, std::size_t(g_.neighbour[std::size_t(k)]));
                    }
                }
            }
            const std::lock_guard<std::mutex> lock(mutex);
            pairs.insert(found.begin(), found.end());
        });
        std::vector<std::vector<int>> touching(cover_.charts.size());
        for (std::uint64_t key : pairs) {
            touching[std::size_t(key >> 32)].push_back(int(key & 0xffffffffu));
            touching[std::size_t(key & 0xffffffffu)].push_back(int(key >> 32));
        }
        std::vector<int> colour(cover_.charts.size(), -1);
        std::vector<std::vector<int>> classes;
        for (std::size_t c = 0; c < colour.size(); ++c) {
            std::vector<char> used(classes.size() + 1, 0);
            for (int o : touching[c]) {
                if (colour[std::size_t(o)] >= 0) {
                    used[std::size_t(colour[std::size_t(o)])] = 1;
                }
            }
            colour[c] = int(std::find(used.begin(), used.end(), 0) - used.begin());
            if (std::size_t(colour[c]) == classes.size()) {
                classes.emplace_back();
            }
            classes[std::size_t(colour[c])].push_back(int(c));
        }
        return classes;
    }

    const SurfaceGraph& g_;
    const ChartCover& cover_;
    const std::vector<Vec2f>& offsets_;
    const Exemplar& ex_;
    const SeamOptions& options_;
    float perOwn_;
    std::vector<AppearanceImage::Value> appearance_; ///< per entry
    std::vector<int> labels_;                        ///< entry per vertex
    std::vector<int> slot_; ///< node of a vertex in the running cut; charts that run at once share none
};

} // namespace

PatchLabels cutSeams(const SurfaceGraph& graph, const ChartCover& cover, const std::vector<Vec2f>& offsets,
                     const Exemplar& exemplar, const SeamOptions& options, Progress& progress) {
    return Expander(graph, cover, offsets, exemplar, options).run(progress);
}

} // namespace stf
