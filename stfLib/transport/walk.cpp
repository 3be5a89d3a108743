// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/walk.h"

#include "stfLib/base/random.h"
#include "stfLib/optics/phase.h"
#include "stfLib/transport/tile_tracer.h"

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;

void addTo(std::vector<double>& a, const std::vector<double>& b) {
    if (a.empty()) {
        a = b;
        return;
    }
    for (std::size_t i = 0; i < a.size(); ++i) {
        a[i] += b[i];
    }
}

Vec3f uniformSphere(float u1, float u2) {
    const float z = 1 - 2 * u1, r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(2 * kPi * u2), r * std::sin(2 * kPi * u2), z};
}

// Direction of travel in the tile (z inward) and the flux-weighted start of a photon.
Vec3f entryDirection(const WalkSource& source, CounterRng& rng) {
    const Vec3f& l = source.towardsLight;
    switch (source.kind) {
    case WalkSource::Kind::Direction:
        return {-l.x, -l.y, l.z};
    case WalkSource::Kind::AnyAzimuth: {
        const float s = std::sqrt(std::max(0.0f, 1 - l.z * l.z)), phi = 2 * kPi * rng.uniform();
        return {s * std::cos(phi), s * std::sin(phi), l.z};
    }
    case WalkSource::Kind::DiffuseTop:
    case WalkSource::Kind::DiffuseBelow: {
        // Cosine-distributed, as uniform radiance enters.
        const float u = rng.uniformPositive(), r = std::sqrt(1 - u), phi = 2 * kPi * rng.uniform();
        const float z = std::sqrt(u);
        return {r * std::cos(phi), r * std::sin(phi), source.kind == WalkSource::Kind::DiffuseTop ? z : -z};
    }
    }
    return {0, 0, 1};
}

} // namespace

void WalkTally::add(const WalkTally& o) {
    photons += o.photons;
    addTo(uncollided, o.uncollided);
    addTo(collided, o.collided);
    addTo(below, o.below);
    addTo(belowUncollided, o.belowUncollided);
    above += o.above;
    absorbed += o.absorbed;
    collisions += o.collisions;
    lost += o.lost;
}

WalkMedium::WalkMedium(const BaseVolume& v) : size_(v.size), voxelMm_(v.voxelMm), albedo_(v.albedo), g_(v.g) {
    for (const Rgb& k : v.extinction) {
        grey_ = grey_ && k.x == k.y && k.y == k.z;
    }
    for (int c = 0; c < (grey_ ? 1 : 3); ++c) {
        extinction_[c].reserve(v.voxelCount());
        for (const Rgb& k : v.extinction) {
            extinction_[c].push_back(k[c]);
        }
    }
    if (g_.empty()) {
        g_.assign(v.voxelCount(), 0.0f);
    }
}

