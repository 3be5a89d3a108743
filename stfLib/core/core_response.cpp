// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/core_response.h"

#include "stfLib/base/parallel.h"
#include "stfLib/core/core_walk.h"
#include "stfLib/core/local_thickness.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::size_t kMaxTermBytes = std::size_t(400) << 20;
constexpr float kThin = 3, kThick = 5; ///< spread lengths between which walks give way to dipoles
constexpr std::size_t kMostWalks = 512, kLeastWalks = 24;
constexpr float kFar = 0.7f;    ///< of the thickness: walks that end farther away are averaged
constexpr float kSmooth = 0.6f; ///< of the thickness: the radius within which
constexpr float kLeastSpacings = 2.5f, kSmoothSpacings = 4.5f; ///< that radius at least and at most
constexpr std::size_t kGrain = 32;

// A sample stands for a disc of its area. Far away the disc is a point; at its own place the kernel's mean over the
// disc is far below its peak. A softened distance r^2 + e^2 meets both: e is where area * kernel equals the disc
// integral.
float softening(const Dipole& dipole, double area) {
    const double wanted = dipole.discIntegral(std::sqrt(area / kPi)) / area;
    double lo = 0, hi = area;
    for (int i = 0; i < 60; ++i) {
        const double mid = 0.5 * (lo + hi);
        (double(dipole.kernel(float(mid))) > wanted ? lo : hi) = mid;
    }
    return float(0.5 * (lo + hi));
}

Vec3f unitNormal(const CoreBoundary& b, const TrianglePlace& p) {
    const Vec3i& t = b.triangles[p.triangle];
    const Vec3f smooth = pointAt(b.normals, t, p);
    const Vec3d corner(b.points[std::size_t(t.x)]);
    const Vec3f facet(
        normalize(cross(Vec3d(b.points[std::size_t(t.y)]) - corner, Vec3d(b.points[std::size_t(t.z)]) - corner)));
    // The boundary's own facet, but for what has no area; turned as the surface is where the boundary folds over.
    const Vec3f n = isFinite(facet) && dot(facet, facet) > 0.5f ? facet : normalize(smooth);
    return dot(n, smooth) < 0 ? -n : n;
}

float smoothStep(float x) {
    const float t = std::clamp(x, 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

} // namespace

double CoreResponse::spreadLength(double sigmaA, double sigmaSPrime) {
    const double total = sigmaA + sigmaSPrime;
    const double transport = std::sqrt(3 * sigmaA * total);
    return std::max(transport > 0 ? 1 / transport : 1e30, total > 0 ? 1 / total : 1e30);
}

void CoreResponse::prepare(const CoreMaterial& m) {
    double area = 0;
    for (float a : samples_.areas) {
        area += double(a);
    }
    for (int c = 0; c < 3; ++c) {
        dipoles_.emplace_back(m.sigmaA[c], m.sigmaSPrime[c]);
        kernels_.present[c] = m.sigmaSPrime[c] > 0;
        largestAlbedo_ = std::max(largestAlbedo_, float(dipoles_.back().diffuseAlbedo()));
        if (kernels_.present[c] && area > 0) {
            kernels_.soften2[c] = softening(dipoles_.back(), area / double(samples_.areas.size()));
        }
    }
    kernels_.dipoles = dipoles_.data();
    tree_ = SampleTree(samples_.positions, samples_.areas);
}

CoreResponse::CoreResponse(const CoreMaterial& material, const SurfacePoints& samples, float epsilon)
    : samples_(samples), epsilon_(epsilon) {
    prepare(material);
    Progress progress;
    listTerms(progress);
}

CoreResponse::CoreResponse(const CoreMaterial& material, const CoreBoundary& b, CoreModel model, std::uint64_t seed,
                           Progress& progress, std::size_t walks, float epsilon)
    : epsilon_(epsilon), walkBudget_(walks) {
    samples_.areas = b.samples.areas(b.points, b.triangles);
    for (float& a : samples_.areas) {
        a *= float(b.mmPerUnit * b.mmPerUnit);
    }
    for (const TrianglePlace& p : b.samples.places) {
        samples_.positions.push_back(pointAt(b.points, b.triangles[p.triangle], p) * float(b.mmPerUnit));
        samples_.normals.push_back(unitNormal(b, p));
    }
    prepare(material);
    if (model != CoreModel::Dipole) {
        chooseWalks(material, b, model);
        walk(material, b, seed, progress);
    }
    listTerms(progress);
    if (!walked_.empty()) {
        for (const Rgb& total : apply(std::vector<Rgb>(samples_.positions.size(), Rgb(1.0f)))) {
            largestAlbedo_ = std::max(largestAlbedo_, maxComponent(total));
        }
    }
}

SampleTree::Kernels CoreResponse::kernelsOf(std::size_t i) const {
    SampleTree::Kernels k = kernels_;
    for (int c = 0; c < 3; ++c) {
        k.present[c] = k.present[c] && (walkShare_.empty() || walkShare_[i][c] < 1);
    }
    return k;
}

bool CoreResponse::needsDipole(std::size_t i) const {
    const SampleTree::Kernels k = kernelsOf(i);
    return k.present[0] || k.present[1] || k.present[2];
}

void CoreResponse::listTerms(Progress& progress) {
    const std::size_t n = samples_.positions.size();
    std::vector<std::vector<SampleTree::Term>> blocks((n + kGrain - 1) / kGrain);
    firstTerm_.assign(n + 1, 0);
    const auto row = [&](std::size_t i, std::vector<SampleTree::Term>& terms) {
        Vec3d total;
        terms.clear();
        if (!needsDipole(i)) {
            return;
        }
        tree_.terms(samples_.positions[i], kernelsOf(i), epsilon_, terms, total);
        for (SampleTree::Term& t : terms) {
            for (int c = 0; c < 3; ++c) {
                const double scale = total[c] > 0 ? dipoles_[std::size_t(c)].diffuseAlbedo() / total[c] : 0.0;
                t.kernel[c] = float(double(t.kernel[c]) * scale);
            }
        }
    };
    // Some rows tell how long all will be.
    std::size_t some = 0, count = 0;
    std::vector<SampleTree::Term> probe;
    for (std::size_t i = 0; i < n; i += std::max<std::size_t>(1, n / 64)) {
        row(i, probe);
        count += probe.size();
        ++some;
    }
    if (some == 0 || double(count) / double(some) * double(n) * double(sizeof(probe[0])) > double(kMaxTermBytes)) {
        firstTerm_.clear();
        return;
    }
    parallelFor(n, kGrain, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) {
            throw Cancelled();
        }
        std::vector<SampleTree::Term> terms;
        for (std::size_t i = begin; i < end; ++i) {
            row(i, terms);
            blocks[begin / kGrain].insert(blocks[begin / kGrain].end(), terms.begin(), terms.end());
            firstTerm_[i + 1] = terms.size();
        }
    });
    for (std::size_t i = 0; i < n; ++i) {
        firstTerm_[i + 1] += firstTerm_[i];
    }
    terms_.reserve(firstTerm_.back());
    for (std::vector<SampleTree::Term>& b : blocks) {
        terms_.insert(terms_.end(), b.begin(), b.end());
        std::vector<SampleTree::Term>().swap(b);
    }
}

