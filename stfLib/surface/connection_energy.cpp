// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/connection_energy.h"

#include "stfLib/base/parallel.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

namespace stf {

namespace {

using Complex = std::complex<double>;
constexpr std::size_t coarsest = 4000; ///< vertices of the level that is factored
constexpr int inverseSteps = 60;       ///< of the inverse iteration
constexpr int smoothingSweeps = 12;    ///< per finer level

struct Level : ConnectionEnergy {
    // How this level's vertices became those of the next.
    std::vector<int> parent;
    std::vector<Complex> fromParent; ///< rotation
};

/// Merges pairs of vertices along their strongest links and restricts the energy to fields that are constant, but for
/// the rotation between them, on each pair.
Level coarser(Level& l) {
    const std::size_t n = l.size();
    l.parent.assign(n, -1);
    l.fromParent.assign(n, Complex(1, 0));
    int count = 0;
    for (std::size_t i = 0; i < n; ++i) {
        if (l.parent[i] >= 0) {
            continue;
        }
        int best = -1;
        float strongest = 0;
        for (int k = l.first[i]; k < l.first[i + 1]; ++k) {
            const std::size_t j = std::size_t(l.neighbour[std::size_t(k)]);
            // Relative to both masses, so that no cluster outgrows the others.
            const float s = std::abs(l.link[std::size_t(k)]) / float(l.mass[i] + l.mass[j]);
            if (l.parent[j] < 0 && s > strongest) {
                strongest = s;
                best = k;
            }
        }
        l.parent[i] = count;
        if (best >= 0) {
            const std::size_t j = std::size_t(l.neighbour[std::size_t(best)]);
            l.parent[j] = count;
            const Complex r = std::conj(Complex(l.link[std::size_t(best)])); // from i to j
            l.fromParent[j] = r / std::abs(r);
        }
        ++count;
    }
    std::vector<int> members(2 * std::size_t(count), -1);
    for (std::size_t i = 0; i < n; ++i) {
        int* m = &members[2 * std::size_t(l.parent[i])];
        m[m[0] >= 0] = int(i);
    }
    Level c;
    c.diagonal.assign(std::size_t(count), 0);
    c.mass.assign(std::size_t(count), 0);
    if (!l.wanted.empty()) {
        c.wanted.assign(std::size_t(count), 0.0);
    }
    c.first.assign(std::size_t(count) + 1, 0);
    std::vector<std::pair<int, Complex>> row;
    for (int p = 0; p < count; ++p) {
        row.clear();
        for (int m = 0; m < 2; ++m) {
            const int member = members[2 * std::size_t(p) + std::size_t(m)];
            if (member < 0) {
                continue;
            }
            const std::size_t i = std::size_t(member);
            c.diagonal[std::size_t(p)] += l.diagonal[i];
            c.mass[std::size_t(p)] += l.mass[i];
            if (!l.wanted.empty()) {
                c.wanted[std::size_t(p)] += std::conj(l.fromParent[i]) * l.wanted[i];
            }
            for (int k = l.first[i]; k < l.first[i + 1]; ++k) {
                const std::size_t j = std::size_t(l.neighbour[std::size_t(k)]);
                const Complex w = std::conj(l.fromParent[i]) * Complex(l.link[std::size_t(k)]) * l.fromParent[j];
                if (l.parent[j] == p) {
                    c.diagonal[std::size_t(p)] -= w.real();
                } else {
                    row.push_back({l.parent[j], w});
                }
            }
        }
        std::sort(row.begin(), row.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        for (std::size_t k = 0; k < row.size(); ++k) {
            if (k > 0 && row[k].first == row[k - 1].first) {
                c.link.back() += std::complex<float>(row[k].second);
            } else {
                c.neighbour.push_back(row[k].first);
                c.link.push_back(std::complex<float>(row[k].second));
            }
        }
        c.first[std::size_t(p) + 1] = int(c.neighbour.size());
    }
    return c;
}

/// Components of a level: each has its own smallest eigenvector.
std::vector<int> components(const Level& l, int& count) {
    std::vector<int> of(l.size(), -1), stack;
    count = 0;
    for (std::size_t s = 0; s < l.size(); ++s) {
        if (of[s] >= 0) {
            continue;
        }
        of[s] = count;
        stack.push_back(int(s));
        while (!stack.empty()) {
            const std::size_t i = std::size_t(stack.back());
            stack.pop_back();
            for (int k = l.first[i]; k < l.first[i + 1]; ++k) {
                const std::size_t j = std::size_t(l.neighbour[std::size_t(k)]);
                if (of[j] < 0) {
                    of[j] = count;
                    stack.push_back(int(j));
                }
            }
        }
        ++count;
    }
    return of;
}

std::vector<Complex> solveCoarsest(const Level& l) {
    const int n = int(l.size());
    std::vector<Eigen::Triplet<Complex>> entries;
    entries.reserve(l.neighbour.size() + l.size());
    double mass = 0, diagonal = 0;
    for (std::size_t i = 0; i < l.size(); ++i) {
        mass += l.mass[i];
        diagonal += l.diagonal[i];
    }
    // A little more than the energy keeps the factor definite on flat surfaces, where the smallest eigenvalue is 0.
    const double shift = 1e-9 * diagonal / mass;
    for (int i = 0; i < n; ++i) {
        const std::size_t s = std::size_t(i);
        entries.push_back({i, i, l.diagonal[s] + shift * l.mass[s] + 1e-12 * diagonal / n});
        for (int k = l.first[s]; k < l.first[s + 1]; ++k) {
            entries.push_back({i, l.neighbour[std::size_t(k)], -Complex(l.link[std::size_t(k)])});
        }
    }
    Eigen::SparseMatrix<Complex> matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<Complex>> factor(matrix);
    if (factor.info() != Eigen::Success) {
        throw Error("the surface's triangles are degenerate: its smooth fields have no solution");
    }
    Eigen::VectorXcd z(n);
    if (!l.wanted.empty()) {
        for (int i = 0; i < n; ++i) {
            z[i] = l.wanted[std::size_t(i)];
        }
        z = factor.solve(z);
    } else {
        int count = 0;
        const std::vector<int> part = components(l, count);
        for (int i = 0; i < n; ++i) {
            // Any start that is not orthogonal to the answer.
            z[i] = std::polar(1.0, 2.399963 * i);
        }
        std::vector<double> norm;
        for (int step = 0; step < inverseSteps; ++step) {
            for (int i = 0; i < n; ++i) {
                z[i] *= l.mass[std::size_t(i)];
            }
            z = factor.solve(z);
            norm.assign(std::size_t(count), 0);
            for (int i = 0; i < n; ++i) {
                norm[std::size_t(part[std::size_t(i)])] += l.mass[std::size_t(i)] * std::norm(z[i]);
            }
            for (int i = 0; i < n; ++i) {
                z[i] /= std::sqrt(std::max(1e-300, norm[std::size_t(part[std::size_t(i)])]));
            }
        }
    }
    std::vector<Complex> out(l.size());
    for (int i = 0; i < n; ++i) {
        out[std::size_t(i)] = z[i];
    }
    return out;
}

void smooth(const Level& l, std::vector<Complex>& z) {
    std::vector<Complex> next(z.size());
    for (int sweep = 0; sweep < smoothingSweeps; ++sweep) {
        parallelFor(l.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                Complex sum = l.wanted.empty() ? Complex(0, 0) : l.wanted[i];
                for (int k = l.first[i]; k < l.first[i + 1]; ++k) {
                    sum += Complex(l.link[std::size_t(k)]) * z[std::size_t(l.neighbour[std::size_t(k)])];
                }
                next[i] = l.diagonal[i] > 0 ? 0.3 * z[i] + 0.7 * sum / l.diagonal[i] : z[i];
            }
        });
        z.swap(next);
    }
}

} // namespace

std::vector<Complex> minimize(ConnectionEnergy energy, const char* stage, Progress& progress) {
    std::vector<Level> levels(1);
    static_cast<ConnectionEnergy&>(levels[0]) = std::move(energy);
    while (levels.back().size() > coarsest) {
        Level next = coarser(levels.back());
        if (next.size() > levels.back().size() * 9 / 10) {
            break; // lone vertices do not merge
        }
        levels.push_back(std::move(next));
        progress.update(stage, 0.3);
    }
    std::vector<Complex> z = solveCoarsest(levels.back());
    progress.update(stage, 0.6);
    for (std::size_t l = levels.size() - 1; l-- > 0;) {
        std::vector<Complex> fine(levels[l].size());
        for (std::size_t i = 0; i < fine.size(); ++i) {
            fine[i] = levels[l].fromParent[i] * z[std::size_t(levels[l].parent[i])];
        }
        z = std::move(fine);
        smooth(levels[l], z);
    }
    progress.update(stage, 1);
    return z;
}

} // namespace stf