template<int Channels>
void WalkMedium::walkChannels(const WalkSource& source, std::uint64_t seed, std::uint64_t sourceNumber,
                              std::uint64_t first, std::uint64_t count, int channel, const Progress& progress,
                              WalkTally& tally) const {
    const TileTracer tracer(size_);
    const Vec3f perMm{float(1 / voxelMm_.x), float(1 / voxelMm_.y), float(1 / voxelMm_.z)};
    const Vec3f sizeF(size_);
    const std::vector<float>& extinction = extinction_[channel];
    // A flight this long has crossed the tile a hundred thousand times: it is parallel to the layers, in a void.
    const float endless = 1e5f * float(std::max(voxelMm_.z * size_.z, voxelMm_.x * size_.x));
    const bool fromBelow = source.kind == WalkSource::Kind::DiffuseBelow;

    for (std::uint64_t photon = first; photon < first + count; ++photon) {
        if ((photon & 0xfff) == 0 && progress.cancelled()) {
            throw Cancelled();
        }
        CounterRng rng(seed + 0x9e3779b97f4a7c15ull * (sourceNumber + 1), photon);
        Vec3f position{rng.uniform() * sizeF.x, rng.uniform() * sizeF.y, fromBelow ? sizeF.z : 0.0f};
        Vec3f direction = entryDirection(source, rng);
        float weight[Channels];
        std::fill(weight, weight + Channels, 1.0f);
        bool collided = false;

        for (;;) {
            // On [0, size) and never beyond a face by rounding.
            position.x -= std::floor(position.x / sizeF.x) * sizeF.x;
            position.y -= std::floor(position.y / sizeF.y) * sizeF.y;

            float remaining = -std::log(rng.uniformPositive());
            int hit = -1, hitX = 0, hitY = 0, hitZ = 0, lastX = 0, lastY = 0;
            float hitT = 0;
            const Vec3f voxelDirection = direction * perMm;
            double* const track = (collided ? tally.collided : tally.uncollided).data();
            const float end = tracer.traverse(
                position, voxelDirection, endless, [&](int index, int ix, int iy, int iz, float t0, float t1) {
                    const float kappa = extinction[std::size_t(index)];
                    float length = t1 - t0;
                    const float depth = kappa * length;
                    const bool collides = depth >= remaining && kappa > 0;
                    if (collides) {
                        length = remaining / kappa;
                        hit = index, hitX = ix, hitY = iy, hitZ = iz;
                        hitT = t0 + length;
                    } else {
                        remaining -= depth;
                    }
                    for (int c = 0; c < Channels; ++c) {
                        track[std::size_t(index) * 3 + std::size_t(Channels == 1 ? channel : c)] +=
                            double(weight[c]) * double(length);
                    }
                    lastX = ix, lastY = iy;
                    return !collides;
                });

            if (hit < 0) {
                const std::size_t column = std::size_t(lastX) + std::size_t(size_.x) * std::size_t(lastY);
                if (end >= endless) {
                    ++tally.lost;
                } else if (direction.z > 0) {
                    double* const out = (collided ? tally.below : tally.belowUncollided).data() + column * 3;
                    for (int c = 0; c < Channels; ++c) {
                        out[Channels == 1 ? channel : c] += double(weight[c]);
                    }
                } else {
                    for (int c = 0; c < Channels; ++c) {
                        tally.above[Channels == 1 ? channel : c] += double(weight[c]);
                    }
                }
                break;
            }

            ++tally.collisions;
            collided = true;
            position += voxelDirection * hitT;
            // x and y may have wrapped on the way: put the point into the voxel where it collided.
            const Vec3i cell{hitX, hitY, hitZ};
            for (int a = 0; a < 3; ++a) {
                float local = position[a] - float(cell[a]);
                if (a != 2) {
                    local -= std::round((local - 0.5f) / sizeF[a]) * sizeF[a];
                }
                position[a] = float(cell[a]) + std::clamp(local, 0.0f, 1.0f);
            }

            const Rgb& albedo = albedo_[std::size_t(hit)];
            float largest = 0;
            for (int c = 0; c < Channels; ++c) {
                const int rgb = Channels == 1 ? channel : c;
                tally.absorbed[rgb] += double(weight[c]) * (1.0 - double(albedo[rgb]));
                weight[c] *= albedo[rgb];
                largest = std::max(largest, weight[c]);
            }
            if (largest < 0.1f) {
                // Unbiased roulette; what dies is accounted as absorbed, what survives takes it back.
                const float survive = largest / 0.3f;
                const bool alive = rng.uniform() < survive;
                for (int c = 0; c < Channels; ++c) {
                    const float after = alive ? weight[c] / survive : 0.0f;
                    tally.absorbed[Channels == 1 ? channel : c] += double(weight[c]) - double(after);
                    weight[c] = after;
                }
                if (!alive) {
                    break;
                }
            }
            const float u1 = rng.uniform(), u2 = rng.uniform();
            const float g = g_[std::size_t(hit)];
            direction = g == 0 ? uniformSphere(u1, u2) : sampleHenyeyGreenstein(g, direction, u1, u2);
        }
    }
}

WalkTally WalkMedium::walk(const WalkSource& source, std::uint64_t seed, std::uint64_t sourceNumber,
                           std::uint64_t first, std::uint64_t count, const Progress& progress) const {
    const std::size_t voxels = albedo_.size(), columns = std::size_t(size_.x) * std::size_t(size_.y);
    WalkTally tally;
    tally.photons = count;
    tally.uncollided.assign(voxels * 3, 0.0);
    tally.collided.assign(voxels * 3, 0.0);
    tally.below.assign(columns * 3, 0.0);
    tally.belowUncollided.assign(columns * 3, 0.0);
    if (grey_) {
        walkChannels<3>(source, seed, sourceNumber, first, count, 0, progress, tally);
    } else {
        // The same numbers for each channel: their noise is alike as long as their paths are.
        for (int c = 0; c < 3; ++c) {
            walkChannels<1>(source, seed, sourceNumber, first, count, c, progress, tally);
        }
    }
    return tally;
}

Rgb WalkMedium::opticalDepth(const Vec3f& position, const Vec3f& towardsLight) const {
    Rgb depth(0.0f);
    const Vec3f d{float(towardsLight.x / voxelMm_.x), float(towardsLight.y / voxelMm_.y),
                  float(-towardsLight.z / voxelMm_.z)};
    const float endless = 1e5f * float(voxelMm_.z * size_.z);
    TileTracer(size_).traverse(position, d, endless, [&](int index, int, int, int, float t0, float t1) {
        for (int c = 0; c < 3; ++c) {
            depth[c] += extinction_[grey_ ? 0 : c][std::size_t(index)] * (t1 - t0);
        }
        return true;
    });
    return depth;
}

} // namespace stf
