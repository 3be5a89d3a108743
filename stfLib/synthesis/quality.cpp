// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/quality.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"
#include "stfLib/synthesis/seam_light.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

namespace stf {

namespace {

constexpr std::size_t kGrain = 4096;

/// Sums of ranges, added in order: the same for any number of threads.
template<class Body>
std::vector<double> orderedSums(std::size_t count, std::size_t sums, const Body& body) {
    std::vector<std::vector<double>> parts((count + kGrain - 1) / kGrain, std::vector<double>(sums, 0.0));
    parallelFor(count, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            body(i, parts[begin / kGrain]);
        }
    });
    std::vector<double> total(sums, 0.0);
    for (const std::vector<double>& p : parts) {
        for (std::size_t i = 0; i < sums; ++i) {
            total[i] += p[i];
        }
    }
    return total;
}

Vec2f inTexels(const Synthesis& s, const Vec2f& mm) {
    return {mm.x / float(s.exemplar.texelMm.x), mm.y / float(s.exemplar.texelMm.y)};
}

AppearanceImage::Value show(const Synthesis& s, const Vec2f& mm) {
    const Vec2f t = inTexels(s, mm);
    return s.exemplar.stack[0].sample(t.x, t.y);
}

void links(const Synthesis& s, SynthesisQuality& q) {
    enum { Error, Links, Seams, SeamError, Count };
    const std::vector<double> sum = orderedSums(s.graph.size(), Count, [&](std::size_t v, std::vector<double>& out) {
        double around = 0;
        int n = 0;
        const Vec2f at = s.coords.coord[v], turn = patchTurn(s, v);
        for (int k = s.graph.first[v]; k < s.graph.first[v + 1]; ++k) {
            const std::size_t u = std::size_t(s.graph.neighbour[std::size_t(k)]);
            const Vec2f step = s.steps.stepMm[std::size_t(k)];
            // What v's texel has beside it, against what the surface shows there: the sample is not stretched.
            const Vec2f shown = s.coords.coord[u];
            const Vec2f expected = at + Vec2f(turn.x * step.x - turn.y * step.y, turn.y * step.x + turn.x * step.y);
            const double d = double(squaredDistance(show(s, shown), show(s, expected)));
            around += d;
            ++n;
            if (u > v) {
                out[Links] += 1;
                if (s.coords.broken[std::size_t(k)]) {
                    out[Seams] += 1;
                    out[SeamError] += d;
                }
            }
        }
        // The vertex itself shows its texel.
        out[Error] += around / (n + 1);
    });
    q.neighbourhoodError = std::sqrt(sum[Error] / double(std::max<std::size_t>(1, s.graph.size())));
    q.seamRate = sum[Links] > 0 ? sum[Seams] / sum[Links] : 0;
    q.seamError = sum[Seams] > 0 ? std::sqrt(sum[SeamError] / sum[Seams]) : 0;
}

void usage(const Synthesis& s, SynthesisQuality& q) {
    const Exemplar& e = s.exemplar;
    std::vector<double> use(e.texelCount(), 0.0);
    for (std::size_t v = 0; v < s.graph.size(); ++v) {
        // Shared by the four texels around, so that a lattice of samples against that of texels makes no pattern.
        const Vec2f t = inTexels(s, s.coords.coord[v]);
        const double x = double(t.x) - 0.5, y = double(t.y) - 0.5, fx = std::floor(x), fy = std::floor(y);
        for (int c = 0; c < 4; ++c) {
            const double wx = c & 1 ? x - fx : 1 - (x - fx), wy = c & 2 ? y - fy : 1 - (y - fy);
            const int ix = e.wrapX(int(fx) + (c & 1)), iy = e.wrapY(int(fy) + (c >> 1));
            use[std::size_t(iy) * std::size_t(e.width) + std::size_t(ix)] += wx * wy * double(s.graph.area[v]);
        }
    }
    const double total = std::accumulate(use.begin(), use.end(), 0.0), mean = total / double(use.size());
    double entropy = 0;
    for (double u : use) {
        q.reuseMax = std::max(q.reuseMax, u / mean);
        const double p = u / total;
        entropy -= p > 0 ? p * std::log(p) : 0;
    }
    q.reuseEntropy = use.size() > 1 ? entropy / std::log(double(use.size())) : 1;
}

