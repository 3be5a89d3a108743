// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/core/boundary_samples.h"
#include "stfLib/core/sample_filter.h"
#include "stfLib/core/sample_tree.h"
#include "stfLib/surface/ray_scene.h"

#include <vector>

namespace stf {

/// How the response of a core is had: by dipoles where it is thick and by walks where it is thin, or by one of both.
enum class CoreModel { Auto, Dipole, Walk };

/// The inner boundary of a shell: what the core ends at.
struct CoreBoundary {
    const std::vector<Vec3f>& points; ///< units
    const std::vector<Vec3i>& triangles;
    const std::vector<Vec3f>& normals; ///< of the surface, one per point: outward
    const RayMesh& mesh;               ///< holds the same triangles as its inner boundary
    const BoundarySamples& samples;
    double mmPerUnit = 1;
};

/// K of DESIGN 3.10: what exitance diffuse irradiance causes at samples of the inner boundary. Depends on the core's
/// material and shape, not on light. Rows are
/// - dipoles, scaled so that uniform irradiance E gives exactly R_cd E, summed over a tree within a bound of error, or
/// - where the core is thinner than four diffusion lengths (a smooth change from five to three), walks from all over
///   the sample's part of the boundary. By reciprocity they are light that arrives from where they end.
/// Immutable after construction; `apply` from one thread at a time uses all.
class CoreResponse {
public:
    /// Of the tree's sums, see SampleTree::terms; what they are off by is a fiftieth of it.
    static constexpr float kEpsilon = 0.5f;
    static constexpr std::size_t kWalks = 240'000; ///< what a frame has time for

    /// Dipoles only. `epsilon` 0: direct sums.
    CoreResponse(const CoreMaterial& material, const SurfacePoints& samples, float epsilon = kEpsilon);
    /// `epsilon` as above. `walks`: together, of all samples; 24 to 512 each. Throws Cancelled.
    CoreResponse(const CoreMaterial& material, const CoreBoundary& boundary, CoreModel model, std::uint64_t seed,
                 Progress& progress, std::size_t walks = kWalks, float epsilon = kEpsilon);

    CoreResponse(CoreResponse&&) = default;
    CoreResponse(const CoreResponse&) = delete;
    CoreResponse& operator=(const CoreResponse&) = delete;

    const SurfacePoints& samples() const { return samples_; }
    /// exitance = K irradiance, at the samples.
    std::vector<Rgb> apply(const std::vector<Rgb>& irradiance) const;
    /// Exitance by dipoles at any place (mm), from the irradiance of all samples, given as sums over the tree's items.
    Rgb dipoleExitance(const Vec3f& place, const std::vector<Rgb>& itemSums, float epsilon) const;
    std::vector<Rgb> itemSums(const std::vector<Rgb>& irradiance) const { return tree_.itemSums(irradiance); }
    /// The most that any row returns of uniform irradiance.
    float largestAlbedo() const { return largestAlbedo_; }
    /// Which part of a sample's exitance is walked, per channel.
    Rgb walkShare(std::size_t sample) const { return walkShare_.empty() ? Rgb(0.0f) : walkShare_[sample]; }

    std::size_t walkedSamples() const;
    std::size_t walksPerSample() const { return walksPerSample_; }
    std::size_t meanTerms() const { return terms_.empty() ? 0 : terms_.size() / samples_.positions.size(); }
    std::size_t bytes() const;

    /// Length over which light of a channel spreads, mm: the diffusion length, and at least a mean free path.
    static double spreadLength(double sigmaA, double sigmaSPrime);

private:
    struct WalkTerm {
        std::uint32_t sample;
        Rgb weight;
    };
    void prepare(const CoreMaterial& material);
    void listTerms(Progress& progress);
    void chooseWalks(const CoreMaterial& material, const CoreBoundary& boundary, CoreModel model);
    void walk(const CoreMaterial& material, const CoreBoundary& boundary, std::uint64_t seed, Progress& progress);
    void shareFarWalks();
    void scaleWalks(const std::vector<Rgb>& ownTotals);
    Rgb walkedExitance(std::size_t walked, const std::vector<Rgb>& irradiance, const std::vector<Rgb>& far) const;
    std::vector<Rgb> farExitance(const std::vector<Rgb>& irradiance) const;
    SampleTree::Kernels kernelsOf(std::size_t sample) const; ///< of the channels that are not walked alone
    bool needsDipole(std::size_t sample) const;
    Rgb gather(const Vec3f& place, const SampleTree::Kernels& kernels, const std::vector<Rgb>& itemSums,
               float epsilon) const;
    bool isWalked(std::size_t sample) const { return !walkShare_.empty() && maxComponent(walkShare_[sample]) > 0; }

    std::vector<Dipole> dipoles_;
    SurfacePoints samples_;
    SampleTree tree_;
    SampleTree::Kernels kernels_;
    float epsilon_ = kEpsilon;
    // Dipole rows: weights of sums over items of the tree, or nothing where they would take too much memory.
    std::vector<SampleTree::Term> terms_;
    std::vector<std::size_t> firstTerm_;
    // Walks that end near their beginning, and those that come from far and are averaged among neighbours.
    std::vector<Rgb> walkShare_;
    std::vector<float> thickness_; ///< mm
    std::vector<WalkTerm> near_, far_;
    std::vector<std::size_t> firstNear_, firstFar_;
    std::vector<Rgb> walkScale_;        ///< of each of them: so that uniform light returns what its own walks say
    std::vector<std::uint32_t> walked_; ///< samples with walks; the filter's places
    SampleFilter smooth_;
    std::size_t walkBudget_ = kWalks, walksPerSample_ = 0;
    float largestAlbedo_ = 0;
};

} // namespace stf
