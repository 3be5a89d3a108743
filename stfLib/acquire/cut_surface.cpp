// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/cut_surface.h"

#include "stfLib/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace stf {

namespace {

// How much faces between layers count, sweep by sweep: layers find their own ways first and are then drawn together, or
// the first flat cut would hold all of them.
constexpr double kDepthWeights[] = {0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1, 1, 1, 1};

// The cost with sums over the steps across, so that a jump of the cut between neighbours takes no loop.
class CutCosts {
public:
    explicit CutCosts(const OverlapCost& c) : c_(c), sums_(c.difference.size() + c.difference.size() / c.overlap) {
        for (int z = 0; z < c.layers; ++z) {
            for (int y = 0; y < c.length; ++y) {
                double sum = 0;
                for (int x = 0; x < c.overlap; ++x) {
                    sums_[row(y, z) + std::size_t(x)] = sum;
                    sum += double(c.difference[c.index(x, y, z)]);
                }
                sums_[row(y, z) + std::size_t(c.overlap)] = sum;
            }
        }
    }
    /// The face across the cut itself.
    double across(int y, int z, int cut) const {
        return double(c_.difference[c_.index(cut - 1, y, z)]) + double(c_.difference[c_.index(cut, y, z)]);
    }
    /// Faces between two neighbouring lines with these cuts: all voxels between them.
    double between(int y, int z, int cut, int otherY, int otherZ, int otherCut) const {
        const std::size_t lo = std::size_t(std::min(cut, otherCut)), hi = std::size_t(std::max(cut, otherCut));
        const std::size_t a = row(y, z), b = row(otherY, otherZ);
        return sums_[a + hi] - sums_[a + lo] + sums_[b + hi] - sums_[b + lo];
    }
    /// Sum over [0, cut) of one line.
    double sum(int y, int z, int cut) const { return sums_[row(y, z) + std::size_t(cut)]; }

private:
    std::size_t row(int y, int z) const {
        return std::size_t(c_.overlap + 1) * (std::size_t(y) + std::size_t(c_.length) * std::size_t(z));
    }
    const OverlapCost& c_;
    std::vector<double> sums_;
};

// The best cuts of a chain of lines. `own(i, cut)` is what a cut of line i costs by itself, `sum(i, cut)` the running
// sum of differences: a jump from a to b between lines costs |sum_i(b) - sum_i(a)| + |sum_i+1(b) - sum_i+1(a)|, a sum
// of rising functions of both, so that the best predecessor is found by two running minima, one from each side.
template<class Own, class Sum>
void cutChain(int lines, int overlap, bool circle, int start, const std::vector<int>& before, Own own, Sum sum,
              std::vector<int>& result) {
    const double inf = std::numeric_limits<double>::infinity();
    // A circle is opened at line `start`, which keeps its cut and stands at both ends.
    const int steps = circle ? lines + 1 : lines;
    const auto line = [&](int step) { return circle ? (start + step) % lines : step; };
    const int cuts = overlap - 1; // 1 .. overlap - 1
    std::vector<double> best(std::size_t(cuts), 0.0), next(best);
    std::vector<std::int16_t> from(std::size_t(steps) * std::size_t(cuts), 0);
    for (int c = 0; c < cuts; ++c) {
        best[std::size_t(c)] = circle && c + 1 != before[std::size_t(start)] ? inf : own(line(0), c + 1);
    }
    for (int s = 1; s < steps; ++s) {
        const int i = line(s - 1), j = line(s);
        const auto height = [&](int c) { return sum(i, c + 1) + sum(j, c + 1); };
        std::int16_t* const source = from.data() + std::size_t(s) * std::size_t(cuts);
        double least = inf;
        int where = 0;
        for (int c = 0; c < cuts; ++c) { // predecessors at or before c
            if (best[std::size_t(c)] - height(c) < least) {
                least = best[std::size_t(c)] - height(c);
                where = c;
            }
            next[std::size_t(c)] = least + height(c);
            source[c] = std::int16_t(where);
        }
        least = inf;
        for (int c = cuts - 1; c >= 0; --c) { // and after it
            if (best[std::size_t(c)] + height(c) < least) {
                least = best[std::size_t(c)] + height(c);
                where = c;
            }
            if (least - height(c) < next[std::size_t(c)]) {
                next[std::size_t(c)] = least - height(c);
                source[c] = std::int16_t(where);
            }
        }
        const bool closing = circle && s == steps - 1;
        for (int c = 0; c < cuts; ++c) {
            if (!closing) {
                next[std::size_t(c)] += own(j, c + 1);
            } else if (c + 1 != before[std::size_t(start)]) {
                next[std::size_t(c)] = inf;
            }
        }
        best.swap(next);
    }
    int c = int(std::min_element(best.begin(), best.end()) - best.begin());
    for (int s = steps - 1; s >= 0; --s) {
        result[std::size_t(line(s))] = c + 1;
        c = from[std::size_t(s) * std::size_t(cuts) + std::size_t(c)];
    }
}

class Cutter {
public:
    explicit Cutter(const OverlapCost& c) : c_(c), costs_(c) {
        cut_.assign(std::size_t(c.length) * std::size_t(c.layers), c.overlap / 2);
    }

