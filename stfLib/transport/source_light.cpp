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

// Walks of one source until its noise is within the target, and so is `other`, the square of a relative error; the
// fields are of all light, collided or not. No low rank helps here.
void walkUntilSmooth(TileWalks& c, const WalkSource& source, std::uint64_t number, double scale,
                     const std::function<void(const std::vector<GroupResult>&, float, float)>& add,
                     const std::function<double()>& other) {
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
        const double relative = std::max(signal > 0 ? noise / signal : 0, other()), target = sq(c.options.quality);
        if (relative <= target || double(done) >= double(c.options.maxPhotons) / 4) {
            break;
        }
        photons = std::uint64_t(std::min(double(c.options.maxPhotons) / 4 - double(done),
                                         double(done) * (std::min(12.0, 1.15 * relative / target) - 1)));
    }
}

// The balance of shell and core divides by 1 - R_cd R_sd, and the core may return all: its exitance then has the error
// of R_sd over 1 - R_sd, and counts in the picture as what the shell passes up. Half of the target is left to it.
class BalanceError {
public:
    explicit BalanceError(const BaseVolume& v)
        : widest_(v.ior.empty() ? 1 : sq(double(*std::max_element(v.ior.begin(), v.ior.end())))) {}
    void add(const WalkTally& t) {
        photons_ += double(t.photons);
        above_ += t.above;
        for (std::size_t k = 0; k < t.below.size(); ++k) {
            back_[int(k % 3)] += t.below[k] + t.belowUncollided[k];
        }
        squares_ += t.belowSquared;
    }
    // The square, against that of the whole target.
    double square() const {
        double worst = 0;
        for (int c = 0; c < 3 && photons_ > 0; ++c) {
            const double back = back_[c] / photons_, variance = std::max(0.0, squares_[c] / photons_ - back * back);
            if (back < 1) {
                // Radiance is n^2 times as much inside.
                const double seen = std::min(1.0, widest_ * above_[c] / photons_);
                worst = std::max(worst, 4 * variance / photons_ * sq(seen / (1 - back)));
            }
        }
        return worst;
    }

private:
    double widest_, photons_ = 0;
    Vec3d above_{0, 0, 0}, back_{0, 0, 0}, squares_{0, 0, 0};
};

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
    BalanceError balance(c.volume);
    const auto add = [&](const std::vector<GroupResult>& r, float before, float now) {
        c.mean(field, r, &GroupResult::field, float(flux), before, now);
        const auto share = [&](Rgb old, double sum, double photons, int rgb) {
            return old[rgb] * before + float(sum / photons) * now;
        };
        double photons = 0;
        Vec3d above(0.0);
        std::vector<double> back(c.columns * 3, 0.0);
        for (const GroupResult& g : r) {
            balance.add(g.totals);
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
    };
    walkUntilSmooth(c, source, kBelow, flux, add, [&] { return balance.square(); });
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
    const auto add = [&](const std::vector<GroupResult>& r, float before, float now) {
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
    };
    walkUntilSmooth(c, source, kEmission, power, add, [] { return 0.0; });
    c.finish(field, c.walks.components());
    t.emitted = FactoredField::single(std::move(field), c.walks.components());
}

} // namespace stf
