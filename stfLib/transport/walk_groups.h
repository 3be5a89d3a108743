// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/transport/walk.h"

#include <functional>
#include <vector>

namespace stf {

/// Voxels with less material than this have no value of their own.
constexpr float kLeastFill = 0.05f;

/// Walks of one source, in independent groups: their scatter tells the noise.
struct WalkJob {
    WalkSource source;
    std::uint64_t number = 0;  ///< of the source, for random numbers
    std::uint64_t first = 0;   ///< photons done before
    std::uint64_t photons = 0; ///< of all groups; rounded up to a multiple of them
};

/// What one group found: density fields per photon and the rest of the tally.
struct GroupResult {
    /// Track length per photon and voxel volume that holds material (1/mm^2) times (1, direction), [voxel][component]
    /// in the order of FactoredField; collided, or all where the request asked for uncollided too and they are added.
    std::vector<float> field;
    std::vector<float> uncollided; ///< the same before the first collision, where it was asked for
    WalkTally totals;              ///< without its voxel arrays
};

/// Runs walks for tables.
class WalkGroups {
public:
    WalkGroups(const TileMedium& medium, std::uint64_t seed, bool flux, int groups, Progress& progress);

    int groups() const { return groups_; }
    int components() const { return flux_ ? 12 : 3; }
    /// Runs all jobs on all threads; calls done(job number, groups) in order of the jobs, from one thread.
    void run(const std::vector<WalkJob>& jobs, bool uncollided,
             const std::function<void(std::size_t, const std::vector<GroupResult>&)>& done);

    /// Photons walked so far, and how many are expected: the progress that is reported.
    void expect(double photons) { expected_ = photons; }
    double photons() const { return walked_; }
    std::uint64_t collisions() const { return collisions_; }
    std::uint64_t lost() const { return lost_; }

private:
    const TileMedium& medium_;
    std::uint64_t seed_;
    bool flux_;
    int groups_;
    Progress& progress_;
    double expected_ = 0, walked_ = 0;
    std::uint64_t collisions_ = 0, lost_ = 0;
};

} // namespace stf