    /// The same cut in all layers, of least cost. A circle is closed where the open cut ends.
    void cutAllAlike() {
        std::vector<int> before(std::size_t(c_.length), c_.overlap / 2), after(before);
        std::vector<double> sums(std::size_t(c_.length) * std::size_t(c_.overlap + 1), 0.0), own(sums);
        for (int z = 0; z < c_.layers; ++z) {
            for (int y = 0; y < c_.length; ++y) {
                for (int cut = 1; cut <= c_.overlap; ++cut) {
                    const std::size_t at = std::size_t(cut) + std::size_t(c_.overlap + 1) * std::size_t(y);
                    sums[at] += costs_.sum(y, z, cut);
                    own[at] += cut < c_.overlap ? costs_.across(y, z, cut) : 0;
                }
            }
        }
        const auto of = [&](const std::vector<double>& v) {
            return [&](int y, int cut) { return v[std::size_t(cut) + std::size_t(c_.overlap + 1) * std::size_t(y)]; };
        };
        cutChain(c_.length, c_.overlap, false, 0, before, of(own), of(sums), after);
        if (closes()) {
            before = after;
            cutChain(c_.length, c_.overlap, true, c_.length / 2, before, of(own), of(sums), after);
        }
        for (int z = 0; z < c_.layers; ++z) {
            std::copy(after.begin(), after.end(), cut_.begin() + std::ptrdiff_t(z) * c_.length);
        }
    }

    void sweep(int number, double depthWeight) {
        depthWeight_ = depthWeight;
        // Layers of one parity do not touch each other.
        for (int parity : {0, 1}) {
            parallelFor(std::size_t((c_.layers + 1 - parity) / 2), 1, [&](std::size_t begin, std::size_t end) {
                for (std::size_t k = begin; k < end; ++k) {
                    cutLayer(int(2 * k) + parity, number);
                }
            });
        }
        for (int parity : {0, 1}) {
            // On a circle of odd length the last line and the first are neighbours: it is left to the layers.
            const int lines = c_.circle && c_.length % 2 == 1 ? c_.length - 1 : c_.length;
            parallelFor(std::size_t((lines + 1 - parity) / 2), 1, [&](std::size_t begin, std::size_t end) {
                for (std::size_t k = begin; k < end; ++k) {
                    cutDepth(int(2 * k) + parity);
                }
            });
        }
    }

    CutSurface result() const {
        CutSurface s;
        s.cut = cut_;
        for (int z = 0; z < c_.layers; ++z) {
            for (int y = 0; y < c_.length; ++y) {
                const int cut = at(y, z);
                s.cost += costs_.across(y, z, cut);
                s.faces += 1;
                const int nextY = (y + 1) % c_.length;
                if (nextY != y && (c_.circle || nextY > y)) {
                    s.cost += costs_.between(y, z, cut, nextY, z, at(nextY, z));
                    s.faces += std::abs(cut - at(nextY, z));
                }
                if (z + 1 < c_.layers) {
                    s.cost += costs_.between(y, z, cut, y, z + 1, at(y, z + 1));
                    s.faces += std::abs(cut - at(y, z + 1));
                }
            }
        }
        return s;
    }

private:
    bool closes() const { return c_.circle && c_.length > 2; }
    int at(int y, int z) const { return cut_[std::size_t(y) + std::size_t(c_.length) * std::size_t(z)]; }

