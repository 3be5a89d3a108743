// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/sampler.h"
#include "stfLib/transport/histogram_blend.h"
#include "stfLib/transport/stf_table.h"
#include "stfLib/transport/tile_medium.h"

#include <array>
#include <vector>

namespace stf {

/// One light of a path as the tile sees it, with the visibility by other geometry already in it.
struct MarchLight {
    Vec3f towards{0, 0, 1}; ///< unit, outside of the medium, tile frame (z outward)
    Rgb forSingle{0.0f};    ///< perpendicular irradiance outside, exact visibility
    Rgb forMultiple{0.0f};  ///< perpendicular irradiance outside, visibility averaged over the diffusion disc
};

/// Radiance inside the medium that a path collects. Emission that reaches the eye directly counts as multiple.
struct TileRadiance {
    Rgb single{0.0f}, multiple{0.0f};
};

/// Where a straight piece meets the surface of a relief.
struct ReliefMeeting {
    float atMm = 0;        ///< of the piece
    Vec3f facet{0, 0, 1};  ///< unit normal of the field that walks refract at, out of the material; tile frame, mm
    Vec3f normal{0, 0, 1}; ///< the same without the field's creases
    float ior = 1;         ///< of the material there
};

/// Marches straight pieces through a tile (DESIGN 3.3, 3.8):
///   L = INT Tr [ kappa a SUM_l f_HG(w_l, w) I_0 I_s + kappa' a' (I + 3 g' F.w) / 4 pi + emission ] ds
/// with I, F the fluence and net flux of the table: I_m of the lights, I_b of the core and of the emission; kappa'
/// attenuates. Steps end where tile voxels do and are integrated in closed form (optics/step_weights.h).
///
/// Multiple scattering is summed over all steps. Single scattering is taken at a few of them, chosen by their weights
/// (unbiased), with the light's own attenuation through the tile; only where the table stores it (under a refracting
/// relief) it is summed over all steps as well.
///
/// Use: begin, then setFrame and segment for each straight piece, then finish. One path at a time; keeps its buffers.
/// Reads parts of the table at their first use, which throws Error where the file is damaged.
class TileMarch {
public:
    /// `blend`: of the same medium and table, where points may show several places of the tile at once; or null.
    TileMarch(const TileMedium& medium, const StfTable& table, const HistogramBlend* blend = nullptr);

    /// Starts a path. It sees the tile shifted at random by up to half of `shift` voxels along x and y: the image is
    /// then that of the voxels under a box filter so wide, and no single voxel shows its faces. Pixels that are as wide
    /// as voxels need none (`shiftFor`); 0: the voxels as they are. Draws the same count of random numbers for any. The
    /// table is read with a lateral offset of its own, which makes its expectation bilinear in x and y.
    void begin(PixelSampler& sampler, Vec2f shift = {1, 1});
    /// What a pixel of this width lacks to a voxel's, in voxels.
    static Vec2f shiftFor(float footprintMm, const Vec3d& voxelMm) {
        return {std::clamp(1 - footprintMm / float(voxelMm.x), 0.0f, 1.0f),
                std::clamp(1 - footprintMm / float(voxelMm.y), 0.0f, 1.0f)};
    }

    /// Lights (copied) and the unit direction of the light that reaches the camera, inside the medium, both in the
    /// tile's frame at the next segments. Cheap where they hardly differ from the last ones: below 1.5 milliradians
    /// those are kept.
    void setFrame(const MarchLight* lights, int count, const Vec3f& towardsViewer);

    /// Which places of the tile the next segments show beside their own; nothing without a blend. Each step of a
    /// voxel of the position's own tile has one blend, that of its middle.
    void setBlend(const BlendPlace& place);

    /// Marches `lengthMm` from a position (voxel units, z inward, clamped into the tile) along a direction in voxels
    /// per mm. `coreRadiance` is what leaves the core below. False once roulette has ended the path.
    bool segment(Vec3f position, const Vec3f& voxelsPerMm, float lengthMm, const Rgb& coreRadiance = Rgb(0.0f));

