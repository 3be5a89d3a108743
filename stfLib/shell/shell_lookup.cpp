// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_grid_impl.h"

namespace stf {

namespace {

using Leaf = openvdb::Int32Tree::LeafNodeType;

/// Whether a corner sees the same patch of the exemplar as the reference, and its coordinate relative to the
/// reference's tile. Patches differ where the coordinate is not what the reference's gradients foresee, sheets of the
/// shell where the depth is not.
class PatchTest {
public:
    PatchTest(const ShellSample& reference, float voxel, float mmPerUnit, const Vec2f& tile)
        : reference_(reference), voxelMm_(voxel * mmPerUnit), mmPerUnit_(mmPerUnit), tile_(tile),
          // Half a voxel's change is more than curvature brings and less than most jumps.
          tolerance_{bound(reference.gradX, voxel, tile.x), bound(reference.gradY, voxel, tile.y)} {}

    bool accept(const ShellSample& sample, const Vec3f& step, Vec2f& exemplar) const {
        const Vec2f foreseen{reference_.exemplar.x + dot(reference_.gradX, step),
                             reference_.exemplar.y + dot(reference_.gradY, step)};
        const float dx = nearestImage(sample.exemplar.x - foreseen.x, tile_.x);
        const float dy = nearestImage(sample.exemplar.y - foreseen.y, tile_.y);
        const float depth = reference_.depth - mmPerUnit_ * dot(reference_.normal, step);
        exemplar = {foreseen.x + dx, foreseen.y + dy};
        return std::abs(dx) <= tolerance_.x && std::abs(dy) <= tolerance_.y &&
               std::abs(sample.depth - depth) <= voxelMm_ && dot(sample.normal, reference_.normal) > 0;
    }

private:
    static float bound(const Vec3f& gradient, float voxel, float tile) {
        return std::min(0.25f * tile, 0.5f * length(gradient) * voxel + 1e-3f * tile);
    }
    static float nearestImage(float d, float tile) { return d - tile * std::nearbyint(d / tile); }

    const ShellSample& reference_;
    float voxelMm_, mmPerUnit_;
    Vec2f tile_, tolerance_;
};

} // namespace

struct ShellGrid::Accessor::Impl {
    explicit Impl(const ShellGridData& g)
        : grid(g), tree(g.tree), perVoxel(1 / g.voxel), voxel(float(g.voxel)),
          mmPerUnit(float(g.mmPerUnit)), tile{float(g.tileMm.x), float(g.tileMm.y)} {}

    /// Sample numbers of the eight corners at `o`, x slowest; false if there is none.
    bool corners(const openvdb::Coord& o, std::int32_t (&number)[8]) {
        constexpr int mask = int(Leaf::DIM) - 1;
        if ((o.x() & mask) != mask && (o.y() & mask) != mask && (o.z() & mask) != mask) {
            const Leaf* leaf = tree.probeConstLeaf(o);
            if (!leaf) {
                return false;
            }
            const std::int32_t* v = leaf->buffer().data() + Leaf::coordToOffset(o);
            constexpr int dx = int(Leaf::DIM * Leaf::DIM), dy = int(Leaf::DIM);
            const std::int32_t all[8] = {v[0], v[1], v[dy], v[dy + 1], v[dx], v[dx + 1], v[dx + dy], v[dx + dy + 1]};
            std::copy(all, all + 8, number);
        } else {
            for (int c = 0; c < 8; ++c) {
                number[c] = tree.getValue(o.offsetBy(c >> 2, c >> 1 & 1, c & 1));
            }
        }
        return std::any_of(number, number + 8, [](std::int32_t n) { return n >= 0; });
    }

