// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/slab_stf.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/temporary_folder.h"
#include "stfLib/core/dipole.h"
#include "stfLib/optics/fresnel.h"
#include "stfLib/optics/gauss_legendre.h"
#include "stfLib/render/tile_march.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/slab_tile.h"

#include <chrono>

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;
/// Independent tables: their scatter is the error of what is told.
constexpr int kTables = 4;
/// Below this a path that goes to and fro between the faces is given up.
constexpr float kNegligible = 1e-6f;
constexpr std::size_t kGrain = 1024; // exit directions at a time

Vec3f directionAt(double mu, double azimuth = 0) {
    const double s = std::sqrt((1 - mu) * (1 + mu));
    return {float(s * std::cos(azimuth)), float(s * std::sin(azimuth)), float(mu)};
}

// Cosine-distributed, outward.
Vec3f cosineDirection(const Vec2f& u) {
    return directionAt(std::sqrt(1 - double(u.x)), 2 * kPi * double(u.y));
}

// What one table says of the slab.
struct Told {
    double r = 0, t = 0, unscattered = 0, a = 0;
    std::vector<double> single, multiple, backlight, view;
};

class TableSlab {
public:
    TableSlab(const SlabOptions& o, const SlabTile& tile, const BaseVolume& volume, const StfTable& table)
        : o_(o), tile_(tile), table_(table), medium_(volume, o.form, !o.hasCore) {
        if (o.incidence == SlabOptions::Incidence::Parallel) {
            cosines_ = {o.mu};
            shares_ = {1};
        } else {
            const GaussLegendre rule(48);
            for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
                cosines_.push_back(rule.nodes[i]);
                shares_.push_back(2 * rule.nodes[i] * rule.weights[i]); // of the flux
            }
        }
        if (o.hasCore) {
            solveCore();
        }
    }

    // First-surface reflection.
    double specular() const {
        return overIncidence([&](double mu) { return double(fresnelReflectance(float(mu), float(o_.ior))); });
    }

    Told tell(Progress& progress, std::uint64_t paths, std::uint64_t seed) const {
        Told told;
        told.r = specular() + uncollidedBack() + marched(progress, paths, seed, cosineDirection);
        const bool parallel = o_.incidence == SlabOptions::Incidence::Parallel;
        for (double mu : o_.view) {
            const auto towards = [mu](const Vec2f& u) { return directionAt(mu, 2 * kPi * double(u.y)); };
            const double mirrored =
                parallel ? 0 : double(fresnelReflectance(float(mu), float(o_.ior))) + uncollidedBackAt(mu);
            told.view.push_back(mirrored + marched(progress, paths, seed, towards));
        }
        if (!o_.hasCore) {
            told.t = bottomIrradiance(table_.transmitted.get());
            told.unscattered = bottomIrradiance(table_.direct.get());
        }
        told.a = absorbed();
        for (double depth : o_.profile) {
            const double at = voxelCoordinate(depth);
            told.single.push_back(overIncidence([&](double mu) { return uncollidedAt(at, mu) / mu; }) *
                                  perIrradiance());
            told.multiple.push_back(overIncidence([&](double mu) { return multipleAt(at, mu) / mu; }) *
                                    perIrradiance());
            told.backlight.push_back(
                interpolated(at, [&](std::size_t i) { return fieldAt(table_.backlight.get(), i, 1, true); }) /
                (2 * kPi));
        }
        return told;
    }

