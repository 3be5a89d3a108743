// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/lane_walk.h"

#include "stfLib/transport/lane_math.h"
#include "stfLib/transport/walk_limits.h"

#include <algorithm>
#include <memory>

namespace stf {

namespace {

/// Photons side by side: a few vectors of the widest registers, so that one's latency hides behind the next.
constexpr int kLanes = 64;
/// The last few are walked in fewer lanes, of one vector: where paths differ by a thousand times, they take long.
constexpr int kLastLanes = 8;
/// Delta tracking steps per collision beyond which flights from voxel to voxel do better.
constexpr double kMaxNullShare = 24;
constexpr int kMaxLayers = 32;
/// Passes through a tile after which ended photons are replaced: until then their lanes idle, which costs less than
/// drawing starts for all lanes in each pass.
constexpr unsigned kReplaceEvery = 4;

// What lanes walk through, in the units they walk in.
struct LaneScene {
    // One column: depth is optical depth. A tile: voxels.
    double depth = 0;                  ///< of the bottom
    int layers = 1;                    ///< of a column
    double edges[kMaxLayers] = {};     ///< lower ends of layers, optical depth
    Vec3i size{1, 1, 1};               ///< of a tile
    const float* extinction = nullptr; ///< of a tile, per voxel, 1/mm
    double majorant = 0;               ///< 1/mm
    double perMm[3] = {};              ///< voxels per mm
    // Per layer or voxel; `uniform`: the first stands for all.
    std::vector<float> coalbedo, g;
    std::int32_t materialMask = 0; ///< 0 where the first stands for all, else all ones
    bool isotropic = true;

    double ior = 1;
    bool refracts = false, openBottom = false;

    // Start.
    bool diffuse = false;
    double startZ = 0;
    float direction[3] = {0, 0, 1}; ///< z inward, outside
};

// Reads layers of a column, merging those of one material.
void addLayers(LaneScene& s, const std::vector<float>& extinction, double layerMm) {
    std::vector<float> coalbedo, g;
    std::vector<double> edges;
    double depth = 0;
    for (std::size_t i = 0; i < extinction.size(); ++i) {
        const double tau = double(extinction[i]) * layerMm;
        if (!(tau > 0)) {
            continue;
        }
        depth += tau;
        if (!edges.empty() && coalbedo.back() == s.coalbedo[i] && g.back() == s.g[i]) {
            edges.back() = depth;
            continue;
        }
        edges.push_back(depth);
        coalbedo.push_back(s.coalbedo[i]);
        g.push_back(s.g[i]);
    }
    s.depth = depth;
    s.layers = int(edges.size());
    s.coalbedo = coalbedo;
    s.g = g;
    std::copy_n(edges.begin(), std::min<std::size_t>(edges.size(), kMaxLayers), s.edges);
}

} // namespace

class LaneWalker {
public:
    static int layerCount(const TileMedium& m, int channel) {
        int layers = 0, last = -1;
        for (std::size_t i = 0; i < m.voxelCount(); ++i) {
            if (!(m.extinction_[m.grey_ ? 0 : channel][i] > 0)) {
                continue;
            }
            const auto& now = m.collisions_[i];
            if (last < 0 || now.coalbedo[channel] != m.collisions_[std::size_t(last)].coalbedo[channel] ||
                now.g != m.collisions_[std::size_t(last)].g) {
                ++layers;
            }
            last = int(i);
        }
        return layers;
    }
    static const std::vector<float>& extinction(const TileMedium& m, int channel) {
        return m.extinction_[m.grey_ ? 0 : channel];
    }
    static bool oneIndex(const TileMedium& m) { return m.ior_.empty(); }

