// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/surface_field.h"

#include "stfLib/transport/tile_tracer.h"

#include <algorithm>
#include <limits>

namespace stf {

namespace {

// Of the field, relative to the distances around: positions are floats of a few hundred voxels.
constexpr float kRounding = 4e-5f;
// Numbers of cells through which no surface passes.
constexpr std::int32_t kOutside = -1, kInside = -2;

// Trilinear between eight corners, f in [0, 1].
float trilinear(const float* c, const Vec3f& f) {
    const auto mix = [](float a, float b, float t) { return a + (b - a) * t; };
    return mix(mix(mix(c[0], c[1], f.x), mix(c[2], c[3], f.x), f.y),
               mix(mix(c[4], c[5], f.x), mix(c[6], c[7], f.x), f.y), f.z);
}

// The eight distances around a point, with its place between them.
struct Cell {
    float corner[8];
    float base[3]; // position of the first corner
    float value(const Vec3f& p) const {
        return trilinear(corner, {std::clamp(p.x - base[0], 0.0f, 1.0f), std::clamp(p.y - base[1], 0.0f, 1.0f),
                                  std::clamp(p.z - base[2], 0.0f, 1.0f)});
    }
};

} // namespace

SurfaceField::SurfaceField(const Vec3i& size, const Vec3d& voxelMm, const std::vector<float>& distance)
    : size_(size), voxelMm_(voxelMm) {
    if (std::none_of(distance.begin(), distance.end(), [](float d) { return d >= 0; })) {
        return;
    }
    distance_ = distance;
    // Zero would be a plateau that is neither inside nor out.
    const float least = 1e-4f * float(minComponent(voxelMm));
    for (float& d : distance_) {
        d = d >= 0 ? std::max(d, least) : std::min(d, -least);
    }
    kind_.resize(distance_.size());
    std::size_t i = 0;
    for (int z = 0; z < size_.z; ++z) {
        for (int y = 0; y < size_.y; ++y) {
            for (int x = 0; x < size_.x; ++x, ++i) {
                bool in = false, out = false;
                for (int c = 0; c < 27; ++c) {
                    const float d = at(x + c % 3 - 1, y + c / 3 % 3 - 1, z + c / 9 - 1);
                    in = in || d < 0;
                    out = out || d >= 0;
                }
                kind_[i] = in && out ? 2 : in ? 1 : 0;
            }
        }
    }
    cell_.assign(std::size_t(size_.x) * std::size_t(size_.y) * std::size_t(size_.z + 1), kOutside);
    for (int z = -1; z < size_.z; ++z) {
        for (int y = 0; y < size_.y; ++y) {
            for (int x = 0; x < size_.x; ++x) {
                std::array<float, 8> corners;
                bool in = false, out = false;
                for (int k = 0; k < 8; ++k) {
                    corners[std::size_t(k)] = at(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2));
                    in = in || corners[std::size_t(k)] < 0;
                    out = out || corners[std::size_t(k)] >= 0;
                }
                if (in && out) {
                    cell_[cellNumber(x, y, z)] = std::int32_t(corners_.size());
                    corners_.push_back(corners);
                } else if (in) {
                    cell_[cellNumber(x, y, z)] = kInside;
                }
            }
        }
    }
}

float SurfaceField::at(int x, int y, int z) const {
    z = std::clamp(z, 0, size_.z - 1);
    return distance_[std::size_t(TileTracer::wrap(x, size_.x)) +
                     std::size_t(size_.x) *
                         (std::size_t(TileTracer::wrap(y, size_.y)) + std::size_t(size_.y) * std::size_t(z))];
}

namespace {

template<class At>
Cell cellAround(const Vec3f& p, At&& at) {
    Cell c;
    int b[3];
    for (int a = 0; a < 3; ++a) {
        c.base[a] = std::floor(p[a] - 0.5f) + 0.5f;
        b[a] = int(std::floor(p[a] - 0.5f));
    }
    for (int k = 0; k < 8; ++k) {
        c.corner[k] = at(b[0] + (k & 1), b[1] + (k >> 1 & 1), b[2] + (k >> 2));
    }
    return c;
}

} // namespace

float SurfaceField::value(const Vec3f& p) const {
    return cellAround(p, [this](int x, int y, int z) { return at(x, y, z); }).value(p);
}

Vec3f SurfaceField::normal(const Vec3f& p) const {
    const Cell c = cellAround(p, [this](int x, int y, int z) { return at(x, y, z); });
    Vec3f gradient;
    for (int a = 0; a < 3; ++a) {
        Vec3f lo = p, hi = p;
        lo[a] = c.base[a], hi[a] = c.base[a] + 1; // linear along each axis within the cell: exact
        gradient[a] = (c.value(hi) - c.value(lo)) / float(voxelMm_[a]);
    }
    const float l = length(gradient);
    return l > 0 ? gradient / l : Vec3f(0, 0, -1);
}

