// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/level_distance.h"

#include "stfLib/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stf {

namespace {

int wrap(int i, int n) {
    const int m = i % n;
    return m < 0 ? m + n : m;
}

// A field over a tile: periodic in x and y, constant beyond the first and last layer.
class TileValues {
public:
    TileValues(const Vec3i& size, const std::vector<float>& values) : size_(size), values_(values) {}
    float operator()(int x, int y, int z) const {
        return values_[index(wrap(x, size_.x), wrap(y, size_.y), std::clamp(z, 0, size_.z - 1))];
    }
    std::size_t index(int x, int y, int z) const {
        return std::size_t(x) + std::size_t(size_.x) * (std::size_t(y) + std::size_t(size_.y) * std::size_t(z));
    }
    const Vec3i& size() const { return size_; }

    /// Catmull-Rom spline through the values and its gradient per voxel; positions with middles at whole numbers.
    double spline(const Vec3d& p, Vec3d& gradient) const {
        double w[3][4], d[3][4];
        int base[3];
        for (int a = 0; a < 3; ++a) {
            const double f = std::floor(p[a]), t = p[a] - f;
            base[a] = int(f) - 1;
            w[a][0] = ((-t + 2) * t - 1) * t / 2;
            w[a][1] = ((3 * t - 5) * t * t + 2) / 2;
            w[a][2] = ((-3 * t + 4) * t + 1) * t / 2;
            w[a][3] = (t - 1) * t * t / 2;
            d[a][0] = ((-3 * t + 4) * t - 1) / 2;
            d[a][1] = (9 * t - 10) * t / 2;
            d[a][2] = ((-9 * t + 8) * t + 1) / 2;
            d[a][3] = (3 * t - 2) * t / 2;
        }
        double value = 0;
        gradient = Vec3d(0.0);
        for (int k = 0; k < 4; ++k) {
            for (int j = 0; j < 4; ++j) {
                double row = 0, slope = 0;
                for (int i = 0; i < 4; ++i) {
                    const double v = double((*this)(base[0] + i, base[1] + j, base[2] + k));
                    row += w[0][i] * v;
                    slope += d[0][i] * v;
                }
                value += w[1][j] * w[2][k] * row;
                gradient += Vec3d(w[1][j] * w[2][k] * slope, d[1][j] * w[2][k] * row, w[1][j] * d[2][k] * row);
            }
        }
        return value;
    }

private:
    Vec3i size_;
    const std::vector<float>& values_;
};

std::vector<float> gaussian(const Vec3i& size, const std::vector<float>& values, double sigma) {
    const int reach = int(std::ceil(3.5 * sigma));
    std::vector<double> weights;
    double sum = 0;
    for (int i = -reach; i <= reach; ++i) {
        weights.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
        sum += weights.back();
    }
    std::vector<float> from = values, to(values.size());
    for (int axis = 0; axis < 3; ++axis) {
        const TileValues field(size, from);
        parallelFor(std::size_t(size.z), 1, [&](std::size_t begin, std::size_t end) {
            for (int z = int(begin); z < int(end); ++z) {
                for (int y = 0; y < size.y; ++y) {
                    for (int x = 0; x < size.x; ++x) {
                        double v = 0;
                        for (int i = -reach; i <= reach; ++i) {
                            Vec3i at(x, y, z);
                            at[axis] += i;
                            v += weights[std::size_t(i + reach)] * double(field(at.x, at.y, at.z));
                        }
                        to[field.index(x, y, z)] = float(v / sum);
                    }
                }
            }
        });
        from.swap(to);
    }
    return from;
}

// The middle of a voxel and its nearest point of the surface.
class NearestPoint {
public:
    NearestPoint(const TileValues& level, const Vec3d& voxelMm) : level_(level), h_(voxelMm) {}