void CoreResponse::chooseWalks(const CoreMaterial& m, const CoreBoundary& b, CoreModel model) {
    const std::size_t n = samples_.positions.size();
    walkShare_.assign(n, Rgb(0.0f));
    thickness_.assign(n, 0.0f);
    Rgb lengths;
    for (int c = 0; c < 3; ++c) {
        lengths[c] = float(spreadLength(m.sigmaA[c], m.sigmaSPrime[c]));
    }
    parallelFor(n, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const TrianglePlace& p = b.samples.places[i];
            const Vec3f point = pointAt(b.points, b.triangles[p.triangle], p);
            thickness_[i] = localThickness(b.mesh, point, -samples_.normals[i]) * float(b.mmPerUnit);
            for (int c = 0; c < 3; ++c) {
                const float thin = std::isfinite(thickness_[i])
                                       ? 1 - smoothStep((thickness_[i] / lengths[c] - kThin) / (kThick - kThin))
                                       : 0.0f;
                walkShare_[i][c] = model == CoreModel::Walk ? 1.0f : thin;
            }
        }
    });
}

void CoreResponse::walk(const CoreMaterial& m, const CoreBoundary& b, std::uint64_t seed, Progress& progress) {
    const std::size_t n = samples_.positions.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (isWalked(i)) {
            walked_.push_back(std::uint32_t(i));
        }
    }
    if (walked_.empty()) {
        return;
    }
    const CoreWalk walks(m, b.mesh, b.mmPerUnit);
    walksPerSample_ = std::clamp(walkBudget_ / (walked_.size() * walks.groups().size()), kLeastWalks, kMostWalks);
    double area = 0;
    for (float a : samples_.areas) {
        area += double(a);
    }
    const float spacing = float(std::sqrt(area / double(n)));
    const NearestSample nearest(samples_, 1.5f * spacing);
    struct Rows {
        std::vector<WalkTerm> near, far;
    };
    std::vector<Rows> blocks((walked_.size() + kGrain - 1) / kGrain);
    firstNear_.assign(n + 1, 0);
    firstFar_.assign(n + 1, 0);
    const auto add = [](std::vector<WalkTerm>& ends, std::vector<WalkTerm>& out) {
        std::sort(ends.begin(), ends.end(), [](const WalkTerm& x, const WalkTerm& y) { return x.sample < y.sample; });
        const std::size_t before = out.size();
        for (const WalkTerm& e : ends) {
            if (out.size() > before && out.back().sample == e.sample) {
                out.back().weight += e.weight;
            } else {
                out.push_back(e);
            }
        }
        return out.size() - before;
    };
    parallelFor(walked_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) {
            throw Cancelled();
        }
        Rows& rows = blocks[begin / kGrain];
        std::vector<WalkTerm> near, far;
        for (std::size_t w = begin; w < end; ++w) {
            const std::size_t i = walked_[w];
            near.clear();
            far.clear();
            const std::uint32_t first = b.samples.firstPart[i], parts = b.samples.firstPart[i + 1] - first;
            for (std::size_t g = 0; g < walks.groups().size(); ++g) {
                const CoreWalk::Group& group = walks.groups()[g];
                bool wanted = false;
                for (int c = 0; c < 3; ++c) {
                    wanted |= group.channel[c] && walkShare_[i][c] > 0;
                }
                for (std::size_t k = 0; wanted && k < walksPerSample_; ++k) {
                    CounterRng rng(seed ^ 0x77616c6b73ull, (std::uint64_t(i) * 4 + g) << 20 | k);
                    // From everywhere in the sample's part alike.
                    const TrianglePlace& p = b.samples.parts[first + std::uint32_t(k) % parts];
                    const Vec3f from = pointAt(b.points, b.triangles[p.triangle], p), normal = unitNormal(b, p);
                    const CoreWalk::Exit exit = walks.walk(group, from, -normal, p.triangle, rng);
                    if (!exit.left) {
                        continue;
                    }
                    const Vec3f out = normalize(exit.normal);
                    const std::uint32_t j = nearest.find(exit.point * float(b.mmPerUnit), out);
                    const bool away =
                        length(exit.point - from) * float(b.mmPerUnit) > kFar * thickness_[i] || dot(out, normal) < 0;
                    (away ? far : near).push_back({j, exit.weight / float(walksPerSample_)});
                }
            }
            firstNear_[i + 1] = add(near, rows.near);
            firstFar_[i + 1] = add(far, rows.far);
        }
    });
    for (std::size_t i = 0; i < n; ++i) {
        firstNear_[i + 1] += firstNear_[i];
        firstFar_[i + 1] += firstFar_[i];
    }
    for (const Rows& r : blocks) {
        near_.insert(near_.end(), r.near.begin(), r.near.end());
        far_.insert(far_.end(), r.far.begin(), r.far.end());
    }

    std::vector<Rgb> totals(n, Rgb(0.0f));
    for (std::uint32_t i : walked_) {
        for (std::size_t k = firstNear_[i]; k < firstNear_[i + 1]; ++k) {
            totals[i] += near_[k].weight;
        }
        for (std::size_t k = firstFar_[i]; k < firstFar_[i + 1]; ++k) {
            totals[i] += far_[k].weight;
        }
    }
    shareFarWalks();

    // What comes from far away is smooth over a part of the thickness: neighbours share their walks, weighted by area,
    // so that the noise of a sample's own area drops out.
    SurfacePoints from;
    std::vector<float> radii;
    for (std::uint32_t i : walked_) {
        from.positions.push_back(samples_.positions[i]);
        from.normals.push_back(samples_.normals[i]);
        from.areas.push_back(samples_.areas[i]);
        radii.push_back(std::clamp(kSmooth * thickness_[i], kLeastSpacings * spacing, kSmoothSpacings * spacing));
    }
    smooth_ = SampleFilter(from, from.positions, from.normals, radii);
    scaleWalks(totals);
}

