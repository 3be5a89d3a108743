// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/precompute.h"

#include "stfLib/base/parallel.h"
#include "stfLib/transport/lateral_filter.h"
#include "stfLib/transport/walk.h"

#include <chrono>
#include <mutex>
#include <sstream>

namespace stf {

namespace {

constexpr int kAlgorithm = 3; // raise with every change that changes tables
constexpr int kBatches = 8;   // of each direction; their scatter is the error estimate

// The first column stands for all of them.
BaseVolume oneColumn(const BaseVolume& v) {
    BaseVolume c = v;
    c.size = {1, 1, v.size.z};
    const std::size_t layer = std::size_t(v.size.x) * std::size_t(v.size.y);
    const auto pick = [&](auto& values) {
        if (values.empty()) {
            return;
        }
        for (int z = 0; z < v.size.z; ++z) {
            values[std::size_t(z)] = values[std::size_t(z) * layer];
        }
        values.resize(std::size_t(v.size.z));
    };
    pick(c.extinction);
    pick(c.albedo);
    pick(c.g);
    pick(c.ior);
    pick(c.surface);
    pick(c.emission);
    return c;
}

struct Estimate {
    std::vector<double> sum, sumSquared; // of the batches' collided track lengths, filtered as the table is
    WalkTally total;
};

// Noise of the voxels' values, weighted by the values: sqrt(sum var) / sqrt(sum mean^2).
double relativeNoise(const Estimate& e) {
    double variance = 0, mean = 0;
    for (std::size_t i = 0; i < e.sum.size(); ++i) {
        const double m = e.sum[i] / kBatches, m2 = e.sumSquared[i] / kBatches;
        variance += std::max(0.0, m2 - m * m) / (kBatches - 1);
        mean += m * m;
    }
    return mean > 0 ? std::sqrt(variance / mean) : 0.0;
}

class Job {
public:
    Job(const WalkMedium& medium, const TransportOptions& options, const LateralFilter& filter, Progress& progress,
        double photonsInAll)
        : medium_(medium), options_(options), filter_(filter), progress_(progress), photonsInAll_(photonsInAll) {}

    // All batches of one source. The order of addition is fixed: the result does not depend on threads.
    Estimate run(const WalkSource& source, std::uint64_t number, std::uint64_t photons) {
        const std::uint64_t perBatch = std::max<std::uint64_t>(1, photons / kBatches);
        std::vector<WalkTally> batches(kBatches);
        parallelFor(kBatches, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b) {
                batches[b] = medium_.walk(source, options_.seed, number, b * perBatch, perBatch, progress_);
                const std::lock_guard<std::mutex> lock(mutex_);
                done_ += double(perBatch);
                progress_.update("transport", std::min(1.0, done_ / photonsInAll_));
            }
        });
        Estimate e;
        e.sum.assign(batches[0].collided.size(), 0.0);
        e.sumSquared = e.sum;
        // Neighbouring voxels share walks, so the filter gains less than it would on white noise: what it leaves is
        // measured on the filtered batches themselves.
        std::vector<Rgb> filtered(e.sum.size() / 3);
        for (const WalkTally& b : batches) {
            for (std::size_t i = 0; i < filtered.size(); ++i) {
                filtered[i] = Rgb(Vec3d(b.collided[3 * i], b.collided[3 * i + 1], b.collided[3 * i + 2]));
            }
            filter_.apply(filtered);
            for (std::size_t i = 0; i < e.sum.size(); ++i) {
                const double value = double(filtered[i / 3][int(i % 3)]);
                e.sum[i] += value;
                e.sumSquared[i] += value * value;
            }
            e.total.add(b);
        }
        return e;
    }

private:
    const WalkMedium& medium_;
    const TransportOptions& options_;
    const LateralFilter& filter_;
    Progress& progress_;
    double photonsInAll_, done_ = 0;
    std::mutex mutex_;
};