private:
    // Means over the incident flux.
    template<class F>
    double overIncidence(F&& f) const {
        double sum = 0;
        for (std::size_t i = 0; i < cosines_.size(); ++i) {
            sum += shares_[i] * f(cosines_[i]);
        }
        return sum;
    }
    // Fluences are told per perpendicular irradiance of parallel light: which is mu^-1 per flux.
    double perIrradiance() const { return o_.incidence == SlabOptions::Incidence::Parallel ? o_.mu : 1; }

    double fieldAt(const FactoredField& f, std::size_t item, double mu, bool alone) const {
        if (f.empty()) {
            return 0;
        }
        const DirectionSet one(1, 1);
        return alone ? double(f.rgb(item, one.weights({0, 0, 1})).x)
                     : double(f.rgb(item, table_.directions.weights(directionAt(mu))).x);
    }
    // Through the bottom, per incident flux.
    double bottomIrradiance(const FactoredField& f) const {
        return overIncidence([&](double mu) { return fieldAt(f, 0, mu, false) / mu; });
    }
    // Light that never collides but comes back from an open bottom.
    double uncollidedBackAt(double mu) const {
        if (o_.hasCore || o_.ior == 1) {
            return 0;
        }
        const UncollidedLight u = medium_.uncollided({0.5f, 0.5f, 0}, directionAt(mu));
        const double f = double(fresnelReflectance(float(mu), float(o_.ior)));
        return double(u.reflected.x) * double(u.towards.z) * (1 - f) / mu;
    }
    double uncollidedBack() const {
        return overIncidence([&](double mu) { return uncollidedBackAt(mu); });
    }

    // Mean of pi times the radiance over exit directions `exitOf` two uniform numbers, marched down from the top.
    template<class Exit>
    double marched(Progress& progress, std::uint64_t paths, std::uint64_t seed, Exit&& exitOf) const {
        std::vector<double> sums((std::size_t(paths) + kGrain - 1) / kGrain);
        parallelFor(std::size_t(paths), kGrain, [&](std::size_t begin, std::size_t end) {
            if (progress.cancelled()) {
                throw Cancelled();
            }
            TileMarch march(medium_, table_);
            double sum = 0;
            for (std::size_t i = begin; i < end; ++i) {
                PixelSampler sampler(seed, 0, std::uint32_t(i));
                const Vec3f exit = exitOf(sampler.next2d());
                const Vec2f incident = sampler.next2d();
                // A flux of 1, of parallel light or of one direction of a uniform sky for each path.
                const Vec3f towards =
                    o_.incidence == SlabOptions::Incidence::Diffuse ? cosineDirection(incident) : directionAt(o_.mu);
                const Rgb irradiance(1 / std::max(towards.z, 1e-6f));
                sum += double(radiance(march, sampler, {towards, irradiance, irradiance}, exit));
            }
            sums[begin / kGrain] = sum;
        });
        double sum = 0;
        for (double s : sums) {
            sum += s;
        }
        return kPi * sum / double(paths);
    }

    // Radiance outside towards `exit`. The line of sight is refracted by the top and, where it meets an open bottom,
    // reflected there and at the top again.
    float radiance(TileMarch& march, PixelSampler& sampler, const MarchLight& light, const Vec3f& exit) const {
        const float n = float(o_.ior);
        const FresnelSplit split = fresnel(exit.z, n);
        const float cosine = std::max(n == 1 ? exit.z : split.cosT, 1e-6f);
        const Vec3f mm(medium_.voxelMm());
        const Vec3f perMm{-exit.x / n / mm.x, -exit.y / n / mm.y, cosine / mm.z};
        const float length = float(medium_.size().z) / cosine;
        float sum = 0, weight = (1 - split.reflectance) / (n * n);
        bool down = true;
        while (weight > kNegligible) {
            march.begin(sampler);
            march.setFrame(&light, 1, {exit.x / n, exit.y / n, down ? cosine : -cosine});
            march.segment({0.5f, 0.5f, down ? 0.0f : float(medium_.size().z)},
                          {perMm.x, perMm.y, down ? perMm.z : -perMm.z}, length, core_);
            const float left = march.transmittance().x;
            const TileRadiance r = march.finish();
            sum += weight * (r.single.x + r.multiple.x);
            if (o_.hasCore) {
                return sum + weight * left * core_.x;
            }
            weight *= left * split.reflectance;
            down = !down;
        }
        return sum;
    }

    // The core's exitance over pi, laterally uniform (DESIGN 3.10): direct light keeps its direction, all else is
    // diffuse, and what the shell sends back comes again. Per unit of incident flux.
    void solveCore() {
        const double a = o_.coreAlbedo, g = o_.coreG;
        const Dipole core(1 - a, a * (1 - g));
        const double back = double(table_.reflectedBelow[0].x), diffuse = core.diffuseAlbedo();
        double exitance = overIncidence([&](double mu) {
            const double direct = fieldAt(table_.direct.get(), 0, mu, false) / mu;
            const double all = fieldAt(table_.transmitted.get(), 0, mu, false) / mu;
            const double inside = double(fresnel(float(mu), float(o_.ior)).cosT);
            return direct * core.directAlbedo(inside) + (all - direct) * diffuse;
        });
        exitance /= 1 - diffuse * back;
        intoCore_ = bottomIrradiance(table_.transmitted.get()) + back * exitance - exitance;
        core_ = Rgb(float(exitance / kPi));
    }

    // By the fluence of the table, not as what is missing from R + T; per incident flux. A core takes what it does not
    // return.
    double absorbed() const {
        double sum = intoCore_;
        for (std::size_t i = 0; i < medium_.voxelCount(); ++i) {
            const TileMedium::Voxel& v = medium_.voxel(i);
            const double absorption = double(v.extinction.x) - double(v.scattering.x * v.keep); // 1 mm high
            if (!(absorption > 0)) {
                continue;
            }
            double fluence = overIncidence([&](double mu) {
                double single = 0;
                for (double at : {0.1127016654, 0.5, 0.8872983346}) { // Gauss's three points
                    single += (at == 0.5 ? 8.0 : 5.0) / 18 * uncollidedAt(double(i) + at, mu);
                }
                return (single + fieldAt(table_.multiple.get(), i, mu, false)) / mu;
            });
            fluence += double(core_.x) * fieldAt(table_.backlight.get(), i, 1, true);
            sum += absorption * fluence;
        }
        return sum;
    }

    double uncollidedAt(double z, double mu) const {
        const UncollidedLight u = medium_.uncollided({0.5f, 0.5f, float(z)}, directionAt(mu));
        return double(u.fraction.x) + double(u.reflected.x);
    }
    double multipleAt(double z, double mu) const {
        return interpolated(z, [&](std::size_t i) { return fieldAt(table_.multiple.get(), i, mu, false); });
    }

    // Place of a depth in the tile, in voxels.
    double voxelCoordinate(double depth) const {
        const auto& e = tile_.edges;
        const std::size_t below = std::size_t(std::upper_bound(e.begin(), e.end(), depth) - e.begin());
        const std::size_t i = std::min(below, e.size() - 1) - 1;
        return double(i) + (e[i + 1] > e[i] ? std::min(1.0, (depth - e[i]) / (e[i + 1] - e[i])) : 0.5);
    }
    // Voxels hold means: linear between their middles, by optical depth, and beyond the last ones.
    template<class F>
    double interpolated(double z, F&& value) const {
        const auto& e = tile_.edges;
        const std::size_t n = e.size() - 1, voxel = std::min(n - 1, std::size_t(z));
        if (n == 1) {
            return value(0);
        }
        const double depth = e[voxel] + (z - double(voxel)) * (e[voxel + 1] - e[voxel]);
        const auto middle = [&](std::size_t i) { return 0.5 * (e[i] + e[i + 1]); };
        std::size_t a = depth < middle(voxel) ? (voxel > 0 ? voxel - 1 : 0) : voxel;
        a = std::min(a, n - 2);
        const double wide = middle(a + 1) - middle(a);
        return wide > 0 ? value(a) + (value(a + 1) - value(a)) * (depth - middle(a)) / wide : value(a);
    }

    const SlabOptions& o_;
    const SlabTile& tile_;
    const StfTable& table_;
    const TileMedium medium_;
    std::vector<double> cosines_, shares_; // of the incident light
    Rgb core_{0.0f};
    double intoCore_ = 0;
};