    /// Distance in mm, not negative; negative where no neighbour lies on the other side.
    double from(int x, int y, int z) const {
        const Vec3d p(x, y, z);
        const double own = double(level_(x, y, z));
        double nearest = std::numeric_limits<double>::infinity();
        Vec3d start;
        for (int k = -1; k <= 1; ++k) {
            if (z + k < 0 || z + k >= level_.size().z) {
                continue; // constant beyond
            }
            for (int j = -1; j <= 1; ++j) {
                for (int i = -1; i <= 1; ++i) {
                    const double other = double(level_(x + i, y + j, z + k));
                    if ((own < 0) == (other < 0)) {
                        continue;
                    }
                    const Vec3d step = Vec3d(i, j, k) * (own / (own - other));
                    const double d = length(step * h_);
                    if (d < nearest) {
                        nearest = d;
                        start = p + step;
                    }
                }
            }
        }
        return nearest < 1e300 ? refined(p, start, nearest) : -1;
    }

private:
    // Newton steps towards the surface and, along it, towards p. A point on an edge of the grid is never nearer than
    // the nearest point, so a result that is farther away is none.
    double refined(const Vec3d& p, const Vec3d& start, double atStart) const {
        const double h = minComponent(h_);
        Vec3d q = start;
        for (int step = 0; step < 20; ++step) {
            Vec3d slope;
            const double value = level_.spline(q, slope);
            const Vec3d g(slope.x / h_.x, slope.y / h_.y, slope.z / h_.z);
            const double gg = dot(g, g);
            if (!(gg > 0)) {
                return atStart;
            }
            const Vec3d normal = g * (-value / gg);
            const Vec3d away = (p - q) * h_;
            const Vec3d tangent = away - g * (dot(away, g) / gg);
            Vec3d move = normal + tangent;
            const double size = length(move);
            if (size > 0.5 * h) {
                move *= 0.5 * h / size;
            }
            q += move * Vec3d(1 / h_.x, 1 / h_.y, 1 / h_.z);
            if (size < 1e-4 * h) {
                break;
            }
        }
        Vec3d slope;
        const double value = level_.spline(q, slope);
        const Vec3d g(slope.x / h_.x, slope.y / h_.y, slope.z / h_.z);
        const double d = length((q - p) * h_);
        const bool onSurface = std::abs(value) < 1e-2 * h * length(g);
        return onSurface && d <= atStart * (1 + 1e-6) + 1e-3 * h ? d : atStart;
    }

    const TileValues& level_;
    Vec3d h_;
};

// Distance where it satisfies |grad u| = 1 with the smaller neighbour along each axis (Godunov's scheme).
float eikonal(const double (&a)[3], const Vec3d& h) {
    int order[3] = {0, 1, 2};
    std::sort(order, order + 3, [&](int i, int j) { return a[i] < a[j]; });
    double u = a[order[0]] + h[order[0]];
    double ww = 0, wa = 0, waa = 0;
    for (int n = 0; n < 3; ++n) {
        const int k = order[n];
        if (n > 0 && u <= a[k]) {
            break;
        }
        const double w = 1 / (h[k] * h[k]);
        ww += w;
        wa += w * a[k];
        waa += w * a[k] * a[k];
        u = (wa + std::sqrt(std::max(0.0, wa * wa - ww * (waa - 1)))) / ww;
    }
    return float(u);
}

void sweep(const Vec3i& size, const Vec3d& h, const std::vector<char>& fixed, std::vector<float>& u,
           Progress& progress) {
    const TileValues field(size, u);
    constexpr int kMostRounds = 4;
    for (int round = 0; round < kMostRounds; ++round) {
        double change = 0;
        for (int direction = 0; direction < 8; ++direction) {
            progress.update("distance", (round + direction / 8.0) / kMostRounds);
            const bool flip[3] = {(direction & 1) != 0, (direction & 2) != 0, (direction & 4) != 0};
            for (int k = 0; k < size.z; ++k) {
                const int z = flip[2] ? size.z - 1 - k : k;
                for (int j = 0; j < size.y; ++j) {
                    const int y = flip[1] ? size.y - 1 - j : j;
                    const int yLo = y == 0 ? size.y - 1 : y - 1, yHi = y + 1 == size.y ? 0 : y + 1;
                    for (int i = 0; i < size.x; ++i) {
                        const int x = flip[0] ? size.x - 1 - i : i;
                        const std::size_t at = field.index(x, y, z);
                        if (fixed[at]) {
                            continue;
                        }
                        const int xLo = x == 0 ? size.x - 1 : x - 1, xHi = x + 1 == size.x ? 0 : x + 1;
                        const double a[3] = {double(std::min(u[field.index(xLo, y, z)], u[field.index(xHi, y, z)])),
                                             double(std::min(u[field.index(x, yLo, z)], u[field.index(x, yHi, z)])),
                                             double(std::min(u[field.index(x, y, std::max(0, z - 1))],
                                                             u[field.index(x, y, std::min(size.z - 1, z + 1))]))};
                        const float now = eikonal(a, h);
                        if (now < u[at]) {
                            change = std::max(change, double(u[at] - now));
                            u[at] = now;
                        }
                    }
                }
            }
        }
        if (change < 1e-3 * minComponent(h)) {
            break;
        }
    }
}

// Distances of the voxels beside the surface, negative inside; `far` and -`far` elsewhere. `fixed` tells which they
// are.
std::vector<float> nearDistance(const Vec3i& size, const Vec3d& voxelMm, const std::vector<float>& level, float far,
                                std::vector<char>& fixed) {
    const TileValues field(size, level);
    const NearestPoint nearest(field, voxelMm);
    std::vector<float> u(level.size());
    fixed.assign(level.size(), 0);
    parallelFor(std::size_t(size.z), 1, [&](std::size_t begin, std::size_t end) {
        for (int z = int(begin); z < int(end); ++z) {
            for (int y = 0; y < size.y; ++y) {
                for (int x = 0; x < size.x; ++x) {
                    const std::size_t i = field.index(x, y, z);
                    const double d = nearest.from(x, y, z);
                    fixed[i] = d >= 0;
                    u[i] = std::copysign(d >= 0 ? float(d) : far, level[i] < 0 ? -1.0f : 1.0f);
                }
            }
        }
    });
    return u;
}

float farAway(const Vec3i& size, const Vec3d& voxelMm) {
    return 4 * float(size.x * voxelMm.x + size.y * voxelMm.y + size.z * voxelMm.z);
}

// Share of the tile's volume where the distance is below a value near 0, each voxel cut by a plane.
double shareBelow(const Vec3i& size, const Vec3d& h, const std::vector<float>& distance, double value) {
    const TileValues d(size, distance);
    std::vector<double> layers(std::size_t(size.z), 0.0);
    const double reach = length(h) + std::abs(value);
    parallelFor(layers.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (int z = int(begin); z < int(end); ++z) {
            double sum = 0;
            for (int y = 0; y < size.y; ++y) {
                for (int x = 0; x < size.x; ++x) {
                    const double own = double(d(x, y, z)) - value;
                    if (std::abs(own) > reach) {
                        sum += own < 0 ? 1 : 0;
                        continue;
                    }
                    const Vec3d n = normalize(Vec3d((double(d(x + 1, y, z)) - double(d(x - 1, y, z))) / h.x,
                                                    (double(d(x, y + 1, z)) - double(d(x, y - 1, z))) / h.y,
                                                    (double(d(x, y, z + 1)) - double(d(x, y, z - 1))) / h.z));
                    // Height of the voxel along the normal.
                    const double height = std::abs(n.x) * h.x + std::abs(n.y) * h.y + std::abs(n.z) * h.z;
                    sum += std::clamp(0.5 - own / std::max(height, 1e-30), 0.0, 1.0);
                }
            }
            layers[std::size_t(z)] = sum;
        }
    });
    double sum = 0;
    for (const double s : layers) {
        sum += s;
    }
    return sum / (double(size.x) * size.y * size.z);
}

} // namespace

