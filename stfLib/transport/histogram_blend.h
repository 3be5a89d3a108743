// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/stf_table.h"
#include "stfLib/transport/tile_medium.h"

#include <array>
#include <vector>

namespace stf {

/// Up to three places of a tile that a point shows at once: the path's own position and two affine functions of it, in
/// voxel units, with weights that add up to 1.
struct BlendPlace {
    std::array<Vec2f, 2> origin, alongX, alongY; ///< other(p) = origin + alongX p.x + alongY p.y
    std::array<float, 3> weight{1, 0, 0};        ///< of the position itself and of both others
};

/// Histogram-preserving blending (Heitz & Neyret 2018, "High-Performance By-Example Noise using a Histogram-Preserving
/// Blending Operator", Proc. ACM Comput. Graph. Interact. Tech. 1(2)): a tile laid over itself, so that a surface shows
/// it without seams and without repetition, with the distribution of coefficients that it has. Coefficients
/// (absorption, scattering, mean cosine) of each layer are taken to their principal axes, as channels that vary
/// together must not be blended apart (Deliot & Heitz 2019, GPU Zen 2), made Gaussian there by rank, blended as SUM w G
/// / sqrt(SUM w^2), which keeps the variance, and taken back. Light in the table, which is near Gaussian by itself,
/// keeps mean and variance of its layer the same way.
///
/// Only for media without a surface and samples that are random: what has structure is ghosted. Immutable, thread-safe.
class HistogramBlend {
public:
    /// Throws Error where the medium has a surface. `table`: whose fields are blended, or null.
    HistogramBlend(const TileMedium& medium, const StfTable* table, bool backlight);

    /// Coefficients of three voxels, given by their columns, of one layer.
    TileMedium::Voxel voxel(const std::array<std::size_t, 3>& column, const BlendPlace& place, int z) const;

    /// 1 / sqrt(SUM w^2): by how much a blend of deviations from the mean must grow.
    static float gain(const BlendPlace& place) {
        const std::array<float, 3>& w = place.weight;
        return 1 / std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    }
    /// Means over the layers (items) of the table's parts; empty where the part is.
    const FactoredField& meanMultiple() const { return meanMultiple_; }
    const FactoredField& meanBacklight() const { return meanBacklight_; }
    const FactoredField& meanEmitted() const { return meanEmitted_; }

    std::size_t bytes() const;

private:
    static constexpr int kChannels = 7;    ///< absorption, scattering, mean cosine
    static constexpr int kQuantiles = 128; ///< of an axis, at even steps of the Gaussian from -kReach to kReach
    static constexpr float kReach = 3.5f;
    using Channels = std::array<float, kChannels>;
    struct Axis {
        Channels direction;                      ///< what a unit along the axis adds
        std::array<float, kQuantiles> quantiles; ///< position along the axis of a Gaussian value
    };
    struct Layer {
        Channels mean;
        int firstAxis = 0, axes = 0;
    };

    TransportForm form_;
    std::size_t columns_ = 0;
    int most_ = 0; ///< axes of any layer
    std::vector<Layer> layers_;
    std::vector<Axis> axes_;
    std::vector<float> gaussian_; ///< [voxel][axis], most_ of them
    FactoredField meanMultiple_, meanBacklight_, meanEmitted_;
};

} // namespace stf