Rgb CoreResponse::walkedExitance(std::size_t w, const std::vector<Rgb>& irradiance, const std::vector<Rgb>& far) const {
    const std::size_t i = walked_[w];
    Rgb sum = smooth_.at(w, far);
    for (std::size_t k = firstNear_[i]; k < firstNear_[i + 1]; ++k) {
        sum += near_[k].weight * irradiance[near_[k].sample];
    }
    return sum;
}

std::vector<Rgb> CoreResponse::farExitance(const std::vector<Rgb>& irradiance) const {
    std::vector<Rgb> far(walked_.size(), Rgb(0.0f));
    parallelFor(walked_.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t w = begin; w < end; ++w) {
            const std::size_t i = walked_[w];
            for (std::size_t k = firstFar_[i]; k < firstFar_[i + 1]; ++k) {
                far[w] += far_[k].weight * irradiance[far_[k].sample];
            }
        }
    });
    return far;
}

// How much light comes back at all, a sample's own walks know well: without absorption exactly. How many of them ended
// near and far is chance, which must not show under even light.
void CoreResponse::scaleWalks(const std::vector<Rgb>& ownTotals) {
    const std::vector<Rgb> one(samples_.positions.size(), Rgb(1.0f)), far = farExitance(one);
    walkScale_.assign(walked_.size(), Rgb(1.0f));
    for (std::size_t w = 0; w < walked_.size(); ++w) {
        const Rgb told = walkedExitance(w, one, far);
        for (int c = 0; c < 3; ++c) {
            walkScale_[w][c] = told[c] > 0 ? ownTotals[walked_[w]][c] / told[c] : 0.0f;
        }
    }
}