    static LaneScene scene(const TileMedium& m, const WalkSource& source, int channel) {
        LaneScene s;
        const std::vector<float>& kappa = extinction(m, channel);
        s.coalbedo.reserve(kappa.size());
        s.g.reserve(kappa.size());
        for (const auto& c : m.collisions_) {
            s.coalbedo.push_back(c.coalbedo[channel]);
            s.g.push_back(c.g);
        }
        if (m.size_.x == 1 && m.size_.y == 1) {
            addLayers(s, kappa, m.voxelMm_.z);
        } else {
            s.size = m.size_;
            s.depth = m.size_.z;
            s.extinction = kappa.data();
            s.majorant = double(*std::max_element(kappa.begin(), kappa.end()));
            for (int a = 0; a < 3; ++a) {
                s.perMm[a] = 1 / m.voxelMm_[a];
            }
        }
        const auto varies = [](const std::vector<float>& v) {
            return std::any_of(v.begin(), v.end(), [&](float x) { return x != v[0]; });
        };
        s.materialMask = varies(s.coalbedo) || varies(s.g) ? -1 : 0;
        s.isotropic = std::all_of(s.g.begin(), s.g.end(), [](float g) { return g == 0; });
        s.refracts = m.refracts_;
        s.openBottom = m.openBottom_;
        s.ior = double(m.uniformIor_);

        const Vec3f& l = source.towardsLight;
        s.direction[0] = -l.x, s.direction[1] = -l.y, s.direction[2] = l.z;
        s.diffuse = source.kind == WalkSource::Kind::DiffuseTop || source.kind == WalkSource::Kind::DiffuseBelow;
        if (source.kind == WalkSource::Kind::DiffuseBelow) {
            s.direction[2] = -1;
            s.startZ = s.depth;
        }
        return s;
    }
};

namespace {

// The state of all lanes; a lane without a photon has weight 0.
template<int N>
struct alignas(64) Lanes {
    double x[N], y[N], z[N];
    double weight[N], collided[N];
    double above[N], below[N], absorbed[N]; // of this photon
    float dx[N], dy[N], dz[N];
    std::int64_t photon[N], ended[N];
    std::int64_t next; // photon to be walked
    std::uint32_t step[N];
    double surfaces[N]; // met since the last collision

    // Sums over photons.
    double sumAbove[N], sumBelow[N], sumAbsorbed[N], squareAbove[N], squareBelow[N], squareAbsorbed[N], specular[N],
        roulette[N], collisions[N], lost[N];
    double straight[N], straightCosine[N]; // below without a collision, and times its cosine

