// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/instance_bounds.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace stf {

namespace {

/// The shell of an open surface lies outside of the surface's bounds.
Box3f boundsOf(const PreparedMesh& mesh) {
    Box3f box = mesh.surface->bounds;
    if (mesh.shell) {
        for (const Vec3f& p : mesh.shell->boundary->inner) {
            box.add(p);
        }
    }
    return box;
}

} // namespace

void findOverlaps(std::vector<PreparedInstance>& instances) {
    std::map<const PreparedMesh*, Box3f> known;
    for (PreparedInstance& i : instances) {
        i.bounds = Box3f();
        i.overlapped = false;
        const auto [found, isNew] = known.try_emplace(i.mesh.get());
        if (isNew) {
            found->second = boundsOf(*i.mesh);
        }
        const Box3f& box = found->second;
        for (int c = 0; c < 8 && !box.empty(); ++c) {
            const Vec3f corner{c & 1 ? box.hi.x : box.lo.x, c & 2 ? box.hi.y : box.lo.y, c & 4 ? box.hi.z : box.lo.z};
            i.bounds.add(i.worldPoint(corner));
            for (const Transform& step : i.motion) { // points go straight from one to the next
                i.bounds.add(Vec3f(step.point(Vec3d(corner))));
            }
        }
    }
    // In the order of their lower ends along x only those that begin before another ends can overlap it.
    std::vector<std::size_t> order(instances.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return instances[a].bounds.lo.x < instances[b].bounds.lo.x; });
    for (std::size_t a = 0; a < order.size(); ++a) {
        PreparedInstance& first = instances[order[a]];
        for (std::size_t b = a + 1; b < order.size(); ++b) {
            PreparedInstance& second = instances[order[b]];
            if (second.bounds.lo.x > first.bounds.hi.x) {
                break;
            }
            if ((!first.overlapped || !second.overlapped) && first.bounds.overlaps(second.bounds)) {
                first.overlapped = second.overlapped = true;
            }
        }
    }
}

std::vector<std::uint32_t> shellsAround(const std::vector<PreparedInstance>& instances, const Box3f& box) {
    std::vector<std::uint32_t> around;
    for (std::size_t i = 0; i < instances.size(); ++i) {
        if (instances[i].mesh->shell && instances[i].bounds.overlaps(box)) {
            around.push_back(std::uint32_t(i));
        }
    }
    return around;
}

} // namespace stf
