// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/walk.h"

#include "stfLib/base/random.h"
#include "stfLib/optics/fresnel.h"
#include "stfLib/optics/phase.h"
#include "stfLib/transport/lane_walk.h"
#include "stfLib/transport/walk_limits.h"

#include <algorithm>
#include <numeric>

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
using walk_limits::kMaxSurfaces, walk_limits::kRouletteBelow, walk_limits::kRouletteTo;

void addTo(std::vector<double>& a, const std::vector<double>& b) {
    if (a.empty()) {
        a = b;
        return;
    }
    for (std::size_t i = 0; i < b.size(); ++i) {
        a[i] += b[i];
    }
}

Vec3f uniformSphere(float u1, float u2) {
    const float z = 1 - 2 * u1, r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(2 * kPi * u2), r * std::sin(2 * kPi * u2), z};
}

bool fromBelow(const WalkSource& s) {
    return s.kind == WalkSource::Kind::DiffuseBelow;
}

// Voxels of an emitting medium, chosen by their mean emission.
struct EmissionSampler {
    std::vector<double> sum;
    EmissionSampler(const TileMedium& m, const WalkSource& s) {
        double total = 0;
        const std::size_t count = s.kind == WalkSource::Kind::Emission && m.emits() ? m.voxelCount() : 0;
        for (std::size_t i = 0; i < count; ++i) {
            total += double(average(m.emission(i))) * double(m.fill(i));
            sum.push_back(total);
        }
    }
    std::size_t pick(double u) const {
        const double at = u * sum.back();
        return std::min<std::size_t>(sum.size() - 1,
                                     std::size_t(std::upper_bound(sum.begin(), sum.end(), at) - sum.begin()));
    }
};

} // namespace

void WalkTally::add(const WalkTally& o) {
    photons += o.photons;
    components = std::max(components, o.components);
    addTo(collided, o.collided);
    addTo(uncollided, o.uncollided);
    addTo(below, o.below);
    addTo(belowUncollided, o.belowUncollided);
    addTo(belowUncollidedCosine, o.belowUncollidedCosine);
    addTo(radiance, o.radiance);
    above += o.above;
    specular += o.specular;
    absorbed += o.absorbed;
    roulette += o.roulette;
    aboveSquared += o.aboveSquared;
    belowSquared += o.belowSquared;
    absorbedSquared += o.absorbedSquared;
    collisions += o.collisions;
    lost += o.lost;
}

/// One photon after the other through one medium. Channels: 3 where one walk carries rgb, else 1.
class Walker {
public:
    Walker(const TileMedium& medium, const WalkSource& source, const WalkRequest& request, WalkTally& tally)
        : m_(medium), source_(source), request_(request), tally_(tally), tracer_(medium.size_),
          perMm_(1 / medium.voxelMm_.x, 1 / medium.voxelMm_.y, 1 / medium.voxelMm_.z), size_(medium.size_),
          emission_(medium, source), collided_(tally.collided.size()), uncollided_(tally.uncollided.size()),
          flushEvery_(std::max<std::size_t>(65536, 4 * medium.voxelCount())) {
        // A flight this long has crossed the tile a hundred thousand times: it is parallel to the layers, in a void.
        endless_ = 1e5 * std::max(m_.voxelMm_.z * m_.size_.z, m_.voxelMm_.x * m_.size_.x);
    }

    template<int Channels, int Components>
    void run(int channel, const Progress& progress) {
        flushed_ = tally_.collisions + request_.first;
        for (std::uint64_t photon = request_.first; photon < request_.first + request_.count; ++photon) {
            if ((photon & 0xff) == 0 && progress.cancelled()) {
                throw Cancelled();
            }
            walk<Channels, Components>(photon, channel);
            if (Components > 0 && tally_.collisions + photon - flushed_ > flushEvery_) {
                flush();
                flushed_ = tally_.collisions + photon;
            }
        }
        flush();
    }

private:
    // Tracks are summed in float, which halves the memory that flights touch, and into double before rounding counts.
    void flush() {
        const auto move = [](std::vector<float>& from, std::vector<double>& to) {
            for (std::size_t i = 0; i < from.size(); ++i) {
                to[i] += double(from[i]);
            }
            std::fill(from.begin(), from.end(), 0.0f);
        };
        move(collided_, tally_.collided);
        move(uncollided_, tally_.uncollided);
    }

