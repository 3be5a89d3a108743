// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/column_light.h"

#include "stfLib/base/parallel.h"
#include "stfLib/transport/direction_choice.h"

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kTruncationShare = 0.1; // of the wanted error: columns are few

// Where uncollided light does not reach the bottom on a straight line that is known beforehand.
bool bent(const TileWalks& c) {
    return c.medium.refracts() && (c.medium.hasSurface() || c.medium.openBottom());
}

// Irradiance on the bottom by light that never collides, per column: exact where it goes straight, else walked.
std::vector<float> uncollidedBelow(const TileWalks& c, const DirectionSet& set, int direction,
                                   const std::vector<double>& walked, double scale) {
    std::vector<float> out(c.columns * 3);
    if (bent(c)) {
        for (std::size_t k = 0; k < out.size(); ++k) {
            out[k] = float(walked[k] * scale);
        }
        return out;
    }
    const Vec3f light = set.direction(direction);
    constexpr int kSub = 2;
    const int turns = set.azimuths() == 1 && c.columns > 1 && direction > 0 ? 8 : 1;
    const int sub = c.columns > 1 ? kSub : 1;
    parallelFor(c.columns, 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t column = begin; column < end; ++column) {
            Vec3d sum(0.0);
            for (int k = 0; k < turns * sub * sub; ++k) {
                const float phi = 2 * float(kPi) * float(k / (sub * sub)) / float(turns);
                const float s = std::sqrt(std::max(0.0f, 1 - light.z * light.z));
                const Vec3f l = turns == 1 ? light : Vec3f(s * std::cos(phi), s * std::sin(phi), light.z);
                const Vec3f p{float(column % std::size_t(c.volume.size.x)) + (float(k % sub) + 0.5f) / float(sub),
                              float(column / std::size_t(c.volume.size.x)) + (float(k / sub % sub) + 0.5f) / float(sub),
                              float(c.volume.size.z)};
                const UncollidedLight u = c.medium.uncollided(p, l);
                sum += Vec3d(u.fraction) * double(u.towards.z);
            }
            for (int k = 0; k < 3; ++k) {
                out[column * 3 + std::size_t(k)] = float(sum[k] / (turns * sub * sub));
            }
        }
    });
    return out;
}

// The same without other walks.
std::vector<double> walkUncollided(TileWalks& c, const WalkSource& source, std::uint64_t number,
                                   std::uint64_t& photons) {
    std::vector<double> sum(c.columns * 3, 0.0);
    c.walks.run({{source, number, 0, c.pilotPhotons}}, false, [&](std::size_t, const std::vector<GroupResult>& r) {
        for (const GroupResult& g : r) {
            photons += g.totals.photons;
            for (std::size_t k = 0; k < sum.size(); ++k) {
                sum[k] += g.totals.belowUncollided[k];
            }
        }
    });
    return sum;
}

} // namespace

void lightColumns(TileWalks& c, const std::vector<DirectionLight>& walked, StfTable& t) {
    std::vector<std::vector<float>> transmitted, direct;
    for (int i = 0; i < t.directions.count(); ++i) {
        const DirectionLight* const x = walked.empty() ? nullptr : &walked[std::size_t(i)];
        std::uint64_t photons = x ? x->photons : 0;
        const std::vector<double> bentLight =
            !bent(c) ? std::vector<double>()
            : x      ? x->belowUncollided
                     : walkUncollided(c, sourceOf(t.directions, i), std::uint64_t(i), photons);
        // A unit perpendicular irradiance brings the flux mu * area into the tile.
        const double scale = photons ? double(t.directions.direction(i).z) * double(c.columns) / double(photons) : 0.0;
        std::vector<float> all = uncollidedBelow(c, t.directions, i, bentLight, scale);
        direct.push_back(all);
        for (std::size_t k = 0; x && k < all.size(); ++k) {
            all[k] += float(x->below[k] * scale);
        }
        transmitted.push_back(std::move(all));
        t.reflectedAbove.push_back(x ? Rgb(x->above / double(x->photons)) : Rgb(0.0f));
    }
    FactoriseOptions options;
    options.tolerance = kTruncationShare * double(c.options.quality);
    options.maxRank = t.directions.count();
    t.transmitted = factorise(transmitted, 3, options);
    t.direct = factorise(direct, 3, options);
}

} // namespace stf