std::size_t texelOf(const Synthesis& s, std::size_t v) {
    const Vec2f t = inTexels(s, s.coords.coord[v]);
    return std::size_t(s.exemplar.wrapY(int(std::floor(t.y)))) * std::size_t(s.exemplar.width) +
           std::size_t(s.exemplar.wrapX(int(std::floor(t.x))));
}

void distributions(const Synthesis& s, SynthesisQuality& q) {
    const Exemplar& e = s.exemplar;
    for (std::size_t p = 0; p < e.parameters.size(); ++p) {
        std::vector<std::pair<float, double>> own, shown;
        for (float value : e.parameters[p]) {
            own.push_back({value, 1.0});
        }
        for (std::size_t v = 0; v < s.graph.size(); ++v) {
            if (s.graph.area[v] > 0) {
                shown.push_back({e.parameters[p][texelOf(s, v)], double(s.graph.area[v])});
            }
        }
        const double d = kolmogorovSmirnov(own, shown);
        q.ksOf.push_back({e.parameterNames[p], d});
        q.ks = std::max(q.ks, d);
    }
    Vec3d mean, shown;
    double area = 0;
    for (const Rgb& r : e.response) {
        mean += Vec3d(r) / double(e.response.size());
    }
    for (std::size_t v = 0; v < s.graph.size(); ++v) {
        shown += Vec3d(e.response[texelOf(s, v)]) * double(s.graph.area[v]);
        area += double(s.graph.area[v]);
    }
    for (int c = 0; c < 3; ++c) {
        const double d = mean[c] > 0 && area > 0 ? shown[c] / area / mean[c] - 1 : 0;
        q.deltaR = std::abs(d) > std::abs(q.deltaR) ? d : q.deltaR;
    }
}

void patches(const Synthesis& s, SynthesisQuality& q) {
    int count = 0;
    const std::vector<int> patch = patchNumbers(s, count);
    std::vector<double> area(std::size_t(count), 0.0);
    for (std::size_t v = 0; v < patch.size(); ++v) {
        area[std::size_t(patch[v])] += double(s.graph.area[v]);
    }
    const double texel = s.exemplar.texelMm.x * s.exemplar.texelMm.y / (s.mmPerUnit * s.mmPerUnit);
    std::sort(area.begin(), area.end());
    const double total = std::accumulate(area.begin(), area.end(), 0.0);
    q.patches = area.size();
    q.patchLargest = area.empty() ? 0 : area.back() / texel;
    double below = 0;
    for (double a : area) {
        below += a;
        if (below >= 0.5 * total) {
            q.patchMedian = a / texel;
            break;
        }
    }
}

void shapes(const Synthesis& s, const ExemplarMap& map, SynthesisQuality& q) {
    enum { Folds, Stretch, Area, Count };
    const std::vector<double> sum =
        orderedSums(s.graph.triangles.size(), Count, [&](std::size_t t, std::vector<double>& out) {
            const Vec3i& tri = s.graph.triangles[t];
            const Vec3d p(s.graph.points[std::size_t(tri.x)]);
            const Vec3d e1 = Vec3d(s.graph.points[std::size_t(tri.y)]) - p,
                        e2 = Vec3d(s.graph.points[std::size_t(tri.z)]) - p;
            const Vec3d x = normalize(e1), n = normalize(cross(e1, e2)), y = cross(n, x);
            const double a = length(e1), b = dot(e2, x), c = dot(e2, y);
            if (!(a * c > 0)) {
                return;
            }
            const Vec2f c0 = map.cornerCoords[3 * t], d1 = map.cornerCoords[3 * t + 1] - c0,
                        d2 = map.cornerCoords[3 * t + 2] - c0;
            const double area = double(d1.x) * double(d2.y) - double(d1.y) * double(d2.x);
            // A sliver narrower than the rounding of its coordinates has no side.
            const double longest = std::max({a, length(e2), length(e2 - e1)});
            const double rounding =
                4e-7 * double(std::max({std::abs(c0.x), std::abs(c0.y), float(map.tileMm.x), float(map.tileMm.y)}));
            out[Folds] += area <= 0 && a * c / longest * s.mmPerUnit > rounding;
            // Jacobian by the triangle's own plane.
            const double ux = double(d1.x) / a, vx = double(d1.y) / a;
            const double uy = (double(d2.x) - ux * b) / c, vy = (double(d2.y) - vx * b) / c;
            const double p1 = std::hypot(ux + vy, vx - uy) / 2, q1 = std::hypot(ux - vy, vx + uy) / 2;
            const double hi = std::log((p1 + q1) / s.mmPerUnit),
                         lo = std::log(std::max(1e-3, std::abs(p1 - q1) / s.mmPerUnit));
            out[Stretch] += 0.5 * (hi * hi + lo * lo) * a * c;
            out[Area] += a * c;
        });
    q.foldOvers = std::size_t(sum[Folds]);
    q.stretch = sum[Area] > 0 ? std::sqrt(sum[Stretch] / sum[Area]) : 0;
}