    // What a photon is at the moment.
    template<int Channels>
    struct Photon {
        Vec3d position;     // voxel units
        Vec3f direction;    // z inward
        Vec3f axisX, axisY; // the horizontal axes fluxes are tallied along
        double weight[Channels];
        bool collided = false, inside = true, entered = false;
        int surfaces = 0; // met since the last collision
        // Totals of this photon, for the squares.
        double above[Channels] = {}, below[Channels] = {}, absorbed[Channels] = {};
    };

    template<int Channels>
    bool start(Photon<Channels>& p, CounterRng& rng, int channel);
    template<int Channels, int Components>
    void walk(std::uint64_t photon, int channel);
    template<int Channels>
    bool leaveThrough(Photon<Channels>& p, bool top, int column, CounterRng& rng, int channel);
    template<int Channels>
    bool trapped(Photon<Channels>& p, int channel);
    template<int Channels>
    bool meetSurface(Photon<Channels>& p, CounterRng& rng);
    template<int Channels>
    bool survives(Photon<Channels>& p, CounterRng& rng, int channel);
    template<int Channels>
    void see(const Photon<Channels>& p, float g, int channel);
    template<int Channels>
    void score(Photon<Channels>& p, bool top, int column, double share, int channel);

    int columnOf(const Vec3d& p) const {
        return TileTracer::wrap(int(std::floor(p.x)), m_.size_.x) +
               m_.size_.x * TileTracer::wrap(int(std::floor(p.y)), m_.size_.y);
    }

    const TileMedium& m_;
    const WalkSource& source_;
    const WalkRequest& request_;
    WalkTally& tally_;
    const TileTracer tracer_;
    const Vec3d perMm_, size_;
    const EmissionSampler emission_;
    std::vector<float> collided_, uncollided_; // as in WalkTally
    const std::uint64_t flushEvery_;           // flights: by number, not by photon, one may take a million
    std::uint64_t flushed_ = 0;
    double endless_;
};

// Adds the share of a photon's weight that leaves.
template<int Channels>
void Walker::score(Photon<Channels>& p, bool top, int column, double share, int channel) {
    double* const out = (p.collided ? tally_.below : tally_.belowUncollided).data() + std::size_t(column) * 3;
    for (int c = 0; c < Channels; ++c) {
        const int rgb = Channels == 1 ? channel : c;
        const double w = p.weight[c] * share;
        if (top) {
            p.above[c] += w;
            if (!p.entered && !p.collided) {
                tally_.specular[rgb] += w;
            }
        } else {
            p.below[c] += w;
            out[rgb] += w;
            if (!p.collided) {
                tally_.belowUncollidedCosine[std::size_t(column) * 3 + std::size_t(rgb)] +=
                    w * double(std::abs(p.direction.z));
            }
        }
    }
}

// Unbiased roulette on small weights; what it takes and gives is kept, so that books balance photon by photon.
template<int Channels>
bool Walker::survives(Photon<Channels>& p, CounterRng& rng, int channel) {
    const double largest = *std::max_element(p.weight, p.weight + Channels);
    if (largest >= kRouletteBelow) {
        return true;
    }
    const double survive = largest / kRouletteTo;
    const bool alive = double(rng.uniform()) < survive;
    for (int c = 0; c < Channels; ++c) {
        const double after = alive ? p.weight[c] / survive : 0.0;
        tally_.roulette[Channels == 1 ? channel : c] += p.weight[c] - after;
        p.weight[c] = after;
    }
    return alive;
}

// Counts an interface; drops a walk that met too many.
template<int Channels>
bool Walker::trapped(Photon<Channels>& p, int channel) {
    if (++p.surfaces <= kMaxSurfaces) {
        return false;
    }
    ++tally_.lost;
    for (int c = 0; c < Channels; ++c) {
        tally_.roulette[Channels == 1 ? channel : c] += p.weight[c];
    }
    return true;
}