    // What a cut costs against the lines that stay, and by itself.
    double toLayers(int y, int z, int cut) const {
        double sum = costs_.across(y, z, cut);
        if (z > 0) {
            sum += depthWeight_ * costs_.between(y, z, cut, y, z - 1, at(y, z - 1));
        }
        if (z + 1 < c_.layers) {
            sum += depthWeight_ * costs_.between(y, z, cut, y, z + 1, at(y, z + 1));
        }
        return sum;
    }
    double toLines(int y, int z, int cut) const {
        double sum = costs_.across(y, z, cut);
        for (int step : {-1, 1}) {
            const int other = c_.circle ? (y + step + c_.length) % c_.length : y + step;
            if (other >= 0 && other < c_.length && other != y) {
                sum += costs_.between(y, z, cut, other, z, at(other, z));
            }
        }
        return sum;
    }

    void cutLayer(int z, int number) {
        std::vector<int> before(std::size_t(c_.length)), after(before);
        for (int y = 0; y < c_.length; ++y) {
            before[std::size_t(y)] = at(y, z);
        }
        // Without a cut from before there is nothing to close a circle at: the open cut gives it.
        const bool circle = closes() && number > 0;
        // Another place to open the circle each time, so that no line stays what it was.
        const int start = circle ? int((std::size_t(number) * 7919u) % std::size_t(c_.length)) : 0;
        cutChain(
            c_.length, c_.overlap, circle, start, before, [&](int y, int cut) { return toLayers(y, z, cut); },
            [&](int y, int cut) { return costs_.sum(y, z, cut); }, after);
        std::copy(after.begin(), after.end(), cut_.begin() + std::ptrdiff_t(z) * c_.length);
    }

    void cutDepth(int y) {
        std::vector<int> after(std::size_t(c_.layers));
        cutChain(
            c_.layers, c_.overlap, false, 0, after, [&](int z, int cut) { return toLines(y, z, cut); },
            [&](int z, int cut) { return depthWeight_ * costs_.sum(y, z, cut); }, after);
        for (int z = 0; z < c_.layers; ++z) {
            cut_[std::size_t(y) + std::size_t(c_.length) * std::size_t(z)] = after[std::size_t(z)];
        }
    }

    const OverlapCost& c_;
    CutCosts costs_;
    std::vector<int> cut_;
    double depthWeight_ = 1;
};

} // namespace

CutSurface cutOverlap(const OverlapCost& cost, Progress& progress) {
    if (cost.overlap < 2 || cost.overlap > 32767) {
        throw Error("a cut needs an overlap of 2 to 32767 voxels, not " + std::to_string(cost.overlap));
    }
    Cutter cutter(cost);
    cutter.cutAllAlike();
    CutSurface best = cutter.result();
    const auto keepBetter = [&] {
        CutSurface now = cutter.result();
        const bool better = now.cost < best.cost * (1 - 1e-4);
        if (now.cost < best.cost) {
            best = std::move(now);
        }
        return better;
    };
    constexpr int kSweeps = int(std::size(kDepthWeights));
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        progress.update("quilt", double(sweep) / (2 * kSweeps));
        cutter.sweep(sweep, kDepthWeights[sweep]);
    }
    keepBetter();
    cutter.cutAllAlike();
    for (int sweep = 1; sweep <= kSweeps; ++sweep) {
        progress.update("quilt", 0.5 + double(sweep) / (2 * kSweeps));
        cutter.sweep(sweep, 1);
        if (!keepBetter() && sweep > 1) {
            break;
        }
    }
    progress.update("quilt", 1);
    return best;
}

} // namespace stf