    const ShellGridData& grid;
    openvdb::tree::ValueAccessor<const openvdb::Int32Tree, false> tree;
    double perVoxel;
    float voxel, mmPerUnit;
    Vec2f tile;
};

ShellGrid::Accessor::Accessor(const ShellGrid& grid) : impl_(std::make_unique<Impl>(*grid.impl_)) {}
ShellGrid::Accessor::~Accessor() = default;
ShellGrid::Accessor::Accessor(Accessor&&) noexcept = default;

bool ShellGrid::Accessor::lookup(const Vec3f& objectPoint, ShellLookup& out, const Rgb* core) {
    Impl& self = *impl_;
    const Vec3d at = (Vec3d(objectPoint) - self.grid.origin) * self.perVoxel;
    // Also false for NaN and for an empty grid.
    if (!(std::abs(at.x) < 1e9 && std::abs(at.y) < 1e9 && std::abs(at.z) < 1e9)) {
        return false;
    }
    const Vec3d floor(std::floor(at.x), std::floor(at.y), std::floor(at.z));
    const Vec3f f(at - floor);
    std::int32_t number[8];
    if (!self.corners({int(floor.x), int(floor.y), int(floor.z)}, number)) {
        return false;
    }
    // All cache lines are asked for at once; what follows would wait for one after the other.
    for (std::int32_t n : number) {
        if (n >= 0) {
            __builtin_prefetch(&self.grid.samples[std::size_t(n)]);
        }
    }
    const float wx[2] = {1 - f.x, f.x}, wy[2] = {1 - f.y, f.y}, wz[2] = {1 - f.z, f.z};
    float weight[8];
    int nearest = -1;
    for (int c = 0; c < 8; ++c) {
        weight[c] = wx[c >> 2] * wy[c >> 1 & 1] * wz[c & 1];
        if (number[c] >= 0 && (nearest < 0 || weight[c] > weight[nearest])) {
            nearest = c;
        }
    }
    const ShellSample* samples = self.grid.samples.data();
    const ShellSample& reference = samples[number[nearest]];
    const PatchTest patch(reference, self.voxel, self.mmPerUnit, self.tile);

    // Sums of the corners' values, and of what their gradients add on the way to the point.
    float sum = 0, depth = 0, depthStep = 0;
    Vec2f exemplar, exemplarStep;
    Vec3f gradX, gradY, normal;
    Rgb coreSum;
    int used = 0;
    for (int c = 0; c < 8; ++c) {
        if (number[c] < 0) {
            continue;
        }
        const ShellSample& s = samples[number[c]];
        const Vec3f corner(float(c >> 2), float(c >> 1 & 1), float(c & 1));
        Vec2f e = s.exemplar;
        if (c != nearest) {
            const Vec3f ref(float(nearest >> 2), float(nearest >> 1 & 1), float(nearest & 1));
            if (!patch.accept(s, (corner - ref) * self.voxel, e)) {
                continue;
            }
        }
        ++used;
        // The nearest corner always counts, even where rounding makes its weight zero.
        const float w = c == nearest ? std::max(weight[c], 1e-6f) : weight[c];
        const Vec3f step = (f - corner) * self.voxel;
        sum += w;
        exemplar = exemplar + e * w;
        exemplarStep = exemplarStep + Vec2f(dot(s.gradX, step), dot(s.gradY, step)) * w;
        depth += w * s.depth;
        depthStep -= w * self.mmPerUnit * dot(s.normal, step);
        gradX += s.gradX * w;
        gradY += s.gradY * w;
        normal += s.normal * w;
        if (core) {
            coreSum += core[number[c]] * w;
        }
    }
    // With all corners the errors of interpolation and of extrapolation are opposite and equal: their mean is exact to
    // second order. Without some, only extrapolation has no bias.
    const float share = used == 8 ? 0.5f : 1.0f;
    const float scale = 1 / sum;
    out.exemplar = (exemplar + exemplarStep * share) * scale;
    out.depth = (depth + (used == 8 ? 0.0f : depthStep)) * scale;
    out.gradX = gradX * scale;
    out.gradY = gradY * scale;
    out.normal = normalize(normal);
    out.coreRadiance = coreSum * scale;
    return true;
}

} // namespace stf
