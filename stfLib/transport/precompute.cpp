// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/precompute.h"

#include "stfLib/transport/column_light.h"
#include "stfLib/transport/direction_choice.h"
#include "stfLib/transport/group_statistics.h"
#include "stfLib/transport/read_noise.h"
#include "stfLib/transport/source_light.h"

#include <chrono>
#include <sstream>

namespace stf {

namespace {

constexpr int kAlgorithm = 9; // raise with every change that changes tables
// Shares of the wanted error that each source may take; noise gets what they leave.
constexpr double kDirectionShare = 0.45, kFineShare = kDirectionShare / 4, kFilterShare = 0.75;
constexpr double kLeastShare = 0.1; // TileWalks::weight
const Vec3f kPilotLights[] = {{0, 0, 1}, {0.7071068f, 0, 0.7071068f}};
constexpr std::uint64_t kPilots = 1ull << 41; // numbers of these sources
constexpr double kFilterVoxels[] = {1.5, 1.0, 0.75, 0.5, 0.35};
constexpr int kPolarsOfClearMedia = 13;                          // exponentials of the slant depth
constexpr std::size_t kMaxDirectionBytes = std::size_t(3) << 30; // of all directions' values while they are made

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

class Precompute {
public:
    Precompute(const BaseVolume& volume, const TransportOptions& options, Progress& progress,
               const MessageSink& messages)
        : messages_(messages), c_(volume, options, progress) {}

    StfTable run() {
        StfTable t;
        t.size = c_.volume.size;
        t.voxelMm = c_.volume.voxelMm;
        t.form = c_.options.form;
        t.seed = c_.options.seed;
        t.algorithm = kAlgorithm;
        t.error.target = double(c_.options.quality);
        std::vector<DirectionLight> walked;
        if (c_.medium.scatters()) {
            choose(t);
            walked = walkDirections(c_, t);
        } else {
            t.directions = DirectionSet(kPolarsOfClearMedia, 1, c_.medium.topIor());
        }
        lightColumns(c_, walked, t);
        lightFromBelow(c_, t);
        lightFromEmission(c_, t);
        t.photons = std::uint64_t(c_.walks.photons());
        t.collisions = c_.walks.collisions();
        tell(t);
        return t;
    }

private:
    // Directions and filter, by pilot walks.
    void choose(StfTable& t) {
        c_.walks.expect(1e30);
        const std::vector<ReadGroups> plain = pilots();
        const double wanted = double(c_.options.quality) / c_.weight;
        const DirectionChoice choice =
            chooseDirections(c_.medium, c_.walks, (c_.options.fineDirections ? kFineShare : kDirectionShare) * wanted,
                             c_.options.polars, c_.columns == 1 ? 1 : c_.options.azimuths, c_.pilotPhotons);
        t.directions = choice.set;
        t.error.directions = choice.error * c_.weight;
        const std::size_t perDirection = c_.medium.voxelCount() * std::size_t(c_.walks.components()) * sizeof(float);
        if (std::size_t(choice.set.count()) * perDirection > kMaxDirectionBytes) {
            const int most = std::max(1, int(kMaxDirectionBytes / perDirection));
            int azimuths = (most - 1) / std::max(1, choice.set.polars() - 1) / 2 * 2;
            azimuths = azimuths < 4 ? 1 : azimuths;
            t.directions = DirectionSet(choice.set.polars(), azimuths, c_.medium.topIor());
            report(messages_, Severity::Warning,
                   "the volume is too large for " + std::to_string(choice.set.count()) +
                       " light directions: " + std::to_string(t.directions.count()) + " are used");
        }
        if (c_.options.filter && c_.columns > 1) {
            chooseFilter(t, plain, wanted);
        }
    }