std::vector<float> smoothLevel(const Vec3i& size, const std::vector<float>& level, double sigma) {
    if (!(sigma > 0)) {
        return level;
    }
    std::vector<float> once = gaussian(size, level, sigma);
    const std::vector<float> twice = gaussian(size, once, sigma);
    for (std::size_t i = 0; i < once.size(); ++i) {
        once[i] = 2 * once[i] - twice[i];
    }
    return once;
}

std::vector<float> signedDistance(const Vec3i& size, const Vec3d& voxelMm, const std::vector<float>& level,
                                  Progress& progress) {
    const auto inside = std::size_t(std::count_if(level.begin(), level.end(), [](float v) { return v < 0; }));
    if (inside == 0) {
        throw Error("no voxel is inside the surface");
    }
    if (inside == level.size()) {
        return {};
    }
    std::vector<char> fixed;
    std::vector<float> u = nearDistance(size, voxelMm, level, farAway(size, voxelMm), fixed);
    for (float& d : u) {
        d = std::abs(d);
    }
    sweep(size, voxelMm, fixed, u, progress);
    for (std::size_t i = 0; i < u.size(); ++i) {
        u[i] = level[i] < 0 ? -u[i] : u[i];
    }
    progress.update("distance", 1);
    return u;
}

double insideShare(const Vec3i& size, const Vec3d& h, const std::vector<float>& distance) {
    if (distance.empty()) {
        return 1;
    }
    return shareBelow(size, h, distance, 0);
}

double insideShareOfLevel(const Vec3i& size, const Vec3d& voxelMm, const std::vector<float>& level) {
    std::vector<char> fixed;
    return insideShare(size, voxelMm, nearDistance(size, voxelMm, level, farAway(size, voxelMm), fixed));
}

double moveToShare(const Vec3i& size, const Vec3d& h, double share, std::vector<float>& distance) {
    if (distance.empty()) {
        return 0;
    }
    double lo = -0.5 * minComponent(h), hi = -lo;
    constexpr int kSteps = 10; // to a two-thousandth of a voxel
    for (int step = 0; step < kSteps; ++step) {
        const double middle = (lo + hi) / 2;
        (shareBelow(size, h, distance, middle) < share ? lo : hi) = middle;
    }
    const double shift = (lo + hi) / 2;
    for (float& d : distance) {
        d -= float(shift);
    }
    return shift;
}

} // namespace stf