/// Correlation of reflectance with that at a distance along the surface, in rings of a texel, against the sample's.
double autocorrelationDifference(const Synthesis& s) {
    const Exemplar& e = s.exemplar;
    const int rings = std::min({24, e.width / 2, e.height / 2});
    if (rings < 2) {
        return 0;
    }
    std::vector<double> value(e.texelCount());
    double mean = 0, variance = 0;
    for (std::size_t t = 0; t < value.size(); ++t) {
        value[t] = std::cbrt(double(luminance(e.response[t])));
        mean += value[t] / double(value.size());
    }
    for (double& v : value) {
        v -= mean;
        variance += v * v / double(value.size());
    }
    if (!(variance > 1e-12)) {
        return 0;
    }
    std::vector<double> own(std::size_t(rings), 0.0), ownCount(std::size_t(rings), 0.0);
    for (int dy = -rings; dy <= rings; ++dy) {
        for (int dx = -rings; dx <= rings; ++dx) {
            const int ring = int(std::lround(std::hypot(dx, dy)));
            if (ring >= rings || ring == 0) {
                continue;
            }
            double sum = 0;
            for (int y = 0; y < e.height; ++y) {
                for (int x = 0; x < e.width; ++x) {
                    sum += value[std::size_t(y) * std::size_t(e.width) + std::size_t(x)] *
                           value[std::size_t(e.wrapY(y + dy)) * std::size_t(e.width) + std::size_t(e.wrapX(x + dx))];
                }
            }
            own[std::size_t(ring)] += sum / double(value.size());
            ownCount[std::size_t(ring)] += 1;
        }
    }
    // Vertices at random, and what surrounds them by the shortest way.
    // (fewer where each has many vertices around it)
    const double crowd = std::clamp(double(s.graph.size()) * e.texelMm.x * e.texelMm.y /
                                        (s.graph.totalArea() * s.mmPerUnit * s.mmPerUnit),
                                    1.0, 10.0);
    const std::size_t tries = std::min<std::size_t>(std::size_t(3000 / crowd), s.graph.size());
    const double texel = std::max(e.texelMm.x, e.texelMm.y);
    std::vector<double> sum(std::size_t(rings), 0.0), count(std::size_t(rings), 0.0);
    std::vector<float> distance(s.graph.size(), 1e30f);
    std::vector<int> touched;
    using Item = std::pair<float, int>;
    for (std::size_t i = 0; i < tries; ++i) {
        const int from = int(hash32(0x6175746full, i) % s.graph.size());
        std::priority_queue<Item, std::vector<Item>, std::greater<Item>> queue;
        distance[std::size_t(from)] = 0;
        touched.assign(1, from);
        queue.push({0.0f, from});
        const double at = value[texelOf(s, std::size_t(from))];
        while (!queue.empty()) {
            const auto [d, v] = queue.top();
            queue.pop();
            if (d > distance[std::size_t(v)]) {
                continue;
            }
            // Ways along links are longer than straight ones: rings by the distance in space.
            const double straight = double(length(s.graph.points[std::size_t(v)] - s.graph.points[std::size_t(from)])) *
                                    s.mmPerUnit / texel;
            const int ring = int(std::lround(straight));
            if (ring > 0 && ring < rings) {
                sum[std::size_t(ring)] += at * value[texelOf(s, std::size_t(v))];
                count[std::size_t(ring)] += 1;
            }
            for (int k = s.graph.first[std::size_t(v)]; k < s.graph.first[std::size_t(v) + 1]; ++k) {
                const int u = s.graph.neighbour[std::size_t(k)];
                const Vec2f step = s.steps.stepMm[std::size_t(k)];
                const float next = d + std::sqrt(step.x * step.x + step.y * step.y) / float(texel);
                if (next < 1.2f * float(rings) && next < distance[std::size_t(u)]) {
                    if (distance[std::size_t(u)] > 1e29f) {
                        touched.push_back(u);
                    }
                    distance[std::size_t(u)] = next;
                    queue.push({next, u});
                }
            }
        }
        for (int v : touched) {
            distance[std::size_t(v)] = 1e30f;
        }
    }
    double worst = 0;
    for (std::size_t r = 1; r < std::size_t(rings); ++r) {
        if (count[r] > 100 && ownCount[r] > 0) {
            worst = std::max(worst, std::abs(sum[r] / count[r] - own[r] / ownCount[r]) / variance);
        }
    }
    return worst;
}

} // namespace