// Puts a photon at its start, through the interface if there is one. False where it ends there.
template<int Channels>
bool Walker::start(Photon<Channels>& p, CounterRng& rng, int channel) {
    std::fill(p.weight, p.weight + Channels, 1.0);
    p.axisX = {1, 0, 0};
    p.axisY = {0, 1, 0};
    if (source_.kind == WalkSource::Kind::Emission) {
        const double coarse = double(rng.uniform()); // more voxels than a float has values may emit
        const std::size_t i = emission_.pick(coarse + double(rng.uniform()) * 0x1p-24);
        const std::size_t nx = std::size_t(m_.size_.x), ny = std::size_t(m_.size_.y);
        const Vec3d corner(double(i % nx), double(i / nx % ny), double(i / nx / ny));
        for (int tries = 0; tries < 64; ++tries) {
            p.position = corner + Vec3d(double(rng.uniform()), double(rng.uniform()), double(rng.uniform()));
            if (!m_.hasSurface() || m_.surface_.inside(Vec3f(p.position))) {
                break;
            }
        }
        const float u = rng.uniform();
        p.direction = uniformSphere(u, rng.uniform());
        const Rgb& e = m_.emission_[i];
        for (int c = 0; c < Channels; ++c) {
            p.weight[c] = double(e[Channels == 1 ? channel : c]) / double(average(e));
        }
        p.entered = true;
        return true;
    }

    const bool below = fromBelow(source_);
    const double x = double(rng.uniform()) * size_.x;
    const double y = double(rng.uniform()) * size_.y;
    p.position = {x, y, below ? size_.z : 0.0};
    const Vec3f& l = source_.towardsLight;
    switch (source_.kind) {
    case WalkSource::Kind::AnyAzimuth: {
        const float s = std::sqrt(std::max(0.0f, 1 - l.z * l.z)), phi = 2 * kPi * rng.uniform();
        const float cx = std::cos(phi), sx = std::sin(phi);
        p.direction = {s * cx, s * sx, l.z};
        // Radial is towards the light, tangential to its left.
        p.axisX = {-cx, -sx, 0};
        p.axisY = {sx, -cx, 0};
        break;
    }
    case WalkSource::Kind::DiffuseTop:
    case WalkSource::Kind::DiffuseBelow: {
        // Cosine-distributed, as uniform radiance enters.
        const float u = rng.uniformPositive(), r = std::sqrt(1 - u), phi = 2 * kPi * rng.uniform();
        p.direction = {r * std::cos(phi), r * std::sin(phi), below ? -std::sqrt(u) : std::sqrt(u)};
        break;
    }
    default:
        p.direction = {-l.x, -l.y, l.z};
    }

    p.inside = !m_.hasSurface() || m_.surface_.inside(Vec3f(p.position));
    if (!m_.refracts_ || !p.inside || (below && !m_.openBottom_)) {
        p.entered = p.inside;
        return true;
    }
    const float n = m_.ior(Vec3f(p.position)), cosine = std::abs(p.direction.z);
    const FresnelSplit split = fresnel(cosine, n);
    if (request_.analog) {
        if (rng.uniform() < split.reflectance) {
            score(p, !below, columnOf(p.position), 1, channel);
            return false;
        }
    } else {
        score(p, !below, columnOf(p.position), double(split.reflectance), channel);
        for (double& w : p.weight) {
            w *= 1 - double(split.reflectance);
        }
    }
    p.direction = refract(p.direction, Vec3f(0, 0, below ? 1.0f : -1.0f), n, split);
    p.entered = true;
    return split.cosT > 0;
}

