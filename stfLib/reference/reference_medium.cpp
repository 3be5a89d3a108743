// SPDX-License-Identifier: Apache-2.0
#include "stfLib/reference/reference_medium.h"

#include <algorithm>
#include <numeric>

namespace stf {

namespace {

int wrapIndex(int i, int size) {
    const int r = i % size;
    return r < 0 ? r + size : r;
}

} // namespace

std::size_t ReferenceMedium::wrapped(int x, int y, int z) const {
    const Vec3i& n = volume_->size;
    return volume_->index(wrapIndex(x, n.x), wrapIndex(y, n.y), std::clamp(z, 0, n.z - 1));
}

ReferenceMedium::ReferenceMedium(std::shared_ptr<const BaseVolume> volume) : volume_(std::move(volume)) {
    const BaseVolume& v = *volume_;
    // Voids without a distance are void by their coefficients.
    relief_ = std::any_of(v.surface.begin(), v.surface.end(), [](float d) { return d >= 0; });
    const std::size_t count = v.voxelCount();
    if (relief_) {
        stand_.resize(count);
        std::iota(stand_.begin(), stand_.end(), 0u);
    }
    float brightest = 0;
    std::size_t i = 0;
    for (int z = 0; z < v.size.z; ++z) {
        for (int y = 0; y < v.size.y; ++y) {
            for (int x = 0; x < v.size.x; ++x, ++i) {
                const bool material = !relief_ || v.surface[i] < 0;
                majorant_ = std::max(majorant_, maxComponent(v.extinction[i]));
                refracts_ = refracts_ || (material && !v.ior.empty() && v.ior[i] != 1);
                brightest = std::max(brightest, v.emission.empty() ? 0.0f : maxComponent(v.emission[i]));
                if (!relief_) {
                    continue;
                }
                const std::size_t next[3] = {wrapped(x + 1, y, z), wrapped(x, y + 1, z), wrapped(x, y, z + 1)};
                float square = 0;
                for (int a = 0; a < 3; ++a) {
                    const float slope = (v.surface[next[a]] - v.surface[i]) / float(v.voxelMm[a]);
                    square += slope * slope;
                }
                steepest_ = std::max(steepest_, std::sqrt(square));
                if (material || maxComponent(v.extinction[i]) > 0) {
                    continue;
                }
                for (int c = 0; c < 27; ++c) {
                    const int nz = z + c / 9 - 1;
                    const std::size_t n = wrapped(x + c % 3 - 1, y + c / 3 % 3 - 1, nz);
                    if (nz >= 0 && nz < v.size.z && v.surface[n] < v.surface[stand_[i]]) {
                        stand_[i] = std::uint32_t(n);
                    }
                }
            }
        }
    }
    // The slope of a trilinear cell is at most that of its steepest edges together.
    steepest_ *= 1.75f;
    emits_ = brightest > 0;
    if (emits_) {
        majorant_ = std::max(majorant_, float(1 / v.extentMm().z));
    }
}

std::size_t ReferenceMedium::voxelAt(const Vec3f& mm) const {
    const Vec3d& h = volume_->voxelMm;
    const std::size_t i = wrapped(int(std::floor(double(mm.x) / h.x)), int(std::floor(double(mm.y) / h.y)),
                                  int(std::floor(double(mm.z) / h.z)));
    return stand_.empty() ? i : stand_[i];
}

float ReferenceMedium::iorBelow(const Vec3f& mm) const {
    Vec3f p = mm;
    const float step = float(volume_->voxelMm.z), depth = float(volume_->extentMm().z);
    while (!inside(p) && p.z < depth) {
        p.z += step;
    }
    return ior(voxelAt(p));
}

float ReferenceMedium::distance(const Vec3f& mm) const {
    int base[3];
    float f[3];
    for (int a = 0; a < 3; ++a) {
        const float at = mm[a] / float(volume_->voxelMm[a]) - 0.5f;
        base[a] = int(std::floor(at));
        f[a] = at - float(base[a]);
    }
    float sum = 0;
    for (int c = 0; c < 8; ++c) {
        const float weight = (c & 1 ? f[0] : 1 - f[0]) * (c & 2 ? f[1] : 1 - f[1]) * (c & 4 ? f[2] : 1 - f[2]);
        sum += weight * volume_->surface[wrapped(base[0] + (c & 1), base[1] + (c >> 1 & 1), base[2] + (c >> 2))];
    }
    return sum;
}

Vec3f ReferenceMedium::difference(const Vec3f& mm, float voxels) const {
    Vec3f slope;
    for (int a = 0; a < 3; ++a) {
        const float h = voxels * float(volume_->voxelMm[a]);
        Vec3f low = mm, high = mm;
        low[a] -= 0.5f * h;
        high[a] += 0.5f * h;
        slope[a] = (distance(high) - distance(low)) / h;
    }
    return slope;
}

Vec3f ReferenceMedium::gradient(const Vec3f& mm) const {
    return difference(mm, 1e-2f);
}

Vec3f ReferenceMedium::smoothGradient(const Vec3f& mm) const {
    return difference(mm, 1);
}

} // namespace stf