    // Within a pass.
    std::uint32_t r0[N], r1[N], r2[N], r3[N];
    float flight[N], newX[N], newY[N], newZ[N], kappa[N], coalbedo[N], g[N];
    double toX[N], toY[N], toZ[N], leaving[N], chance[N], real[N], reflected[N];
    std::int32_t voxel[N];
    double born[N], top[N], bottom[N], hit[N], leavingStraight[N];
};

struct Job {
    const LaneScene* scene;
    std::uint32_t key0, key1;
    std::uint64_t first, end;
    double* below;          // per column and rgb, offset to the channel; null for a single column
    double* straight;       // the same for light without a collision
    double* straightCosine; // and times its cosine
    const Progress* progress;
};

template<int N>
STF_LANE void drawNumbers(Lanes<N>& s, const Job& job) {
    const std::uint32_t key0 = job.key0, key1 = job.key1;
    for (int i = 0; i < N; ++i) {
        const lane::Block b =
            lane::threefry(s.step[i], 0, std::uint32_t(s.photon[i]), std::uint32_t(s.photon[i] >> 32), key0, key1);
        s.r0[i] = b.r[0];
        s.r1[i] = b.r[1];
        s.r2[i] = b.r[2];
        s.r3[i] = b.r[3];
        s.step[i] += 1;
    }
}

// Where free flights end, and the material there. A column: in optical depth.
template<int N>
STF_LANE void flyThroughColumn(Lanes<N>& s, const LaneScene& scene) {
    for (int i = 0; i < N; ++i) {
        s.flight[i] = lane::exponential(s.r0[i]);
    }
    for (int i = 0; i < N; ++i) {
        s.toZ[i] = s.z[i] + double(s.dz[i]) * double(s.flight[i]);
        s.chance[i] = (double(std::int32_t(s.r3[i] >> 1)) + 0.5) * 0x1p-31;
    }
    if (scene.layers == 1) {
        return; // material as it was set
    }
    for (int i = 0; i < N; ++i) {
        s.voxel[i] = 0;
    }
    for (int k = 0; k + 1 < scene.layers; ++k) {
        const double edge = scene.edges[k];
        for (int i = 0; i < N; ++i) {
            s.voxel[i] += s.toZ[i] > edge ? 1 : 0;
        }
    }
    const float *const coalbedo = scene.coalbedo.data(), *const g = scene.g.data();
    for (int i = 0; i < N; ++i) {
        s.coalbedo[i] = coalbedo[s.voxel[i]];
        s.g[i] = g[s.voxel[i]];
    }
}

// A tile: a step of delta tracking. Extinction over the majorant is the chance of a real collision.
template<int N>
STF_LANE void flyThroughTile(Lanes<N>& s, const LaneScene& scene) {
    const double mm = 1 / scene.majorant, sizeX = scene.size.x, sizeY = scene.size.y, depth = scene.depth;
    const double perX = scene.perMm[0] * mm, perY = scene.perMm[1] * mm, perZ = scene.perMm[2] * mm;
    const double inverseX = 1 / sizeX, inverseY = 1 / sizeY;
    const std::int32_t nx = scene.size.x, ny = scene.size.y, nz = scene.size.z;
    for (int i = 0; i < N; ++i) {
        s.flight[i] = lane::exponential(s.r0[i]);
    }
    for (int i = 0; i < N; ++i) {
        const double t = double(s.flight[i]), dz = double(s.dz[i]) * perZ;
        const double z = s.z[i] + dz * t;
        // What leaves stops at the face.
        const double face = dz > 0 ? depth : 0.0;
        const bool out = z <= 0.0 || z >= depth;
        const double way = out && dz != 0.0 ? (face - s.z[i]) / dz : t;
        double x = s.x[i] + double(s.dx[i]) * perX * way, y = s.y[i] + double(s.dy[i]) * perY * way;
        x -= std::floor(x * inverseX) * sizeX;
        y -= std::floor(y * inverseY) * sizeY;
        const double inside = z > 0.0 ? (z < depth ? z : depth) : 0.0;
        s.toX[i] = x;
        s.toY[i] = y;
        s.toZ[i] = z;
        const std::int32_t ix = std::int32_t(x), iy = std::int32_t(y), iz = std::int32_t(inside);
        const std::int32_t cx = ix < nx ? ix : nx - 1, cy = iy < ny ? iy : ny - 1, cz = iz < nz ? iz : nz - 1;
        s.voxel[i] = cx + nx * (cy + ny * cz);
    }
    const float* const extinction = scene.extinction;
    for (int i = 0; i < N; ++i) {
        s.kappa[i] = extinction[s.voxel[i]];
    }
    const double majorant = scene.majorant;
    for (int i = 0; i < N; ++i) {
        const double number = (double(std::int32_t(s.r3[i] >> 1)) + 0.5) * 0x1p-31;
        const double kappa = double(s.kappa[i]), share = number * majorant;
        s.real[i] = share < kappa ? 1.0 : 0.0;
        // What is left of the number that accepts is again uniform; one that leaves has not used it.
        const double rest = share / (kappa > 0.0 ? kappa : 1.0);
        const bool out = s.toZ[i] <= 0.0 || s.toZ[i] >= depth;
        s.chance[i] = out ? number : rest;
    }
    if (scene.materialMask != 0) {
        const float *const coalbedo = scene.coalbedo.data(), *const g = scene.g.data();
        for (int i = 0; i < N; ++i) {
            s.coalbedo[i] = coalbedo[s.voxel[i]];
            s.g[i] = g[s.voxel[i]];
        }
    }
}

// Directions after a scattering, whether or not there is one.
template<bool Tile, int N>
STF_LANE void scatter(Lanes<N>& s, const LaneScene& scene) {
    if (scene.isotropic) {
        for (int i = 0; i < N; ++i) {
            const float z = 1.0f - 2.0f * lane::uniform(s.r1[i]);
            s.newZ[i] = z;
            if (Tile) {
                const float u = lane::uniform(s.r2[i]), square = 1.0f - z * z;
                const float sin = std::sqrt(square > 0.0f ? square : 0.0f);
                s.newX[i] = sin * lane::cosine(u);
                s.newY[i] = sin * lane::sine(u);
            }
        }
        return;
    }
    for (int i = 0; i < N; ++i) {
        const lane::Angle a = lane::scatterAngle(s.g[i], lane::uniform(s.r1[i]));
        const float u = lane::uniform(s.r2[i]);
        const float z = s.dz[i];
        if (!Tile) {
            // Only the cosine to the normal matters.
            const float square = (1.0f - z) * (1.0f + z);
            const float mu = z * a.cos + std::sqrt(square > 0.0f ? square : 0.0f) * a.sin * lane::cosine(u);
            s.newZ[i] = mu > -1.0f ? (mu < 1.0f ? mu : 1.0f) : -1.0f;
        } else {
            // Basis: Duff et al. 2017.
            const float x = s.dx[i], y = s.dy[i];
            const float sign = std::copysign(1.0f, z), p = -1.0f / (sign + z), q = x * y * p;
            const float u0 = a.sin * lane::cosine(u), u1 = a.sin * lane::sine(u);
            const float nx = u0 * (1.0f + sign * x * x * p) + u1 * q + a.cos * x;
            const float ny = u0 * sign * q + u1 * (sign + y * y * p) + a.cos * y;
            const float nz = u0 * -sign * x + u1 * -y + a.cos * z;
            const float norm = 1.0f / std::sqrt(nx * nx + ny * ny + nz * nz);
            s.newX[i] = nx * norm;
            s.newY[i] = ny * norm;
            s.newZ[i] = nz * norm;
        }
    }
}

// Absorption, what leaves, roulette.
template<bool Tile, bool Refracts, int N>
STF_LANE void settle(Lanes<N>& s, const LaneScene& scene) {
    const double depth = scene.depth, inverseIor = 1 / scene.ior;
    const double bottomShare = scene.openBottom ? 1.0 : 0.0;
    if (Refracts) {
        // By itself, lest the compiler branches around it.
        for (int i = 0; i < N; ++i) {
            s.reflected[i] = lane::fresnel(std::fabs(double(s.dz[i])), inverseIor).reflectance;
        }
    }
    // Flags are numbers, so that products choose: compilers make branches of anything more complicated.
    for (int i = 0; i < N; ++i) {
        const double z = s.toZ[i];
        const double top = z <= 0.0 ? 1.0 : 0.0, bottom = z >= depth ? 1.0 : 0.0;
        s.top[i] = top;
        s.bottom[i] = bottom;
        s.hit[i] = (1.0 - top - bottom) * (Tile ? s.real[i] : 1.0);
        s.z[i] = z > 0.0 ? (z < depth ? z : depth) : 0.0;
    }
    for (int i = 0; i < N; ++i) {
        const double w = s.weight[i], top = s.top[i], bottom = s.bottom[i], hit = s.hit[i], out = top + bottom;
        const double taken = w * double(s.coalbedo[i]) * hit;
        s.absorbed[i] += taken;
        const double lives = w > 0.0 ? 1.0 : 0.0;
        s.collisions[i] += hit * lives;
        const double back = Refracts ? s.reflected[i] * (top + bottom * bottomShare) : 0.0;
        const double remains = w - taken, leaves = remains * (1.0 - back) * out, left = remains - leaves;
        s.above[i] += leaves * top;
        const double belowNow = leaves * bottom, straight = belowNow * (1.0 - s.collided[i]);
        s.below[i] += belowNow;
        s.straight[i] += straight;
        s.straightCosine[i] += straight * std::fabs(double(s.dz[i]));
        s.leaving[i] = belowNow;
        s.leavingStraight[i] = straight;
        s.collided[i] = s.collided[i] > hit ? s.collided[i] : hit;

        // A null collision decides nothing.
        const double survivor = s.chance[i] * walk_limits::kRouletteTo < left ? double(walk_limits::kRouletteTo) : 0.0;
        const double decided = left < walk_limits::kRouletteBelow ? survivor : left;
        double after = hit + out > 0.0 ? decided : left;
        if (Refracts) {
            const double surfaces = (s.surfaces[i] + out) * (1.0 - hit);
            const double trapped = surfaces > double(walk_limits::kMaxSurfaces) ? lives : 0.0;
            s.surfaces[i] = surfaces;
            s.lost[i] += trapped;
            after *= 1.0 - trapped;
        }
        s.roulette[i] += left - after;
        s.weight[i] = after;
    }
    for (int i = 0; i < N; ++i) {
        const float hit = float(s.hit[i]), turn = 1.0f - 2.0f * float(s.top[i] + s.bottom[i]);
        s.dz[i] = hit > 0.0f ? s.newZ[i] : s.dz[i] * turn;
        if (Tile) {
            s.dx[i] = hit > 0.0f ? s.newX[i] : s.dx[i];
            s.dy[i] = hit > 0.0f ? s.newY[i] : s.dy[i];
        }
    }
    if (Tile) {
        for (int i = 0; i < N; ++i) {
            s.x[i] = s.toX[i];
            s.y[i] = s.toY[i];
        }
    }
}

// Sums photons that ended and puts the next ones into their lanes.
template<bool Tile, bool Refracts, int N>
STF_LANE void replace(Lanes<N>& s, const LaneScene& scene, const Job& job) {
    for (int i = 0; i < N; ++i) {
        const bool ended = !(s.weight[i] > 0.0);
        const double a = ended ? s.above[i] : 0.0, b = ended ? s.below[i] : 0.0, c = ended ? s.absorbed[i] : 0.0;
        s.sumAbove[i] += a;
        s.sumBelow[i] += b;
        s.sumAbsorbed[i] += c;
        s.squareAbove[i] += a * a;
        s.squareBelow[i] += b * b;
        s.squareAbsorbed[i] += c * c;
        s.above[i] = ended ? 0.0 : s.above[i];
        s.below[i] = ended ? 0.0 : s.below[i];
        s.absorbed[i] = ended ? 0.0 : s.absorbed[i];
        s.ended[i] = ended ? 1 : 0;
    }
    // Whoever is free takes the next photon: long paths in one lane do not keep others from their work.
    const std::int64_t end = std::int64_t(job.end);
    std::int64_t next = s.next;
    for (int i = 0; i < N; ++i) {
        const std::int64_t ended = s.ended[i];
        s.photon[i] = ended != 0 ? next : s.photon[i];
        next += ended;
    }
    s.next = next < end ? next : end;
    for (int i = 0; i < N; ++i) {
        s.born[i] = s.ended[i] != 0 && s.photon[i] < end ? 1.0 : 0.0;
    }
    const bool below = scene.startZ > 0, crosses = Refracts && (!below || scene.openBottom);
    const bool random = Tile || scene.diffuse;
    if (random) {
        for (int i = 0; i < N; ++i) {
            // Block 1 of the photon's stream is for its start.
            const lane::Block b =
                lane::threefry(0, 1, std::uint32_t(s.photon[i]), std::uint32_t(s.photon[i] >> 32), job.key0, job.key1);
            s.r0[i] = b.r[0];
            s.r1[i] = b.r[1];
            s.r2[i] = b.r[2];
            s.r3[i] = b.r[3];
        }
    }
    const double sizeX = scene.size.x, sizeY = scene.size.y, startZ = scene.startZ, ior = scene.ior;
    const float direction[3] = {scene.direction[0], scene.direction[1], scene.direction[2]};
    const bool diffuse = scene.diffuse;
    for (int i = 0; i < N; ++i) {
        const bool born = s.born[i] > 0.0;
        float dx = direction[0], dy = direction[1], dz = direction[2];
        if (diffuse) {
            // Cosine-distributed, as uniform radiance enters.
            const float u = (float(std::int32_t(s.r2[i] >> 8)) + 1.0f) * 0x1p-24f;
            dz *= std::sqrt(u);
            if (Tile) {
                const float r = std::sqrt(1.0f - u), phi = lane::uniform(s.r3[i]);
                dx = r * lane::cosine(phi);
                dy = r * lane::sine(phi);
            }
        }
        double reflected = 0.0;
        if (crosses) {
            const double cosine = std::fabs(double(dz));
            const lane::Split f = lane::fresnel(cosine > 1e-30 ? cosine : 1e-30, ior);
            reflected = f.reflectance;
            const float inverse = float(1 / ior);
            dx *= inverse;
            dy *= inverse;
            dz = std::copysign(float(f.cosT), dz);
        }
        s.weight[i] = born ? 1.0 - reflected : s.weight[i];
        const double up = born && !below ? reflected : 0.0;
        s.above[i] += up;
        s.specular[i] += up;
        const double down = born && below ? reflected : 0.0;
        s.below[i] += down;
        s.straight[i] += down;
        s.straightCosine[i] += down * std::fabs(double(dz));
        s.z[i] = born ? startZ : s.z[i];
        s.dz[i] = born ? dz : s.dz[i];
        s.collided[i] = born ? 0.0 : s.collided[i];
        s.surfaces[i] = born ? 0.0 : s.surfaces[i];
        s.step[i] = born ? 0u : s.step[i];
        if (Tile) {
            s.dx[i] = born ? dx : s.dx[i];
            s.dy[i] = born ? dy : s.dy[i];
            s.x[i] = born ? double(lane::uniform(s.r0[i])) * sizeX : s.x[i];
            s.y[i] = born ? double(lane::uniform(s.r1[i])) * sizeY : s.y[i];
        }
    }
}

// What left through the bottom of a tile, into its columns.
template<int N>
STF_LANE void scoreColumns(Lanes<N>& s, const LaneScene& scene, const Job& job) {
    double any = 0;
    for (int i = 0; i < N; ++i) {
        any += s.leaving[i];
    }
    if (!(any > 0)) {
        return;
    }
    const int columns = scene.size.x * scene.size.y;
    for (int i = 0; i < N; ++i) {
        if (s.leaving[i] > 0) {
            const std::size_t at = std::size_t(s.voxel[i] % columns) * 3;
            job.below[at] += s.leaving[i] - s.leavingStraight[i];
            job.straight[at] += s.leavingStraight[i];
            job.straightCosine[at] += s.leavingStraight[i] * std::fabs(double(s.dz[i]));
        }
    }
}

// Passes until all photons ended or, of many lanes, all but a few of the last ones.
template<bool Tile, bool Refracts, int N>
STF_LANE void walkOn(Lanes<N>& s, const Job& job) {
    const LaneScene& scene = *job.scene;
    for (unsigned pass = 1;; ++pass) {
        drawNumbers(s, job);
        if (Tile) {
            flyThroughTile(s, scene);
        } else {
            flyThroughColumn(s, scene);
        }
        scatter<Tile>(s, scene);
        settle<Tile, Refracts>(s, scene);
        if (Tile) {
            scoreColumns(s, scene, job);
        }
        if (!Tile || pass % kReplaceEvery == 0) {
            replace<Tile, Refracts>(s, scene, job);
        }
        if (pass % 32 == 0) {
            double alive = 0;
            for (int i = 0; i < N; ++i) {
                alive += s.weight[i] > 0.0 ? 1.0 : 0.0;
            }
            if (s.next == std::int64_t(job.end) && (alive == 0 || (N > kLastLanes && alive <= kLastLanes))) {
                return;
            }
            if (pass % 4096 == 0 && job.progress->cancelled()) {
                throw Cancelled();
            }
        }
    }
}

// All lanes without a photon; the next one will be of this number.
template<int N>
STF_LANE void clear(Lanes<N>& s, const LaneScene& scene, std::uint64_t next) {
    s = Lanes<N>{};
    s.next = std::int64_t(next);
    for (int i = 0; i < N; ++i) {
        s.coalbedo[i] = scene.coalbedo[0];
        s.g[i] = scene.g[0];
    }
}

template<bool Tile, bool Refracts>
STF_LANE void walkAll(Lanes<kLanes>& s, const Job& job) {
    const LaneScene& scene = *job.scene;
    clear(s, scene, job.first);
    replace<Tile, Refracts>(s, scene, job);
    walkOn<Tile, Refracts>(s, job);

    // The last long paths, closer together.
    Lanes<kLastLanes> last;
    clear(last, scene, job.end);
    int k = 0;
    for (int i = 0; i < kLanes; ++i) {
        if (s.weight[i] > 0.0) {
            last.x[k] = s.x[i], last.y[k] = s.y[i], last.z[k] = s.z[i];
            last.dx[k] = s.dx[i], last.dy[k] = s.dy[i], last.dz[k] = s.dz[i];
            last.weight[k] = s.weight[i], last.collided[k] = s.collided[i], last.surfaces[k] = s.surfaces[i];
            last.above[k] = s.above[i], last.below[k] = s.below[i], last.absorbed[k] = s.absorbed[i];
            last.photon[k] = s.photon[i], last.step[k] = s.step[i];
            ++k;
        }
    }
    if (k == 0) {
        return;
    }
    walkOn<Tile, Refracts>(last, job);
    for (int i = 0; i < kLastLanes; ++i) {
        s.sumAbove[i] += last.sumAbove[i], s.sumBelow[i] += last.sumBelow[i];
        s.sumAbsorbed[i] += last.sumAbsorbed[i], s.squareAbove[i] += last.squareAbove[i];
        s.squareBelow[i] += last.squareBelow[i], s.squareAbsorbed[i] += last.squareAbsorbed[i];
        s.specular[i] += last.specular[i], s.roulette[i] += last.roulette[i];
        s.collisions[i] += last.collisions[i], s.lost[i] += last.lost[i];
        s.straight[i] += last.straight[i], s.straightCosine[i] += last.straightCosine[i];
    }
}

using Kernel = void (*)(Lanes<kLanes>&, const Job&);

// One kernel for each kind of medium and instruction set.
#define STF_KERNELS(NAME, ATTRIBUTE)                                                                                   \
    ATTRIBUTE void column##NAME(Lanes<kLanes>& s, const Job& j) {                                                      \
        walkAll<false, false>(s, j);                                                                                   \
    }                                                                                                                  \
    ATTRIBUTE void columnRefracts##NAME(Lanes<kLanes>& s, const Job& j) {                                              \
        walkAll<false, true>(s, j);                                                                                    \
    }                                                                                                                  \
    ATTRIBUTE void tile##NAME(Lanes<kLanes>& s, const Job& j) {                                                        \
        walkAll<true, false>(s, j);                                                                                    \
    }                                                                                                                  \
    ATTRIBUTE void tileRefracts##NAME(Lanes<kLanes>& s, const Job& j) {                                                \
        walkAll<true, true>(s, j);                                                                                     \
    }                                                                                                                  \
    Kernel kernel##NAME(bool isTile, bool refracts) {                                                                  \
        return isTile ? (refracts ? tileRefracts##NAME : tile##NAME)                                                   \
                      : (refracts ? columnRefracts##NAME : column##NAME);                                              \
    }

STF_KERNELS(Plain, )
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
STF_KERNELS(Avx2, __attribute__((target("avx2,bmi2"))))
STF_KERNELS(Avx512,
            __attribute__((target("avx2,bmi2,avx512f,avx512dq,avx512vl,avx512bw,avx512cd,prefer-vector-width=512"))))
bool hasAvx2() {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2");
}
bool hasAvx512() {
    return hasAvx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512cd");
}
#else
constexpr auto kernelAvx2 = kernelPlain, kernelAvx512 = kernelPlain;
bool hasAvx2() {
    return false;
}
bool hasAvx512() {
    return false;
}
#endif

Kernel chooseKernel(LaneInstructions i, bool isTile, bool refracts) {
    if (i == LaneInstructions::Best) {
        i = hasAvx512() ? LaneInstructions::Avx512 : hasAvx2() ? LaneInstructions::Avx2 : LaneInstructions::Plain;
    }
    return i == LaneInstructions::Avx512 ? kernelAvx512(isTile, refracts)
           : i == LaneInstructions::Avx2 ? kernelAvx2(isTile, refracts)
                                         : kernelPlain(isTile, refracts);
}

double total(const double (&values)[kLanes]) {
    double sum = 0;
    for (double v : values) {
        sum += v;
    }
    return sum;
}

} // namespace