// K_ij A_i = K_ji A_j: walks from j that end at i say as much about row i as its own. Of light from far away, of which
// there are few, the mean of both has half the variance; where j has no walks of a channel, the row's own count.
void CoreResponse::shareFarWalks() {
    const std::size_t n = samples_.positions.size();
    const auto both = [&](std::size_t i, std::size_t j) {
        Rgb half(1.0f);
        for (int c = 0; c < 3; ++c) {
            half[c] = walkShare_[i][c] > 0 && walkShare_[j][c] > 0 ? 0.5f : 1.0f;
        }
        return half;
    };
    std::vector<std::size_t> first(n + 1, 0);
    for (std::uint32_t i : walked_) {
        for (std::size_t k = firstFar_[i]; k < firstFar_[i + 1]; ++k) {
            ++first[i + 1];
            first[far_[k].sample + 1] += isWalked(far_[k].sample) ? 1 : 0;
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        first[i + 1] += first[i];
    }
    std::vector<WalkTerm> shared(first.back());
    std::vector<std::size_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t i : walked_) {
        for (std::size_t k = firstFar_[i]; k < firstFar_[i + 1]; ++k) {
            const WalkTerm& t = far_[k];
            const Rgb half = both(i, t.sample);
            shared[next[i]++] = {t.sample, t.weight * half};
            if (isWalked(t.sample)) {
                // Nothing of channels that do not walk at one of both ends.
                const Rgb back = (Rgb(1.0f) - half) * (samples_.areas[i] / samples_.areas[t.sample]);
                shared[next[t.sample]++] = {i, t.weight * back};
            }
        }
    }
    far_ = std::move(shared);
    firstFar_ = std::move(first);
}

std::vector<Rgb> CoreResponse::apply(const std::vector<Rgb>& irradiance) const {
    const std::size_t n = samples_.positions.size();
    const std::vector<Rgb> sums = tree_.itemSums(irradiance);
    const std::vector<Rgb> far = farExitance(irradiance);
    std::vector<Rgb> out(n);
    parallelFor(n, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Vec3d sum(0.0);
            if (!firstTerm_.empty()) {
                for (std::size_t k = firstTerm_[i]; k < firstTerm_[i + 1]; ++k) {
                    sum += Vec3d(terms_[k].kernel * sums[terms_[k].item]);
                }
                out[i] = Rgb(sum);
            } else if (needsDipole(i)) {
                out[i] = gather(samples_.positions[i], kernelsOf(i), sums, epsilon_);
            }
        }
    });
    parallelFor(walked_.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t w = begin; w < end; ++w) {
            const std::size_t i = walked_[w];
            const Rgb walked = walkedExitance(w, irradiance, far) * walkScale_[w];
            out[i] = out[i] * (Rgb(1.0f) - walkShare_[i]) + walked * walkShare_[i];
        }
    });
    return out;
}

Rgb CoreResponse::dipoleExitance(const Vec3f& place, const std::vector<Rgb>& sums, float epsilon) const {
    return gather(place, kernels_, sums, epsilon);
}

Rgb CoreResponse::gather(const Vec3f& place, const SampleTree::Kernels& kernels, const std::vector<Rgb>& sums,
                         float epsilon) const {
    thread_local std::vector<SampleTree::Term> terms;
    Vec3d total, sum(0.0);
    tree_.terms(place, kernels, epsilon, terms, total);
    for (const SampleTree::Term& t : terms) {
        sum += Vec3d(t.kernel) * Vec3d(sums[t.item]);
    }
    Rgb result(0.0f);
    for (int c = 0; c < 3; ++c) {
        if (total[c] > 0) {
            result[c] = float(dipoles_[std::size_t(c)].diffuseAlbedo() * sum[c] / total[c]);
        }
    }
    return result;
}

std::size_t CoreResponse::walkedSamples() const {
    return walked_.size();
}

std::size_t CoreResponse::bytes() const {
    return terms_.size() * sizeof(terms_[0]) + (near_.size() + far_.size()) * sizeof(WalkTerm) + smooth_.bytes() +
           (firstTerm_.size() + firstNear_.size() + firstFar_.size()) * sizeof(std::size_t);
}

} // namespace stf
