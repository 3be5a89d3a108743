// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/walk_groups.h"

#include "stfLib/base/parallel.h"

#include <algorithm>
#include <mutex>

namespace stf {

namespace {

// Sums over tracks to densities, in the order of FactoredField.
std::vector<float> densities(const TileMedium& medium, const std::vector<double>& tracks, int components,
                             std::uint64_t photons) {
    const std::size_t voxels = medium.voxelCount(), n = std::size_t(components);
    const Vec3d& h = medium.voxelMm();
    std::vector<float> field(voxels * 3 * n);
    for (std::size_t i = 0; i < voxels; ++i) {
        const double fill = double(medium.fill(i));
        // Slivers would only hold noise: they take the mean of their neighbours (TileWalks::finish).
        const double scale = fill > double(kLeastFill) ? 1 / (double(photons) * h.x * h.y * h.z * fill) : 0;
        for (std::size_t c = 0; c < 3; ++c) {
            for (std::size_t k = 0; k < n; ++k) {
                field[i * 3 * n + k * 3 + c] = float(tracks[(i * 3 + c) * n + k] * scale);
            }
        }
    }
    return field;
}

} // namespace

WalkGroups::WalkGroups(const TileMedium& medium, std::uint64_t seed, bool flux, int groups, Progress& progress)
    : medium_(medium), seed_(seed), flux_(flux), groups_(groups), progress_(progress) {}

void WalkGroups::run(const std::vector<WalkJob>& jobs, bool uncollided,
                     const std::function<void(std::size_t, const std::vector<GroupResult>&)>& done) {
    // As many jobs at a time as keep all threads busy; more would only take memory.
    const std::size_t groups = std::size_t(groups_);
    const std::size_t wave = std::max<std::size_t>(1, std::size_t(4 * threadCount()) / groups);
    std::mutex mutex;
    for (std::size_t begin = 0; begin < jobs.size(); begin += wave) {
        const std::size_t end = std::min(jobs.size(), begin + wave);
        std::vector<std::vector<GroupResult>> results(end - begin, std::vector<GroupResult>(groups));
        parallelFor((end - begin) * groups, 1, [&](std::size_t from, std::size_t to) {
            for (std::size_t task = from; task < to; ++task) {
                const WalkJob& job = jobs[begin + task / groups];
                WalkRequest request;
                request.seed = seed_;
                request.source = job.number;
                request.count = (job.photons + groups - 1) / groups;
                request.first = job.first + request.count * (task % groups);
                request.flux = flux_;
                request.uncollided = uncollided;
                WalkTally t = walk(medium_, job.source, request, progress_);
                GroupResult& r = results[task / groups][task % groups];
                r.field = densities(medium_, t.collided, t.components, t.photons);
                if (uncollided) {
                    r.uncollided = densities(medium_, t.uncollided, t.components, t.photons);
                }
                t.collided = {};
                t.uncollided = {};
                r.totals = std::move(t);
                const std::lock_guard<std::mutex> lock(mutex);
                walked_ += double(request.count);
                collisions_ += r.totals.collisions;
                lost_ += r.totals.lost;
                progress_.update("transport", expected_ > 0 ? std::min(1.0, walked_ / expected_) : 0.0);
            }
        });
        for (std::size_t job = begin; job < end; ++job) {
            done(job, results[job - begin]);
        }
    }
}

} // namespace stf