struct Mean {
    double mean = 0, error = 0;
};
template<class Value>
Mean meanOf(const std::vector<Told>& told, Value&& value) {
    Mean m;
    const double n = double(told.size());
    for (const Told& t : told) {
        m.mean += value(t) / n;
    }
    for (const Told& t : told) {
        m.error += (value(t) - m.mean) * (value(t) - m.mean);
    }
    m.error = std::sqrt(m.error / (n * (n - 1)));
    return m;
}

} // namespace

SlabResult slabByTable(const SlabOptions& o, Progress& progress) {
    const auto start = std::chrono::steady_clock::now();
    SlabResult result;
    const MessageSink messages = [&](Severity, const std::string& text) { result.notes.push_back(text); };
    const TemporaryFolder folder;
    const SlabTile tile = makeSlabTile(o);
    writeBaseVolume(tile.volume, folder.file("slab.vdb"));
    const BaseVolume volume = readBaseVolume(folder.file("slab.vdb"), messages);

    TransportOptions transport;
    transport.form = o.form;
    transport.openBottom = !o.hasCore;
    // Noise of independent tables averages out.
    transport.quality = float(o.quality * std::sqrt(double(kTables)));
    std::vector<Told> told;
    for (int k = 0; k < kTables; ++k) {
        transport.seed = o.seed * kTables + std::uint64_t(k);
        const StfTable made = precompute(volume, transport, progress, messages);
        const std::string key = volume.contentHash() + ";" + transport.key();
        writeTable(made, key, folder.file("slab_table.vdb"));
        const StfTable table = readTable(folder.file("slab_table.vdb"), key);
        const TableSlab slab(o, tile, volume, table);
        told.push_back(slab.tell(progress, std::max<std::uint64_t>(1, o.photons / kTables), transport.seed));
        result.specular = slab.specular();
        result.tableError = std::max(result.tableError, table.error.total());
        result.photons += table.photons;
        result.collisions += table.collisions;
    }
    const auto take = [&](double Told::*of, double& mean, double& error) {
        const Mean m = meanOf(told, [&](const Told& t) { return t.*of; });
        mean = m.mean;
        error = m.error;
    };
    double ignored = 0;
    take(&Told::r, result.r, result.rError);
    take(&Told::t, result.t, result.tError);
    take(&Told::unscattered, result.unscattered, ignored);
    take(&Told::a, result.a, result.aError);
    for (std::size_t i = 0; i < o.profile.size(); ++i) {
        const Mean s = meanOf(told, [&](const Told& t) { return t.single[i]; });
        const Mean m = meanOf(told, [&](const Told& t) { return t.multiple[i]; });
        const Mean b = meanOf(told, [&](const Told& t) { return t.backlight[i]; });
        result.profile.push_back(
            {o.profile[i], s.mean, m.mean, b.mean, s.error, std::hypot(s.error, m.error), m.error, b.error});
    }
    for (std::size_t i = 0; i < o.view.size(); ++i) {
        const Mean v = meanOf(told, [&](const Told& t) { return t.view[i]; });
        result.view.push_back({o.view[i], v.mean, v.error});
    }
    result.layers = volume.size.z;
    if (o.form == TransportForm::DE1) {
        result.notes.push_back("I_s and what is unscattered are those of the scaled medium: only sums compare with "
                               "the true one");
    }
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
}

} // namespace stf
