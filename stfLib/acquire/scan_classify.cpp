// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_classify.h"

#include "stfLib/acquire/box_filter.h"
#include "stfLib/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace stf {

namespace {

// Values between the middles of voxels, constant beyond the outermost.
double trilinear(const ScanView& s, const Vec3d& p) {
    int lo[3], hi[3];
    double t[3];
    for (int a = 0; a < 3; ++a) {
        const double q = std::clamp(p[a], 0.0, s.size[a] - 1.0);
        lo[a] = int(q);
        hi[a] = std::min(lo[a] + 1, s.size[a] - 1);
        t[a] = q - lo[a];
    }
    const auto row = [&](int y, int z) { return double(s(lo[0], y, z)) * (1 - t[0]) + double(s(hi[0], y, z)) * t[0]; };
    const auto plane = [&](int z) { return row(lo[1], z) * (1 - t[1]) + row(hi[1], z) * t[1]; };
    return plane(lo[2]) * (1 - t[2]) + plane(hi[2]) * t[2];
}

// Classifies single voxels; one per thread, for its scratch space.
class VoxelClassifier {
public:
    VoxelClassifier(const ScanView& scan, const ScanClassifier& rule)
        : scan_(scan), rule_(rule), low_(rule.isVoid.size()), high_(rule.isVoid.size()), own_(rule.isVoid.size()) {}

    /// Adds weight times the fractions of the materials that are no voids.
    void add(int x, int y, int z, double weight, double* sums) {
        const double value = double(scan_(x, y, z));
        rule_.transfer.evaluate(value, own_.data());
        if (rule_.steep > 0) {
            byEdge(x, y, z, value);
        }
        for (std::size_t m = 0, to = 0; m < own_.size(); ++m) {
            if (!rule_.isVoid[m]) {
                sums[to++] += weight * own_[m];
            }
        }
    }

private:
    void byEdge(int x, int y, int z, double value) {
        const Vec3i at(x, y, z);
        Vec3d gradient;
        for (int a = 0; a < 3; ++a) {
            Vec3i up = at, down = at;
            up[a] = std::min(at[a] + 1, scan_.size[a] - 1);
            down[a] = std::max(at[a] - 1, 0);
            const int steps = up[a] - down[a];
            gradient[a] = steps == 0 ? 0.0
                                     : (double(scan_(up.x, up.y, up.z)) - double(scan_(down.x, down.y, down.z))) /
                                           (steps * scan_.spacingMm[a]);
        }
        const double size = length(gradient);
        const double w = rule_.steep > rule_.flat
                             ? std::clamp((size - rule_.flat) / (rule_.steep - rule_.flat), 0.0, 1.0)
                             : (size >= rule_.steep ? 1.0 : 0.0);
        if (!(w > 0)) {
            return;
        }
        // Two voxels to either side, along the gradient, as far as a voxel is wide there.
        Vec3d step;
        double widest = 0;
        for (int a = 0; a < 3; ++a) {
            step[a] = gradient[a] / size / scan_.spacingMm[a];
            widest = std::max(widest, std::abs(step[a]));
        }
        step *= 2 / widest;
        const double high = std::max(value, trilinear(scan_, Vec3d(at) + step));
        const double low = std::min(value, trilinear(scan_, Vec3d(at) - step));
        const double t = high > low ? (value - low) / (high - low) : 0.5;
        rule_.transfer.evaluate(low, low_.data());
        rule_.transfer.evaluate(high, high_.data());
        for (std::size_t m = 0; m < own_.size(); ++m) {
            own_[m] += w * (low_[m] + t * (high_[m] - low_[m]) - own_[m]);
        }
    }

    const ScanView& scan_;
    const ScanClassifier& rule_;
    std::vector<double> low_, high_, own_;
};

// One row of the result from rows of the old grid that were summed over y and z.
void shrinkRow(const std::vector<double>& row, const AxisWeights& w, int channels, int newCells, float* out) {
    for (int x = 0; x < newCells; ++x) {
        for (int m = 0; m < channels; ++m) {
            double sum = 0;
            for (int j = 0; j < w.count(x); ++j) {
                sum += w.weights[std::size_t(w.begin[std::size_t(x)] + j)] *
                       row[std::size_t((w.first[std::size_t(x)] + j) * channels + m)];
            }
            out[x * channels + m] = float(sum);
        }
    }
}

// Calls visit(old y, old z, weight) for the rows that make a row of the result.
template<class Visit>
void rowsOf(const AxisWeights& wy, const AxisWeights& wz, int y, int z, Visit visit) {
    for (int k = 0; k < wz.count(z); ++k) {
        for (int j = 0; j < wy.count(y); ++j) {
            visit(wy.first[std::size_t(y)] + j, wz.first[std::size_t(z)] + k,
                  wy.weights[std::size_t(wy.begin[std::size_t(y)] + j)] *
                      wz.weights[std::size_t(wz.begin[std::size_t(z)] + k)]);
        }
    }
}

} // namespace

TileField classifyScan(const ScanView& scan, const ScanClassifier& classifier, const LevelRule& level,
                       const Vec3i& size, Progress& progress) {
    TileField field;
    field.size = size;
    field.materials = classifier.solidMaterials();
    AxisWeights box[3], line[3];
    for (int a = 0; a < 3; ++a) {
        field.voxelMm[a] = scan.spacingMm[a] * scan.size[a] / size[a];
        box[a] = boxWeights(scan.size[a], size[a]);
        line[a] = boxOrLinearWeights(scan.size[a], size[a]);
    }
    const int kinds = field.materials;
    field.fractions.resize(field.voxelCount() * std::size_t(kinds));
    if (level.wanted) {
        field.level.resize(field.voxelCount());
    }
    const double sign = level.insideAbove ? -1 : 1;
    std::atomic<int> done{0};
    parallelFor(std::size_t(size.z), 1, [&](std::size_t begin, std::size_t end) {
        VoxelClassifier voxels(scan, classifier);
        std::vector<double> row(std::size_t(scan.size.x * kinds)), levels(std::size_t(scan.size.x));
        for (int z = int(begin); z < int(end); ++z) {
            for (int y = 0; y < size.y; ++y) {
                const std::size_t to = field.index(0, y, z);
                std::fill(row.begin(), row.end(), 0.0);
                rowsOf(box[1], box[2], y, z, [&](int oy, int oz, double w) {
                    for (int x = 0; x < scan.size.x; ++x) {
                        voxels.add(x, oy, oz, w, row.data() + x * kinds);
                    }
                });
                shrinkRow(row, box[0], kinds, size.x, field.fractions.data() + to * std::size_t(kinds));
                if (level.wanted) {
                    std::fill(levels.begin(), levels.end(), 0.0);
                    rowsOf(line[1], line[2], y, z, [&](int oy, int oz, double w) {
                        for (int x = 0; x < scan.size.x; ++x) {
                            levels[std::size_t(x)] += w * sign * (double(scan(x, oy, oz)) - level.iso);
                        }
                    });
                    shrinkRow(levels, line[0], 1, size.x, field.level.data() + to);
                }
            }
            progress.update("classify", double(++done) / size.z);
        }
    });
    return field;
}

} // namespace stf