Vec3f SurfaceField::smoothNormal(const Vec3f& p) const {
    Vec3f gradient;
    for (int a = 0; a < 3; ++a) {
        Vec3f lo = p, hi = p;
        lo[a] -= 0.5f, hi[a] += 0.5f;
        gradient[a] = (value(hi) - value(lo)) / float(voxelMm_[a]);
    }
    const float l = length(gradient);
    return l > 0 ? gradient / l : normal(p);
}

float SurfaceField::crossing(const Vec3i& voxel, const Vec3f& p, const Vec3f& d, float t0, float t1,
                             bool inside) const {
    // From here on the voxel is [-0.5, 0.5]^3: within it the interpolant changes its polynomial where a coordinate is
    // 0. By its index, not by where the stretch lies: a stretch along a face may round into the next voxel.
    Vec3f q;
    for (int a = 0; a < 3; ++a) {
        q[a] = p[a] - (float(voxel[a]) + 0.5f);
        if (a < 2) {
            const float size = float(size_[a]);
            q[a] -= std::floor((q[a] + d[a] * 0.5f * (t0 + t1)) / size + 0.5f) * size;
        }
    }
    float cut[5] = {t0, t1, t1, t1, t1};
    int cuts = 1;
    for (int a = 0; a < 3; ++a) {
        const float t = -q[a] / d[a];
        if (t > t0 && t < t1) {
            int place = cuts++; // insertion: at most three, in order
            for (; place > 1 && cut[place - 1] > t; --place) {
                cut[place] = cut[place - 1];
            }
            cut[place] = t;
        }
    }
    cut[cuts] = t1;
    for (int i = 0; i < cuts; ++i) {
        const float a = cut[i], b = cut[i + 1];
        if (!(b > a)) {
            continue;
        }
        const Vec3f middle = q + d * (0.5f * (a + b));
        int base[3];
        Vec3f local;
        for (int k = 0; k < 3; ++k) {
            const bool lower = middle[k] < 0;
            base[k] = lower ? voxel[k] - 1 : voxel[k];
            local[k] = lower ? q[k] + 1 : q[k];
            if (k < 2 && base[k] < 0) {
                base[k] += size_[k];
            }
        }
        const std::int32_t number = cell_[cellNumber(base[0], base[1], base[2])];
        if (number < 0) {
            if ((number == kInside) == inside) {
                continue;
            }
            return a; // it missed its crossing
        }
        const float* const corner = corners_[std::size_t(number)].data();
        const auto value = [&](float t) { return trilinear(corner, local + d * t); };
        const auto wrong = [&](float v) { return inside ? v > 0 : v < 0; };
        // A cubic along the line: thirds catch all but the most grazing double roots.
        float left = a, valueLeft = value(a);
        for (int k = 1; k <= 3; ++k) {
            const float right = k == 3 ? b : a + (b - a) * float(k) / 3, valueRight = value(right);
            if (wrong(valueRight)) {
                if (!wrong(valueLeft)) {
                    float lo = left, hi = right;
                    for (int step = 0; step < 24 && hi - lo > 1e-6f * (t1 - t0); ++step) {
                        const float half = 0.5f * (lo + hi);
                        (wrong(value(half)) ? hi : lo) = half;
                    }
                    return hi;
                }
                // It started on the wrong side, by rounding. On its way back to the right one, as after a reflection,
                // it has nothing to pass; otherwise it passes at once, or with the next stretch where this one is too
                // short to tell.
                float largest = 0;
                for (int c = 0; c < 8; ++c) {
                    largest = std::max(largest, std::abs(corner[c]));
                }
                if (std::abs(valueRight) >= std::abs(valueLeft) + kRounding * largest) {
                    return left;
                }
            }
            left = right;
            valueLeft = valueRight;
        }
    }
    return std::numeric_limits<float>::infinity();
}

std::vector<float> SurfaceField::fill() const {
    // Exact along lines in z, where the field is linear in each half of a voxel; lines on a Fibonacci lattice, whose
    // projections on x and on y are evenly spaced, so that a wall along an axis is known to 1 / 288.
    constexpr int kLines = 144, kStep = 89;
    const auto insideShare = [](float a, float b) {
        return a < 0 ? (b < 0 ? 1.0f : a / (a - b)) : b < 0 ? b / (b - a) : 0.0f;
    };
    std::vector<float> share(distance_.size());
    std::size_t i = 0;
    for (int z = 0; z < size_.z; ++z) {
        for (int y = 0; y < size_.y; ++y) {
            for (int x = 0; x < size_.x; ++x, ++i) {
                if (kind_[i] != 2) {
                    share[i] = float(kind_[i]);
                    continue;
                }
                float in = 0;
                for (int k = 0; k < kLines; ++k) {
                    Vec3f p{float(x) + (float(k) + 0.5f) / kLines,
                            float(y) + (float(k * kStep % kLines) + 0.5f) / kLines, float(z)};
                    const float top = value(p);
                    p.z += 0.5f;
                    const float middle = value(p);
                    p.z += 0.5f;
                    in += insideShare(top, middle) + insideShare(middle, value(p));
                }
                share[i] = in / (2 * kLines);
            }
        }
    }
    return share;
}

} // namespace stf
