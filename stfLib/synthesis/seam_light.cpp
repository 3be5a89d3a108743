// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/seam_light.h"

#include "stfLib/base/parallel.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

namespace stf {

namespace {

constexpr double kTolerance = 1e-4; ///< of the solutions, relative

using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

Eigen::VectorXd solve(const Matrix& matrix, const Eigen::VectorXd& right) {
    if (!(right.squaredNorm() > 0)) {
        return Eigen::VectorXd::Zero(right.size());
    }
    Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper> solver;
    solver.setTolerance(kTolerance);
    solver.setMaxIterations(2000);
    solver.compute(matrix);
    return solver.solve(right);
}

/// Reflectance of the sample's columns spread by diffusion, per texel: periodic, by differences of five points.
std::vector<double> spread(const Exemplar& e, int channel, double diffusionMm) {
    const int w = e.width, h = e.height;
    const double x = diffusionMm / e.texelMm.x, y = diffusionMm / e.texelMm.y;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right(w * h);
    for (int j = 0; j < h; ++j) {
        for (int i = 0; i < w; ++i) {
            const int t = j * w + i;
            entries.push_back({t, t, 1 + 2 * x * x + 2 * y * y});
            for (int side : {-1, 1}) {
                entries.push_back({t, j * w + e.wrapX(i + side), -x * x});
                entries.push_back({t, e.wrapY(j + side) * w + i, -y * y});
            }
            right[t] = double(e.response[std::size_t(t)][channel]);
        }
    }
    Matrix matrix(w * h, w * h);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::VectorXd solution = solve(matrix, right);
    return {solution.data(), solution.data() + solution.size()};
}

/// Bilinear, at a place in mm.
double lookUp(const Exemplar& e, const std::vector<double>& texels, const Vec2f& mm) {
    const double x = double(mm.x) / e.texelMm.x - 0.5, y = double(mm.y) / e.texelMm.y - 0.5;
    const double fx = std::floor(x), fy = std::floor(y), u = x - fx, v = y - fy;
    const auto at = [&](int dx, int dy) {
        return texels[std::size_t(e.wrapY(int(fy) + dy)) * std::size_t(e.width) + std::size_t(e.wrapX(int(fx) + dx))];
    };
    return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

} // namespace

double seamLight(const SurfaceGraph& g, const SurfaceSteps& steps, const SurfaceCoords& coords, const Exemplar& e) {
    if (std::find(coords.broken.begin(), coords.broken.end(), char(1)) == coords.broken.end()) {
        return 0;
    }
    const std::vector<float> weight = cotangentWeights(g);
    // Vertices' areas in mm^2, from any link's length in the surface and in the tile.
    double mm = 0, units = 0;
    for (std::size_t v = 0; v < g.size(); ++v) {
        for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
            mm += double(std::hypot(steps.stepMm[std::size_t(k)].x, steps.stepMm[std::size_t(k)].y));
            units += double(length(g.points[std::size_t(g.neighbour[std::size_t(k)])] - g.points[v]));
        }
    }
    const double perUnit = units > 0 ? mm / units : 1;
    double worst = 0;
    for (int c = 0; c < 3; ++c) {
        const Vec2d tile = e.tileMm();
        const double diffusion = std::min(e.diffusionMm[c], 0.5 * std::max(tile.x, tile.y)), d2 = diffusion * diffusion;
        const std::vector<double> shown = spread(e, c, diffusion);
        double mean = 0;
        for (double r : shown) {
            mean += r / double(shown.size());
        }
        if (!(mean > 0)) {
            continue;
        }
        std::vector<int> perRow(g.size());
        for (std::size_t v = 0; v < g.size(); ++v) {
            perRow[v] = g.first[v + 1] - g.first[v] + 1;
        }
        Matrix matrix(Eigen::Index(g.size()), Eigen::Index(g.size()));
        matrix.reserve(perRow);
        Eigen::VectorXd driven = Eigen::VectorXd::Zero(Eigen::Index(g.size())), area(Eigen::Index(g.size()));
        for (std::size_t v = 0; v < g.size(); ++v) {
            const Eigen::Index row = Eigen::Index(v);
            area[row] = std::max(1e-30, double(g.area[v]) * perUnit * perUnit);
            double diagonal = area[row];
            for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
                const std::size_t s = std::size_t(k), u = std::size_t(g.neighbour[s]);
                const double w = d2 * double(weight[s]);
                diagonal += w;
                matrix.insert(row, Eigen::Index(u)) = -w;
                if (coords.broken[s]) {
                    // What is shown there, less what v's patch has there; the mean of both ends' view of the jump, so
                    // that what one side gains the other loses.
                    const std::size_t back = std::size_t(linkOf(g, int(u), int(v)));
                    const double there =
                        lookUp(e, shown, coords.coord[u]) - lookUp(e, shown, coords.coord[v] + coords.delta[s]);
                    const double here =
                        lookUp(e, shown, coords.coord[u] + coords.delta[back]) - lookUp(e, shown, coords.coord[v]);
                    driven[row] += w * 0.5 * (there + here);
                }
            }
            matrix.insert(row, row) = diagonal;
        }
        matrix.makeCompressed();
        const Eigen::VectorXd change = solve(matrix, driven);
        worst = std::max(worst, std::sqrt(change.cwiseAbs2().dot(area) / area.sum()) / mean);
    }
    return worst;
}

} // namespace stf