double kolmogorovSmirnov(std::vector<std::pair<float, double>>& a, std::vector<std::pair<float, double>>& b) {
    const auto total = [](const std::vector<std::pair<float, double>>& v) {
        double sum = 0;
        for (const auto& p : v) {
            sum += p.second;
        }
        return sum;
    };
    const double totalA = total(a), totalB = total(b);
    if (!(totalA > 0 && totalB > 0)) {
        return a.empty() == b.empty() ? 0 : 1;
    }
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    double worst = 0, sumA = 0, sumB = 0;
    for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
        const float at = std::min(a[i].first, b[j].first);
        while (i < a.size() && a[i].first == at) {
            sumA += a[i++].second;
        }
        while (j < b.size() && b[j].first == at) {
            sumB += b[j++].second;
        }
        worst = std::max(worst, std::abs(sumA / totalA - sumB / totalB));
    }
    return worst;
}

std::vector<int> patchNumbers(const Synthesis& s, int& count) {
    std::vector<int> patch(s.graph.size(), -1), stack;
    count = 0;
    for (std::size_t start = 0; start < patch.size(); ++start) {
        if (patch[start] >= 0) {
            continue;
        }
        patch[start] = count;
        stack.push_back(int(start));
        while (!stack.empty()) {
            const std::size_t v = std::size_t(stack.back());
            stack.pop_back();
            for (int k = s.graph.first[v]; k < s.graph.first[v + 1]; ++k) {
                const std::size_t u = std::size_t(s.graph.neighbour[std::size_t(k)]);
                if (patch[u] < 0 && !s.coords.broken[std::size_t(k)]) {
                    patch[u] = count;
                    stack.push_back(int(u));
                }
            }
        }
        ++count;
    }
    return patch;
}

SynthesisQuality measure(const Synthesis& s, const ExemplarMap& map) {
    SynthesisQuality q;
    q.samples = s.graph.size();
    q.texelsPerSample = s.graph.totalArea() * s.mmPerUnit * s.mmPerUnit /
                        (s.exemplar.texelMm.x * s.exemplar.texelMm.y) / double(std::max<std::size_t>(1, q.samples));
    q.exemplarError = s.exemplar.ownError;
    links(s, q);
    usage(s, q);
    distributions(s, q);
    patches(s, q);
    shapes(s, map, q);
    q.autocorrelation = autocorrelationDifference(s);
    q.deltaRSeams = seamLight(s.graph, s.steps, s.coords, s.exemplar);
    q.singularities = s.singularities.size();
    for (const Singularity& i : s.singularities) {
        q.indexSum += i.index;
    }
    return q;
}

} // namespace stf