// Irradiance on the bottom of a column by light that never collides: exact, averaged over 4 x 4 points of the column.
Rgb directThroughColumn(const WalkMedium& medium, int x, int y, const Vec3f& towardsLight) {
    constexpr int kSub = 4;
    Vec3d sum(0.0);
    for (int b = 0; b < kSub; ++b) {
        for (int a = 0; a < kSub; ++a) {
            const Vec3f p{float(x) + (float(a) + 0.5f) / kSub, float(y) + (float(b) + 0.5f) / kSub,
                          float(medium.size().z)};
            sum += Vec3d(exp(-medium.opticalDepth(p, towardsLight)));
        }
    }
    return Rgb(sum * (double(towardsLight.z) / (kSub * kSub)));
}

} // namespace

std::string TransportOptions::key() const {
    std::ostringstream s;
    s << "classic;v" << kAlgorithm << ";q" << quality << ";s" << seed << ";n" << maxPhotons << ";p" << polars << ";a"
      << azimuths << (filter ? "" : ";unfiltered");
    return s.str();
}

StfTable precompute(const BaseVolume& input, const TransportOptions& options, Progress& progress,
                    const MessageSink& messages) {
    validate(input);
    const auto start = std::chrono::steady_clock::now();
    const bool uniform = input.laterallyUniform();
    const BaseVolume column = uniform ? oneColumn(input) : BaseVolume();
    const BaseVolume& volume = uniform ? column : input;
    const WalkMedium medium(volume);

    StfTable t;
    t.size = volume.size;
    t.voxelMm = volume.voxelMm;
    const int azimuths = uniform ? 1 : options.azimuths > 0 ? options.azimuths : volume.hasRelief() ? 6 : 1;
    t.directions = DirectionSet(options.polars, azimuths);
    t.volumeHash = input.contentHash();
    t.seed = options.seed;
    const int directions = t.directions.count();
    const std::size_t voxels = volume.voxelCount();
    const std::size_t columns = std::size_t(t.size.x) * std::size_t(t.size.y);
    t.multiple.assign(voxels * std::size_t(directions) * 3, 0.0f);
    t.transmitted.assign(columns * std::size_t(directions) * 3, 0.0f);
    t.direct = t.transmitted;
    t.backlight.assign(voxels, Rgb(0.0f));
    t.reflectedBelow.assign(columns, Rgb(0.0f));

    const double voxelVolume = volume.voxelMm.x * volume.voxelMm.y * volume.voxelMm.z;
    const double columnArea = volume.voxelMm.x * volume.voxelMm.y;
    const double tileArea = columnArea * double(columns);

    bool scatters = false;
    for (std::size_t i = 0; i < voxels; ++i) {
        scatters = scatters || maxComponent(volume.albedo[i] * volume.extinction[i]) > 0;
    }

    const LateralFilter filter = options.filter ? LateralFilter(volume) : LateralFilter(volume.size, volume.voxelMm, 0);
    // A tile with more columns needs more photons for the same noise. The count is raised until the target is met; the
    // first direction decides for all. The renderer's lookup averages over about 8 voxels of a tile, 2 of a column, and
    // a march over several of those: a voxel may be that much noisier.
    const double target = (columns > 1 ? 3.0 : 2.0) * double(options.quality);
    std::uint64_t photons = std::min<std::uint64_t>(options.maxPhotons, std::max<std::uint64_t>(20000, columns * 8));
    const auto sourceOf = [&](int d) {
        WalkSource s;
        s.kind = azimuths == 1 ? WalkSource::Kind::AnyAzimuth : WalkSource::Kind::Direction;
        s.towardsLight = t.directions.direction(d);
        return s;
    };
    if (scatters) {
        Job pilot(medium, options, filter, progress, 1e30);
        const double noise = relativeNoise(pilot.run(sourceOf(0), 1'000'000, photons));
        const double wanted = double(photons) * std::max(1.0, noise * noise / (target * target)) * 1.1;
        photons = std::uint64_t(std::min(wanted, double(options.maxPhotons)));
        photons = (photons + kBatches - 1) / kBatches * kBatches;
    }
    t.photonsPerDirection = scatters ? photons : 0;

    std::uint64_t lost = 0;
    double worstNoise = 0;
    Job job(medium, options, filter, progress, double(photons) * (directions + 1));
    for (int d = 0; d < directions; ++d) {
        const Vec3f light = t.directions.direction(d);
        for (std::size_t c = 0; c < columns; ++c) {
            Rgb direct(0.0f);
            const int turns = azimuths == 1 && !uniform && d > 0 ? 8 : 1; // the average over azimuth, for flat tiles
            for (int k = 0; k < turns; ++k) {
                const float phi = 2 * 3.14159265f * float(k) / float(turns), s = std::sqrt(1 - light.z * light.z);
                const Vec3f l = turns == 1 ? light : Vec3f(s * std::cos(phi), s * std::sin(phi), light.z);
                direct += directThroughColumn(medium, int(c) % t.size.x, int(c) / t.size.x, l) / float(turns);
            }
            for (int k = 0; k < 3; ++k) {
                t.direct[(c * std::size_t(directions) + std::size_t(d)) * 3 + std::size_t(k)] = direct[k];
            }
        }
        Estimate e;
        if (scatters) {
            e = job.run(sourceOf(d), std::uint64_t(d), photons);
            lost += e.total.lost;
            worstNoise = std::max(worstNoise, relativeNoise(e));
        } else {
            progress.update("transport", double(d) / directions);
        }
        // A unit perpendicular irradiance brings the flux mu * area into the tile.
        const double perPhoton = scatters ? double(light.z) * tileArea / double(e.total.photons) : 0;
        std::vector<Rgb> fluence(scatters ? voxels : 0);
        for (std::size_t i = 0; i < fluence.size(); ++i) {
            for (int k = 0; k < 3; ++k) {
                fluence[i][k] = float(e.total.collided[i * 3 + std::size_t(k)] * perPhoton / voxelVolume);
            }
        }
        filter.apply(fluence);
        for (std::size_t i = 0; i < fluence.size(); ++i) {
            for (int k = 0; k < 3; ++k) {
                t.multiple[(i * std::size_t(directions) + std::size_t(d)) * 3 + std::size_t(k)] = fluence[i][k];
            }
        }
        for (std::size_t c = 0; c < columns; ++c) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t at = (c * std::size_t(directions) + std::size_t(d)) * 3 + k;
                const double below = scatters ? e.total.below[c * 3 + k] * perPhoton / columnArea : 0;
                t.transmitted[at] = t.direct[at] + float(below);
            }
        }
    }

    // Backlight runs for an absorbing medium too: its uncollided part is not zero.
    WalkSource below;
    below.kind = WalkSource::Kind::DiffuseBelow;
    const Estimate e = job.run(below, std::uint64_t(directions), std::max<std::uint64_t>(photons, 20000));
    lost += e.total.lost;
    const double perPhoton = 3.14159265358979 * tileArea / double(e.total.photons); // unit radiance: flux pi * area
    for (std::size_t i = 0; i < voxels; ++i) {
        for (int k = 0; k < 3; ++k) {
            const std::size_t at = i * 3 + std::size_t(k);
            t.backlight[i][k] = float((e.total.collided[at] + e.total.uncollided[at]) * perPhoton / voxelVolume);
        }
    }
    filter.apply(t.backlight);
    for (std::size_t c = 0; c < columns; ++c) {
        for (int k = 0; k < 3; ++k) {
            t.reflectedBelow[c][k] =
                float(e.total.below[c * 3 + std::size_t(k)] * perPhoton / (columnArea * 3.14159265358979));
        }
    }

    t.relativeError = worstNoise;
    t.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (worstNoise > 1.3 * target) {
        std::ostringstream s;
        s << "table noise " << worstNoise * 100 << " % per voxel stays above the target of " << target * 100
          << " % at the limit of " << options.maxPhotons << " photons per direction";
        report(messages, Severity::Info, s.str());
    }
    if (lost) {
        report(messages, Severity::Warning,
               std::to_string(lost) + " walks ran parallel to the layers in a void: dropped");
    }
    return t;
}

} // namespace stf
