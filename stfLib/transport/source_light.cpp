// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/source_light.h"

#include "stfLib/transport/group_statistics.h"
#include "stfLib/transport/read_noise.h"

#include <functional>

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kMaxRounds = 5;
// Numbers of sources, apart from those of directions.
constexpr std::uint64_t kBelow = 1ull << 42, kEmission = kBelow + 1;

double sq(double x) {
    return x * x;
}

// Walks of one source until its noise is within the target; the fields are of all light, collided or not. No low rank
// helps here.
void walkUntilSmooth(TileWalks& c, const WalkSource& source, std::uint64_t number, double scale,
                     const std::function<void(const std::vector<GroupResult>&, float, float)>& add) {
    std::uint64_t photons = c.columns == 1 ? 4800 : std::max<std::uint64_t>(16000, c.columns * 8), done = 0;
    double noise = 0;
    for (int round = 0; round < kMaxRounds; ++round) {
        const std::uint64_t g = std::uint64_t(c.walks.groups());
        photons = (photons + g - 1) / g * g;
        double signal = 0;
        c.walks.run({{source, number, done, photons}}, true, [&](std::size_t, const std::vector<GroupResult>& r) {
            const double before = double(done) / double(done + photons), now = 1 - before;
            std::vector<GroupResult> all = r;
            for (GroupResult& x : all) {
                for (std::size_t i = 0; i < x.uncollided.size(); ++i) {
                    x.field[i] += x.uncollided[i];
                }
            }
            const auto read = readGroups(c.medium, all, c.walks.components(), c.filter).read;
            noise = noise * before * before + noiseSquare(read) * scale * scale * now * now;
            signal = commonSquare(read) * scale * scale;
            add(all, float(before), float(now));
        });
        done += photons;
        const double relative = signal > 0 ? noise / signal : 0, target = sq(c.options.quality);
        if (relative <= target || double(done) >= double(c.options.maxPhotons) / 4) {
            break;
        }
        photons = std::uint64_t(std::min(double(c.options.maxPhotons) / 4 - double(done),
                                         double(done) * (std::min(12.0, 1.15 * relative / target) - 1)));
    }
}

} // namespace

// Light from the core. Without scattering and refraction all of it passes: nothing is walked.
void lightFromBelow(TileWalks& c, StfTable& t) {
    t.reflectedBelow.assign(c.columns, Rgb(0.0f));
    if (!c.medium.scatters() && !c.medium.refracts()) {
        t.transmittedUp = Rgb(0.0f);
        return;
    }
    WalkSource source;
    source.kind = WalkSource::Kind::DiffuseBelow;
    const double flux = kPi * c.tileArea; // of unit radiance
    std::vector<float> field;
    walkUntilSmooth(c, source, kBelow, flux, [&](const std::vector<GroupResult>& r, float before, float now) {
        c.mean(field, r, &GroupResult::field, float(flux), before, now);
        const auto share = [&](Rgb old, double sum, double photons, int rgb) {
            return old[rgb] * before + float(sum / photons) * now;
        };
        double photons = 0;
        Vec3d above(0.0);
        std::vector<double> back(c.columns * 3, 0.0);
        for (const GroupResult& g : r) {
            photons += double(g.totals.photons);
            above += g.totals.above;
            for (std::size_t k = 0; k < c.columns * 3; ++k) {
                back[k] += g.totals.below[k] + g.totals.belowUncollided[k];
            }
        }
        for (int rgb = 0; rgb < 3; ++rgb) {
            t.transmittedUp[rgb] = share(t.transmittedUp, above[rgb], photons, rgb);
            for (std::size_t k = 0; k < c.columns; ++k) {
                t.reflectedBelow[k][rgb] =
                    share(t.reflectedBelow[k], back[k * 3 + std::size_t(rgb)] * double(c.columns), photons, rgb);
            }
        }
    });
    c.finish(field, c.walks.components());
    t.backlight = FactoredField::single(std::move(field), c.walks.components());
}

void lightFromEmission(TileWalks& c, StfTable& t) {
    if (!c.medium.emits()) {
        return;
    }
    WalkSource source;
    source.kind = WalkSource::Kind::Emission;
    // What one photon stands for: 4 pi times the summed mean emission of the tile.
    double power = 0;
    for (std::size_t i = 0; i < c.medium.voxelCount(); ++i) {
        power += double(average(c.medium.emission(i))) * double(c.medium.fill(i));
    }
    power *= 4 * kPi * c.volume.voxelMm.x * c.volume.voxelMm.y * c.volume.voxelMm.z;
    std::vector<float> field;
    t.emittedBelow.assign(c.columns, Rgb(0.0f));
    walkUntilSmooth(c, source, kEmission, power, [&](const std::vector<GroupResult>& r, float before, float now) {
        c.mean(field, r, &GroupResult::field, float(power), before, now);
        double photons = 0;
        for (const GroupResult& g : r) {
            photons += double(g.totals.photons);
        }
        const double scale = power * double(c.columns) / (photons * c.tileArea);
        for (std::size_t k = 0; k < c.columns * 3; ++k) {
            double sum = 0;
            for (const GroupResult& g : r) {
                sum += g.totals.below[k] + g.totals.belowUncollided[k];
            }
            float& out = t.emittedBelow[k / 3][int(k % 3)];
            out = out * before + float(sum * scale) * now;
        }
    });
    c.finish(field, c.walks.components());
    t.emitted = FactoredField::single(std::move(field), c.walks.components());
}

} // namespace stf