// At the top or the bottom: what leaves is scored, what is reflected goes on. False where nothing goes on.
template<int Channels>
bool Walker::leaveThrough(Photon<Channels>& p, bool top, int column, CounterRng& rng, int channel) {
    const bool interface = m_.refracts_ && p.inside && (top || m_.openBottom_);
    if (!interface) {
        score(p, top, column, 1, channel);
        return false;
    }
    const FresnelSplit split = fresnel(std::abs(p.direction.z), 1 / m_.ior(Vec3f(p.position)));
    if (request_.analog) {
        if (rng.uniform() >= split.reflectance) {
            score(p, top, column, 1, channel);
            return false;
        }
    } else {
        score(p, top, column, 1 - double(split.reflectance), channel);
        for (double& w : p.weight) {
            w *= double(split.reflectance);
        }
        if (!survives(p, rng, channel)) {
            return false;
        }
    }
    p.direction.z = -p.direction.z;
    return !trapped(p, channel);
}

// At the relief's surface, on the way in or out: reflected or refracted, by chance.
template<int Channels>
bool Walker::meetSurface(Photon<Channels>& p, CounterRng& rng) {
    const Vec3f at(p.position);
    const Vec3f normal = m_.surface_.normal(at); // z inward, as of the direction
    // The index is that of the material, half a voxel inside.
    const float index = m_.ior(at - normal * 0.5f);
    const float eta = p.inside ? 1 / index : index;
    const Vec3f facing = p.inside ? -normal : normal; // on the side the light comes from
    const float cosine = -dot(p.direction, facing);
    if (cosine <= 0) {
        // Grazing, the interpolated normal leans the other way: it passes.
        p.inside = !p.inside;
        p.entered = true;
        return true;
    }
    const FresnelSplit split = fresnel(cosine, eta);
    if (rng.uniform() < split.reflectance) {
        p.direction = reflect(p.direction, facing);
    } else {
        p.direction = refract(p.direction, facing, eta, split);
        p.inside = !p.inside;
        p.entered = true;
    }
    return true;
}

// What a collision sends towards the viewer (next-event estimation), at the column where it leaves.
template<int Channels>
void Walker::see(const Photon<Channels>& p, float g, int channel) {
    const Vec3f& v = request_.towardsViewer;
    const Rgb transmittance = exp(-m_.opticalDepth(Vec3f(p.position), v));
    const float phase = henyeyGreenstein(g, p.direction, {v.x, v.y, -v.z});
    const double way = p.position.z * m_.voxelMm_.z / double(v.z); // mm
    Vec3d exit = p.position;
    exit.x += double(v.x) * way * perMm_.x;
    exit.y += double(v.y) * way * perMm_.y;
    double* const out = tally_.radiance.data() + std::size_t(columnOf(exit)) * 3;
    for (int c = 0; c < Channels; ++c) {
        const int rgb = Channels == 1 ? channel : c;
        // Flux through a column's top is radiance times its area times the cosine.
        out[rgb] += p.weight[c] * double(phase) * double(transmittance[rgb]) / double(v.z);
    }
}