bool available(LaneInstructions i) {
    return i == LaneInstructions::Avx512 ? hasAvx512() : i == LaneInstructions::Avx2 ? hasAvx2() : true;
}

bool lanesCanWalk(const TileMedium& m, const WalkSource& source, const WalkRequest& request) {
    const bool kind = source.kind != WalkSource::Kind::Emission && source.kind != WalkSource::Kind::AnyAzimuth;
    if (!kind || request.voxels || request.towardsViewer.z > 0 || request.analog || m.hasSurface() ||
        !LaneWalker::oneIndex(m)) {
        return false;
    }
    const bool column = m.size().x == 1 && m.size().y == 1;
    for (int c = 0; c < 3; ++c) {
        if (m.channelLike(c) != c) {
            continue;
        }
        const std::vector<float>& kappa = LaneWalker::extinction(m, c);
        double sum = 0, largest = 0;
        for (float k : kappa) {
            sum += double(k);
            largest = std::max(largest, double(k));
        }
        if (!(sum > 0) || (column && LaneWalker::layerCount(m, c) > kMaxLayers) ||
            (!column && largest * double(kappa.size()) > kMaxNullShare * sum)) {
            return false;
        }
    }
    return true;
}

void walkLanes(const TileMedium& medium, const WalkSource& source, const WalkRequest& request, int channel,
               WalkTally& tally, const Progress& progress, LaneInstructions instructions) {
    const LaneScene scene = LaneWalker::scene(medium, source, channel);
    const bool isTile = scene.extinction != nullptr;
    const std::uint64_t key = walk_limits::streamKey(request.seed, request.source);
    const Job job{&scene,
                  std::uint32_t(key),
                  std::uint32_t(key >> 32),
                  request.first,
                  request.first + request.count,
                  tally.below.data() + channel,
                  tally.belowUncollided.data() + channel,
                  tally.belowUncollidedCosine.data() + channel,
                  &progress};
    auto lanes = std::make_unique<Lanes<kLanes>>();
    chooseKernel(instructions, isTile, scene.refracts)(*lanes, job);

    tally.above[channel] += total(lanes->sumAbove);
    tally.absorbed[channel] += total(lanes->sumAbsorbed);
    tally.specular[channel] += total(lanes->specular);
    tally.roulette[channel] += total(lanes->roulette);
    tally.aboveSquared[channel] += total(lanes->squareAbove);
    tally.belowSquared[channel] += total(lanes->squareBelow);
    tally.absorbedSquared[channel] += total(lanes->squareAbsorbed);
    tally.collisions += std::uint64_t(std::llround(total(lanes->collisions)));
    tally.lost += std::uint64_t(std::llround(total(lanes->lost)));
    if (!isTile) {
        const double straight = total(lanes->straight);
        tally.below[std::size_t(channel)] += total(lanes->sumBelow) - straight;
        tally.belowUncollided[std::size_t(channel)] += straight;
        tally.belowUncollidedCosine[std::size_t(channel)] += total(lanes->straightCosine);
    }
}

} // namespace stf
