// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/split_parts.h"

#include <map>

namespace stf {

namespace {

/// Gives what is used numbers of its own, from 0. The table is of the whole and goes from part to part.
class Renumbering {
public:
    explicit Renumbering(std::size_t count) : number_(count, -1) {}

    Vec3i operator()(const Vec3i& corners) {
        Vec3i result;
        for (int k = 0; k < 3; ++k) {
            int& n = number_[std::size_t(corners[k])];
            if (n < 0) {
                n = int(used_.size());
                used_.push_back(corners[k]);
            }
            result[k] = n;
        }
        return result;
    }
    /// The values of what was used, in the order of their numbers; none of none.
    template<class T>
    std::vector<T> pick(const std::vector<T>& values) const {
        std::vector<T> picked;
        picked.reserve(values.empty() ? 0 : used_.size());
        for (std::size_t i = 0; !values.empty() && i < used_.size(); ++i) {
            picked.push_back(values[std::size_t(used_[i])]);
        }
        return picked;
    }
    void startOver() {
        for (const int i : used_) {
            number_[std::size_t(i)] = -1;
        }
        used_.clear();
    }

private:
    std::vector<int> number_, used_;
};

} // namespace

std::vector<SurfacePart> splitByPart(RefinedSurface whole, const std::vector<int>& faceParts) {
    std::vector<SurfacePart> parts;
    if (faceParts.empty()) {
        parts.push_back({std::move(whole), 0});
        return parts;
    }
    std::map<int, std::vector<std::size_t>> triangles;
    for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
        const std::size_t face = std::size_t(whole.triangleFace[t]);
        triangles[face < faceParts.size() ? faceParts[face] : 0].push_back(t);
    }
    if (triangles.size() == 1) {
        parts.push_back({std::move(whole), triangles.begin()->first});
        return parts;
    }
    Renumbering points(whole.points.size()), uvs(whole.uvs.size());
    for (const auto& [number, chosen] : triangles) {
        SurfacePart part;
        part.number = number;
        RefinedSurface& s = part.surface;
        for (const std::size_t t : chosen) {
            s.triangles.push_back(points(whole.triangles[t]));
            s.triangleFace.push_back(whole.triangleFace[t]);
            if (!whole.uvTriangles.empty()) {
                s.uvTriangles.push_back(uvs(whole.uvTriangles[t]));
            }
            for (std::size_t k = 0; !whole.cornerNormals.empty() && k < 3; ++k) {
                s.cornerNormals.push_back(whole.cornerNormals[3 * t + k]);
            }
        }
        s.points = points.pick(whole.points);
        s.normals = points.pick(whole.normals);
        s.colors = points.pick(whole.colors);
        s.orientation = points.pick(whole.orientation);
        s.uvs = uvs.pick(whole.uvs);
        for (const Vec3f& p : s.points) {
            s.bounds.add(p);
        }
        points.startOver();
        uvs.startOver();
        parts.push_back(std::move(part));
    }
    return parts;
}

} // namespace stf