template<int Channels, int Components>
void Walker::walk(std::uint64_t photon, int channel) {
    CounterRng rng(walk_limits::streamKey(request_.seed, request_.source), photon);
    Photon<Channels> p;
    const std::vector<float>& extinction = m_.extinction_[m_.grey_ ? 0 : channel];
    const bool oneColumn = m_.size_.x == 1 && m_.size_.y == 1;
    const bool surface = m_.hasSurface(), refracts = m_.refracts_, sees = request_.towardsViewer.z > 0;

    bool alive = start(p, rng, channel);
    while (alive) {
        // On [0, size) and never beyond a face by rounding.
        for (int a = 0; a < 2; ++a) {
            if (p.position[a] < 0 || p.position[a] >= size_[a]) {
                p.position[a] -= quickFloor(p.position[a] / size_[a]) * size_[a];
            }
        }

        float remaining = rng.exponential();
        int hit = -1, hitX = 0, hitY = 0, hitZ = 0, lastX = 0, lastY = 0;
        double stop = 0;
        bool meets = false;
        // In a single column nothing depends on x and y: no walls are crossed there.
        const double across = oneColumn ? 0.0 : 1.0;
        const Vec3d step{across * double(p.direction.x) * perMm_.x, across * double(p.direction.y) * perMm_.y,
                         double(p.direction.z) * perMm_.z};
        const Vec3f positionF(p.position), stepF(step);
        std::vector<float>& tracks = p.collided ? collided_ : uncollided_;
        float* const track = Components > 0 && !tracks.empty() ? tracks.data() : nullptr;
        const float along[4] = {1, dot(p.direction, p.axisX), dot(p.direction, p.axisY), -p.direction.z};
        const double end =
            tracer_.traverse(p.position, step, endless_, [&](int index, int ix, int iy, int iz, double t0, double t1) {
                lastX = ix, lastY = iy;
                for (int pieces = 0; pieces < 16; ++pieces) {
                    double t = t1;
                    bool crosses = false;
                    if (surface) {
                        if (!m_.surface_.crossedBySurface(std::size_t(index))) {
                            p.inside = m_.surface_.insideVoxel(std::size_t(index));
                        } else {
                            const float at =
                                m_.surface_.crossing({ix, iy, iz}, positionF, stepF, float(t0), float(t1), p.inside);
                            crosses = double(at) <= t1;
                            t = crosses ? std::clamp(double(at), t0, t1) : t1;
                        }
                    }
                    if (p.inside || !surface) {
                        const float kappa = extinction[std::size_t(index)];
                        double length = t - t0;
                        const float depth = kappa * float(length);
                        const bool collides = depth >= remaining && kappa > 0;
                        if (collides) {
                            length = std::min(length, double(remaining) / double(kappa));
                            hit = index, hitX = ix, hitY = iy, hitZ = iz;
                            stop = t0 + length;
                        } else {
                            remaining -= depth;
                        }
                        if (Components > 0 && track) {
                            for (int c = 0; c < Channels; ++c) {
                                float* const out =
                                    track +
                                    (std::size_t(index) * 3 + std::size_t(Channels == 1 ? channel : c)) * Components;
                                const float w = float(p.weight[c] * length);
                                for (int k = 0; k < Components; ++k) {
                                    out[k] += w * along[k];
                                }
                            }
                        }
                        if (collides) {
                            return false;
                        }
                    }
                    if (!crosses) {
                        return true;
                    }
                    if (refracts) {
                        meets = true;
                        hitX = ix, hitY = iy, hitZ = iz;
                        stop = t;
                        return false;
                    }
                    // Index 1: the surface is only where the material begins.
                    p.inside = !p.inside;
                    p.entered = true;
                    t0 = t;
                }
                return true;
            });

        if (hit < 0 && !meets) {
            if (end >= endless_) {
                ++tally_.lost;
                for (int c = 0; c < Channels; ++c) {
                    tally_.roulette[Channels == 1 ? channel : c] += p.weight[c];
                }
                break;
            }
            const bool top = p.direction.z < 0;
            p.position += step * end;
            p.position.z = top ? 0.0 : size_.z;
            alive = leaveThrough(p, top, lastX + m_.size_.x * lastY, rng, channel);
            continue;
        }
        p.position += step * stop;
        // x and y may have wrapped on the way: put the point into the voxel where it stopped.
        const Vec3i cell{hitX, hitY, hitZ};
        for (int a = 0; a < 3; ++a) {
            double local = p.position[a] - double(cell[a]);
            if (a != 2 && std::abs(local - 0.5) > 0.5 * size_[a]) {
                local -= quickFloor((local - 0.5) / size_[a] + 0.5) * size_[a];
            }
            p.position[a] = double(cell[a]) + std::clamp(local, 0.0, 1.0);
        }
        if (meets) {
            alive = !trapped(p, channel) && meetSurface(p, rng);
            continue;
        }

        ++tally_.collisions;
        p.collided = true;
        p.surfaces = 0;
        const auto& [coalbedo, g] = m_.collisions_[std::size_t(hit)];
        if (request_.analog) {
            if (double(rng.bits()) * 0x1p-32 < double(coalbedo[channel])) {
                p.absorbed[0] += p.weight[0];
                break;
            }
        } else {
            for (int c = 0; c < Channels; ++c) {
                const double taken = p.weight[c] * double(coalbedo[Channels == 1 ? channel : c]);
                p.absorbed[c] += taken;
                p.weight[c] -= taken;
            }
        }
        if (sees) {
            see(p, g, channel); // before roulette, which would only add noise to it
        }
        if (!request_.analog && !survives(p, rng, channel)) {
            break;
        }
        const float u1 = rng.uniform(), u2 = rng.uniform();
        p.direction = g == 0 ? uniformSphere(u1, u2) : sampleHenyeyGreenstein(g, p.direction, u1, u2);
    }

    for (int c = 0; c < Channels; ++c) {
        const int rgb = Channels == 1 ? channel : c;
        tally_.above[rgb] += p.above[c];
        tally_.absorbed[rgb] += p.absorbed[c];
        tally_.aboveSquared[rgb] += p.above[c] * p.above[c];
        tally_.belowSquared[rgb] += p.below[c] * p.below[c];
        tally_.absorbedSquared[rgb] += p.absorbed[c] * p.absorbed[c];
    }
}