    // Fluence for a steep and an oblique light, and how much of all light it is.
    std::vector<ReadGroups> pilots() {
        std::vector<ReadGroups> plain;
        double collided = 0, uncollided = 0;
        std::vector<WalkJob> jobs;
        for (int k = 0; k < 2; ++k) {
            WalkSource source;
            source.towardsLight = kPilotLights[k];
            jobs.push_back({source, kPilots + std::uint64_t(k), 0, c_.pilotPhotons});
        }
        c_.walks.run(jobs, false, [&](std::size_t job, const std::vector<GroupResult>& r) {
            filtered_[job].clear();
            for (const double voxels : kFilterVoxels) {
                filtered_[job].push_back(c_.options.filter && c_.columns > 1
                                             ? readGroups(c_.medium, r, c_.walks.components(), filterOf(voxels)).read
                                             : std::vector<std::vector<float>>());
            }
            plain.push_back(readGroups(c_.medium, r, c_.walks.components(), LateralFilter()));
            const double flux = double(kPilotLights[job].z) * c_.tileArea;
            collided += std::max(0.0, commonSquare(plain.back().read)) * flux * flux;
        });
        const std::size_t stride = std::max<std::size_t>(1, c_.medium.voxelCount() / 1000);
        std::size_t count = 0;
        for (std::size_t i = 0; i < c_.medium.voxelCount(); i += stride, ++count) {
            const std::size_t nx = std::size_t(c_.volume.size.x), ny = std::size_t(c_.volume.size.y);
            const Vec3f middle{float(i % nx) + 0.5f, float(i / nx % ny) + 0.5f, float(i / nx / ny) + 0.5f};
            for (const Vec3f& light : kPilotLights) {
                const Vec3d f(c_.medium.uncollided(middle, light).fraction);
                uncollided += dot(f, f) / 3;
            }
        }
        const double all = std::sqrt(collided) + std::sqrt(uncollided / double(count));
        c_.weight = std::clamp(std::sqrt(collided) / (kLeastShare * all), 1e-6, 1.0);
        return plain;
    }

    LateralFilter filterOf(double voxels) const {
        return LateralFilter(c_.volume.size, c_.volume.voxelMm,
                             voxels * std::min(c_.volume.voxelMm.x, c_.volume.voxelMm.y));
    }

    // The filter that asks for the fewest photons: a wide one takes noise away, but its bias (measured free of noise)
    // leaves less of the error for noise.
    void chooseFilter(StfTable& t, const std::vector<ReadGroups>& plain, double wanted) {
        double signal = 0, noise = 0;
        for (const ReadGroups& p : plain) {
            signal += commonSquare(p.read);
            noise += noiseSquare(p.read);
        }
        const double budget = (1 - kDirectionShare * kDirectionShare) * wanted * wanted;
        double least = noise / budget;
        for (std::size_t k = 0; k < std::size(kFilterVoxels) && signal > 0; ++k) {
            double bias = 0, left = 0;
            for (std::size_t job = 0; job < plain.size(); ++job) {
                left += noiseSquare(filtered_[job][k]);
                std::vector<std::vector<float>> difference = filtered_[job][k];
                for (std::size_t g = 0; g < difference.size(); ++g) {
                    for (std::size_t i = 0; i < difference[g].size(); ++i) {
                        difference[g][i] -= plain[job].read[g][i];
                    }
                }
                bias += commonSquare(difference);
            }
            const double squared = std::max(0.0, bias / signal), cost = left / (budget - squared);
            if (squared < kFilterShare * kFilterShare * wanted * wanted && cost < least) {
                least = cost;
                c_.filter = filterOf(kFilterVoxels[k]);
                t.error.filter = std::sqrt(squared) * c_.weight;
            }
        }
    }

    void tell(const StfTable& t) const {
        if (t.error.total() > 1.1 * t.error.target && c_.medium.scatters()) {
            std::ostringstream s;
            s.precision(2);
            s << "table error " << t.error.total() * 100 << " % stays above the target of " << t.error.target * 100
              << " % (noise " << t.error.noise * 100 << ", directions " << t.error.directions * 100 << ", filter "
              << t.error.filter * 100 << ", rank " << t.error.truncation * 100 << " %) at " << t.photons << " photons";
            report(messages_, Severity::Info, s.str());
        }
        if (c_.walks.lost()) {
            report(messages_, Severity::Warning,
                   std::to_string(c_.walks.lost()) +
                       " walks never ended (parallel to the layers in a void, or caught in a surface): dropped");
        }
    }

    const MessageSink& messages_;
    TileWalks c_;
    std::vector<std::vector<std::vector<float>>> filtered_[2]; // of the pilots, by width
};

} // namespace

std::string TransportOptions::key() const {
    std::ostringstream s;
    s << name(form) << ";v" << kAlgorithm << ";q" << quality << ";s" << seed << ";n" << maxPhotons << ";p" << polars
      << ";a" << azimuths << (filter ? "" : ";unfiltered") << (openBottom ? ";open" : "")
      << (fineDirections ? ";finer" : "");
    return s.str();
}

StfTable precompute(const BaseVolume& input, const TransportOptions& options, Progress& progress,
                    const MessageSink& messages) {
    validate(input);
    const auto start = std::chrono::steady_clock::now();
    const bool uniform = input.laterallyUniform();
    const BaseVolume column = uniform ? oneColumn(input) : BaseVolume();
    StfTable t = Precompute(uniform ? column : input, options, progress, messages).run();
    t.volumeHash = input.contentHash();
    t.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return t;
}

} // namespace stf
