// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/direction_set.h"

#include <cstddef>
#include <vector>

namespace stf {

/// Light at an item (voxel or column): fluence, and net flux along the direction towards the viewer where stored.
struct FieldValue {
    Rgb fluence{0.0f};
    Rgb fluxAlong{0.0f};
};

class FactoredField;

/// Lights folded into what a lookup multiplies the factors with, for one direction towards the viewer: after folding, a
/// lookup costs the same for any number of lights. Reused without allocation.
class FoldedLight {
public:
    /// Empty: no light.
    void clear(const FactoredField& field);
    /// Adds a light of perpendicular `irradiance`; both directions are unit vectors in the tile's frame (z outward).
    /// For a field without light directions: DirectionSet(1, 1) and (0, 0, 1).
    void add(const FactoredField& field, const DirectionSet& directions, const Vec3f& towardsLight,
             const Rgb& irradiance, const Vec3f& towardsViewer);
    bool dark() const { return dark_; }

private:
    friend class FactoredField;
    std::vector<Rgb> factors_; ///< [k][4]: fluence, flux x, y, z
    std::vector<float> sums_;  ///< [2][k]: b_k at a direction, for what is even and what is odd across the pole
    bool dark_ = true;
};

/// A field over items and light directions, stored with low rank (DESIGN 3.7): value(item, direction) =
/// sum over k of a_k(item) b_k(direction). Components of an item are rgb fluence and, where flux is stored, its rgb
/// along x, y, z of the tile's frame (z outward; direction of travel). With one azimuth in the direction set the
/// horizontal axes are not the tile's but those of the light: radial (towards the light) and tangential (its left, so
/// that radial x tangential = outward).
/// A field without light directions (backlight, emission) has rank 1 and one direction with b = 1.
class FactoredField {
public:
    int rank = 0;
    int components = 3;         ///< 3 without flux, 12 with it
    int directions = 0;         ///< rows of `basis`
    std::vector<float> factors; ///< a: [item][k][component]
    std::vector<float> basis;   ///< b: [direction][k]

    bool empty() const { return rank == 0; }
    bool hasFlux() const { return components == 12; }
    std::size_t items() const { return rank ? factors.size() / (std::size_t(rank) * std::size_t(components)) : 0; }
    std::size_t bytes() const { return (factors.size() + basis.size()) * sizeof(float); }

    /// The field under folded lights.
    FieldValue at(std::size_t item, const FoldedLight& light) const {
        FieldValue v;
        if (light.dark_) {
            return v;
        }
        const float* a = factors.data() + item * std::size_t(rank) * std::size_t(components);
        const Rgb* f = light.factors_.data();
        for (int k = 0; k < rank; ++k, f += 4, a += components) {
            v.fluence += Rgb(a[0], a[1], a[2]) * f[0];
            if (components == 12) {
                v.fluxAlong +=
                    Rgb(a[3], a[4], a[5]) * f[1] + Rgb(a[6], a[7], a[8]) * f[2] + Rgb(a[9], a[10], a[11]) * f[3];
            }
        }
        return v;
    }
    /// One component of an item at a node of the direction set.
    float node(std::size_t item, int direction, int component) const;
    /// Fluence (or any rgb) of an item for light from one direction.
    Rgb rgb(std::size_t item, const DirectionWeights& w) const;
    /// A field of rank 1 without light directions from [item][component].
    static FactoredField single(std::vector<float> values, int components);
};

/// What `factorise` is given and what it says.
struct FactoriseOptions {
    double tolerance = 0.005; ///< wanted error by truncation, relative to the field's rms
    int maxRank = 48;
    /// Expected noise of the values as a Gram matrix over directions ([direction][direction], in the same norm), or
    /// empty: factors that hold more noise than signal are dropped, and noise is not taken for truncation error.
    std::vector<double> noiseGram;
    /// Share of that noise (its power) that is left where the field is read, between values and over neighbours: a
    /// factor is dropped by the noise that would be seen.
    double noiseRead = 1;
    std::vector<float> weights; ///< of the squares of the components of each item in the norm, [item][component];
                                ///< empty: 1
};
struct FactoriseReport {
    double truncation = 0; ///< rms error by truncation relative to the rms of the field, noise taken off
    double noise = 0;      ///< rms noise that is left after truncation, relative; 0 without noiseGram
};

/// Factors values given as [direction][item][component] by the eigenvectors of their Gram matrix over directions, less
/// that of the noise (Eckart & Young 1936, "The Approximation of One Matrix by Another of Lower Rank", Psychometrika 1:
/// the best approximation of that rank in the mean square). The scale is in the basis: the largest |a_k| of each k lies
/// in [4096, 8192), where half precision has its widest range. Sums in double; the same for any number of threads.
/// Throws Error where values are not finite or lengths do not agree.
FactoredField factorise(const std::vector<std::vector<float>>& values, int components, const FactoriseOptions& options,
                        FactoriseReport* report = nullptr);

} // namespace stf