namespace {

// Gives a channel what the walk of another found.
void copyChannel(WalkTally& t, int from, int to) {
    const auto copy = [&](std::vector<double>& values, int components) {
        const std::size_t n = std::size_t(components);
        for (std::size_t i = 0; i + 3 * n <= values.size(); i += 3 * n) {
            std::copy_n(values.begin() + std::ptrdiff_t(i + std::size_t(from) * n), n,
                        values.begin() + std::ptrdiff_t(i + std::size_t(to) * n));
        }
    };
    copy(t.collided, t.components);
    copy(t.uncollided, t.components);
    copy(t.below, 1);
    copy(t.belowUncollided, 1);
    copy(t.belowUncollidedCosine, 1);
    copy(t.radiance, 1);
    for (Vec3d* v :
         {&t.above, &t.specular, &t.absorbed, &t.roulette, &t.aboveSquared, &t.belowSquared, &t.absorbedSquared}) {
        (*v)[to] = (*v)[from];
    }
}

} // namespace

WalkTally walk(const TileMedium& medium, const WalkSource& source, const WalkRequest& request,
               const Progress& progress) {
    const Vec3i& size = medium.size();
    const std::size_t columns = std::size_t(size.x) * std::size_t(size.y);
    WalkTally tally;
    tally.photons = request.count;
    tally.components = !request.voxels ? 0 : request.flux ? 4 : 1;
    const std::size_t values = medium.voxelCount() * 3 * std::size_t(tally.components);
    tally.collided.assign(values, 0.0);
    tally.uncollided.assign(request.uncollided ? values : 0, 0.0);
    tally.below.assign(columns * 3, 0.0);
    tally.belowUncollided.assign(columns * 3, 0.0);
    tally.belowUncollidedCosine.assign(columns * 3, 0.0);
    tally.radiance.assign(request.towardsViewer.z > 0 ? columns * 3 : 0, 0.0);
    if (source.kind == WalkSource::Kind::Emission && !medium.emits()) {
        return tally;
    }

    if (!request.scalar && lanesCanWalk(medium, source, request)) {
        for (int c = 0; c < 3; ++c) {
            if (medium.channelLike(c) == c) {
                walkLanes(medium, source, request, c, tally, progress);
            } else {
                copyChannel(tally, medium.channelLike(c), c);
            }
        }
        return tally;
    }
    Walker walker(medium, source, request, tally);
    const bool alike = medium.channelLike(1) == 0 && medium.channelLike(2) == 0;
    if (medium.greyExtinction() && !alike && !request.analog) {
        switch (tally.components) {
        case 0:
            walker.run<3, 0>(0, progress);
            break;
        case 1:
            walker.run<3, 1>(0, progress);
            break;
        default:
            walker.run<3, 4>(0, progress);
        }
        return tally;
    }
    for (int c = 0; c < 3; ++c) {
        if (medium.channelLike(c) != c) {
            copyChannel(tally, medium.channelLike(c), c);
            continue;
        }
        // The same numbers for each channel: their noise is alike as long as their paths are.
        switch (tally.components) {
        case 0:
            walker.run<1, 0>(c, progress);
            break;
        case 1:
            walker.run<1, 1>(c, progress);
            break;
        default:
            walker.run<1, 4>(c, progress);
        }
    }
    return tally;
}

} // namespace stf
