// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_scatter.h"

#include "stfLib/base/random.h"

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kTrials = 1000;
constexpr std::size_t kMaxCopies = 1'000'000;

struct Sphere {
    Vec3d middle;
    double radius = 0;
};

/// Spheres by cells as wide as the largest two that touch, periodic along x and y.
class Neighbourhood {
public:
    Neighbourhood(const Vec3d& extent, double depthFrom, double depthTo, double reach)
        : extent_(extent), from_(depthFrom) {
        const Vec3d size(extent.x, extent.y, depthTo - depthFrom);
        for (int k = 0; k < 3; ++k) {
            // With less than three cells the same sphere would be met from both sides; one cell is searched once.
            const double n = std::min(64.0, std::floor(size[k] / reach));
            count_[k] = n >= 3 ? int(n) : 1;
            edge_[k] = size[k] > 0 ? size[k] / count_[k] : 1.0;
        }
        cells_.resize(std::size_t(count_.x) * std::size_t(count_.y) * std::size_t(count_.z));
    }
    bool isFree(const Sphere& s, double gap) const {
        const Vec3i at = cellOf(s.middle);
        for (int dz = -1; dz <= 1; ++dz) {
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    if ((dx && count_.x == 1) || (dy && count_.y == 1) || at.z + dz < 0 || at.z + dz >= count_.z) {
                        continue;
                    }
                    for (const Sphere& o : cells_[number(at + Vec3i(dx, dy, dz))]) {
                        Vec3d d = s.middle - o.middle;
                        d.x -= extent_.x * std::round(d.x / extent_.x);
                        d.y -= extent_.y * std::round(d.y / extent_.y);
                        if (length(d) < s.radius + o.radius + gap) {
                            return false;
                        }
                    }
                }
            }
        }
        return true;
    }
    void add(const Sphere& s) { cells_[number(cellOf(s.middle))].push_back(s); }

private:
    Vec3i cellOf(const Vec3d& p) const {
        return {std::clamp(int(p.x / edge_.x), 0, count_.x - 1), std::clamp(int(p.y / edge_.y), 0, count_.y - 1),
                std::clamp(int((-p.z - from_) / edge_.z), 0, count_.z - 1)};
    }
    std::size_t number(const Vec3i& c) const {
        const int x = (c.x + count_.x) % count_.x, y = (c.y + count_.y) % count_.y;
        return std::size_t(x) + std::size_t(count_.x) * (std::size_t(y) + std::size_t(count_.y) * std::size_t(c.z));
    }
    Vec3d extent_, edge_;
    double from_;
    Vec3i count_;
    std::vector<std::vector<Sphere>> cells_;
};

/// Uniform over all directions (Shoemake 1992, "Uniform random rotations").
Transform randomRotation(CounterRng& rng) {
    const double u = double(rng.uniform()), a = 2 * kPi * double(rng.uniform()), b = 2 * kPi * double(rng.uniform());
    const double x = std::sqrt(1 - u) * std::sin(a), y = std::sqrt(1 - u) * std::cos(a), z = std::sqrt(u) * std::sin(b),
                 w = std::sqrt(u) * std::cos(b);
    Transform t;
    t.x = {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)};
    t.y = {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)};
    t.z = {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
    return t;
}

Transform turnOf(MeshScatter::Turn turn, CounterRng& rng) {
    if (turn == MeshScatter::Turn::Any) {
        return randomRotation(rng);
    }
    Transform t;
    if (turn == MeshScatter::Turn::Vertical) {
        const double angle = 2 * kPi * double(rng.uniform());
        t.x = {std::cos(angle), std::sin(angle), 0};
        t.y = {-std::sin(angle), std::cos(angle), 0};
    }
    return t;
}

} // namespace

ScatterResult scatter(const MeshScatter& o, const ScatteredBody& body, const Vec3d& extent) {
    const double tile = extent.x * extent.y * extent.z, wanted = o.fraction * tile;
    if (o.count == 0) {
        // Mean of the cube of a size that is uniform between two.
        const double cube = 0.25 * (o.scale.x + o.scale.y) * (o.scale.x * o.scale.x + o.scale.y * o.scale.y);
        if (!(body.volume > 0)) {
            throw Error("encloses no volume: a scatter by 'fraction' needs one");
        }
        if (wanted / (cube * body.volume) > double(kMaxCopies)) {
            throw Error("would need more than a million copies for a 'fraction' of " + std::to_string(o.fraction));
        }
    }
    const Vec2d depth = o.depthMm ? *o.depthMm : Vec2d(0, extent.z);
    Neighbourhood taken(extent, depth.x, depth.y, 2 * body.radius * o.scale.y + o.gapMm);
    ScatterResult result;
    double volume = 0;
    const auto goesOn = [&](std::size_t i) {
        return o.count > 0 ? i < std::size_t(o.count) : volume < wanted && i < kMaxCopies;
    };
    for (std::size_t i = 0; goesOn(i); ++i) {
        CounterRng rng(o.seed, i);
        const double size = o.scale.x + (o.scale.y - o.scale.x) * double(rng.uniform());
        // What finds no place counts, too: else a fraction that does not fit would never be reached.
        volume += body.volume * size * size * size;
        const Transform turn = turnOf(o.turn, rng);
        bool placed = false;
        for (int trial = 0; trial < (o.apart ? kTrials : 1) && !placed; ++trial) {
            const double x = double(rng.uniform()), y = double(rng.uniform()), z = double(rng.uniform());
            const Sphere s{{extent.x * x, extent.y * y, -(depth.x + (depth.y - depth.x) * z)}, body.radius * size};
            if (o.apart && (2 * s.radius + o.gapMm > std::min(extent.x, extent.y) || !taken.isFree(s, o.gapMm))) {
                continue;
            }
            if (o.apart) {
                taken.add(s);
            }
            Transform t = turn;
            t.x *= size;
            t.y *= size;
            t.z *= size;
            t.translation = s.middle - t.vector(body.middle);
            result.copies.push_back(t);
            placed = true;
        }
        result.leftOut += placed ? 0 : 1;
    }
    return result;
}

} // namespace stf
