// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/surface/direction_field.h"
#include "stfLib/synthesis/exemplar_map.h"
#include "stfLib/synthesis/heal_breaks.h"

namespace stf {

struct SynthesisOptions {
    std::uint64_t seed = 0;
    double patchMm = 0;             ///< distance between the middles of patches; 0: chosen by the sample
    std::vector<Vec3f> orientation; ///< wanted tangents, per point of the surface; empty: the smoothest field
    std::vector<Rgb> response;      ///< reflectance per column where known; empty: estimated
};

/// A surface grown over with a sample, and all that measures it.
struct Synthesis {
    Exemplar exemplar;
    SurfaceGraph graph;
    std::vector<Vec3f> directions; ///< per vertex of the graph
    std::vector<Singularity> singularities;
    SurfaceSteps steps;
    ChartCover cover;
    PatchLabels labels;
    SurfaceCoords coords;
    double mmPerUnit = 1;
    double patchMm = 0;
    /// Seconds of the stages, in order.
    std::vector<std::pair<std::string, double>> seconds;
};

/// The surface with a vertex for about every `texelMm` of the sample, no more than `maxTriangles` triangles. A `pose`
/// of it follows.
RefinedSurface sampleSurface(RefinedSurface surface, double texelMm, double mmPerUnit, std::size_t maxTriangles,
                             const MessageSink& messages, SurfacePose* pose = nullptr);

/// By-example synthesis of exemplar coordinates on a surface, which should be sampled about once per texel
/// (docs/synthesis.md): charts that follow a direction field, the part of the sample each shows by k-coherence in
/// appearance space, seams by graph cuts, correction passes. The same for any number of threads. Throws Error,
/// Cancelled.
Synthesis synthesize(const RefinedSurface& surface, const BaseVolume& volume, double mmPerUnit,
                     const SynthesisOptions& options, Progress& progress);

/// Cosine and sine of the angle by which the sample is turned at a vertex against the field: 0 where its patch follows
/// the field.
Vec2f patchTurn(const Synthesis& synthesis, std::size_t v);

/// Coordinates and gradients per triangle corner. A triangle across a seam belongs to the patch of one of its corners,
/// whose coordinates are continued to the others.
ExemplarMap exemplarMap(const Synthesis& synthesis);

} // namespace stf