    enum class Segment {
        Passed, ///< to its end
        Met,    ///< the relief: the rest has another direction
        Ended   ///< by roulette
    };
    /// The same under a refracting relief, for a path that is `inside` the material or not: ends where the path meets
    /// the surface, and what lies outside of it counts nothing. Sub-voxel, the surface of the walks.
    Segment segmentToRelief(Vec3f position, const Vec3f& voxelsPerMm, float lengthMm, bool inside, ReliefMeeting& met,
                            const Rgb& coreRadiance = Rgb(0.0f));
    /// Whether a position lies in the material, as this path sees it; always without a relief.
    bool insideRelief(const Vec3f& position) const;
    /// Index of refraction at a position, as this path sees it.
    float iorAt(const Vec3f& position) const;
    /// That of the first material below a position under a relief.
    float iorBelow(const Vec3f& position) const;
    /// An interface changes what light from behind it counts by `factor`.
    void pass(float factor) { transmittance_ *= factor; }
    /// Goes on with another part of the same path, of which so much is left, in the same tile; what was collected so
    /// far is forgotten (`finish` first).
    void branch(const Rgb& transmittance);

    /// What is left of light that comes the other way through all segments so far; zero after roulette ended the path.
    const Rgb& transmittance() const { return transmittance_; }
    /// All that was collected since `begin`.
    TileRadiance finish();

private:
    // A step that single scattering may be taken from.
    struct Candidate {
        Rgb transmittance;     // in front of the step
        Vec3f position, perMm; // of its start
        float lengthMm;
        float weight, upTo; // of this step; of all until then with it
        Rgb extinction, scattering;
        float g;
        std::uint32_t frame, place; // numbers; place: where there is a blend
    };
    // What holds for the steps of one direction through the tile.
    struct Frame {
        std::vector<MarchLight> lights;
        Vec3f viewer;
    };
    // What one or, in a blend, three places of the table hold.
    struct Items {
        std::array<std::size_t, 3> item{0, 0, 0};
        std::size_t layer = 0;
    };
    // A light of a refracting relief, folded for three axes: its fluence and the three components of its flux.
    using AxisLight = std::array<FoldedLight, 3>;

    bool step(int index, const Vec3f& position, const Vec3f& perMm, float a, float b, const Rgb& coreRadiance);
    Vec3f openSegment(const Vec3f& position, const Rgb& coreRadiance);
    Vec3f shifted(const Vec3f& position) const;
    void foldFrame();
    void foldOne(const FactoredField* field, FoldedLight& light) const;
    void openBacklight();
    std::array<std::size_t, 3> columnsAt(const Vec3f& position, const BlendPlace& place) const;
    FieldValue read(const FactoredField& field, const FactoredField* means, const FoldedLight& light,
                    const Items& items) const;
    FieldValue valueAt(const Items& items, const Rgb& coreRadiance) const;
    FieldValue fieldAt(const Vec3f& position, const TileMedium::Voxel& voxel, std::size_t& item,
                       const Rgb& coreRadiance);
    UncollidedLight uncollided(const Candidate& step, const Vec3f& position, const Vec3f& towards) const;
    Rgb storedSingle(std::size_t item, float g) const;
    void offer(const TileMedium::Voxel& voxel, const Vec3f& position, const Vec3f& perMm, float lengthMm, float weight);
    Rgb singleAt(const Candidate& step, float channel, float flight) const;
    Rgb chosenSingle() const;

    const TileMedium& medium_;
    const StfTable& table_;
    const HistogramBlend* const blend_;
    const FactoredField* multiple_ = nullptr; // null where there is nothing in it
    const FactoredField* single_ = nullptr;
    const FactoredField* emitted_ = nullptr;
    const FactoredField* backlight_ = nullptr;
    bool backlightOpen_ = false; // read only once a core shines
    float voxelHeightMm_;

    // Of the path.
    Vec2f shift_, offset_, pick_;
    float slopePick_ = 0, flightPick_ = 0;
    Rgb transmittance_{1.0f};
    TileRadiance sum_;
    std::vector<Candidate> candidates_;
    std::vector<BlendPlace> places_; // of candidates
    bool ended_ = false;

    // Of the frame; candidates keep that in which they were met.
    BlendPlace place_;
    bool framed_ = false, wantsSingle_ = false;
    std::vector<Frame> frames_{1}; // used again from path to path; there is one before the first is set
    std::size_t frame_ = 0;        // the present one
    bool frameKept_ = false;       // by a candidate
    FoldedLight foldedLights_, foldedCore_, foldedEmission_;
    std::vector<AxisLight> foldedSingle_;
};

} // namespace stf
