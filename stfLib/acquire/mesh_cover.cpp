// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_cover.h"

#include "stfLib/base/parallel.h"

#include <atomic>
#include <tuple>

namespace stf {

namespace {

constexpr int kLines = 64;

/// Hammersley's points: midpoints of 64 strips along either side, one in each.
std::vector<Vec2d> coverLines() {
    std::vector<Vec2d> lines;
    for (int i = 0; i < kLines; ++i) {
        int reversed = 0;
        for (int bit = 1; bit < kLines; bit <<= 1) {
            reversed = reversed << 1 | ((i & bit) != 0);
        }
        lines.push_back({(i + 0.5) / kLines, (reversed + 0.5) / kLines});
    }
    return lines;
}

/// Where a line enters or leaves an object; -1 is the body.
struct Event {
    int line;
    double depth;
    int object, step;
};

struct Shared {
    std::vector<std::atomic<bool>> protrudes;
    std::atomic<std::size_t> missing{0};
};

/// Adds the fractions of one column.
class ColumnCover {
public:
    ColumnCover(const CoverBody& body, const std::vector<CoverObject>& objects, const TileGrid& grid, int slots,
                Shared& shared)
        : body_(body), objects_(objects), grid_(grid), slots_(slots), shared_(shared), depths_(objects.size() + 1) {}

    void fill(int x, int y, const std::vector<Vec2d>& lines, float* fractions) {
        events_.clear();
        std::size_t missing = 0;
        collect(-1, [&] { bodyStretches(body_, grid_, x, y, lines, stretches_, &missing); });
        shared_.missing += missing;
        for (std::size_t o = 0; o < objects_.size(); ++o) {
            collect(int(o), [&] { objects_[o].columns->inside(x, y, lines, stretches_); });
        }
        std::sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
            return std::tie(a.line, a.depth, a.object, a.step) < std::tie(b.line, b.depth, b.object, b.step);
        });
        std::fill(depths_.begin(), depths_.end(), 0);
        sums_.assign(std::size_t(grid_.size.z) * std::size_t(slots_), 0.0);
        for (std::size_t i = 0; i < events_.size(); ++i) {
            depths_[std::size_t(events_[i].object + 1)] += events_[i].step;
            if (i + 1 < events_.size() && events_[i + 1].line == events_[i].line) {
                addStretch(events_[i].depth, events_[i + 1].depth);
            }
        }
        const std::size_t layer = std::size_t(grid_.size.x) * std::size_t(grid_.size.y);
        const std::size_t column = std::size_t(x) + std::size_t(grid_.size.x) * std::size_t(y);
        const double share = 1 / (double(lines.size()) * grid_.voxelMm.z);
        for (std::size_t z = 0; z < std::size_t(grid_.size.z); ++z) {
            for (std::size_t s = 0; s < std::size_t(slots_); ++s) {
                fractions[(column + layer * z) * std::size_t(slots_) + s] =
                    float(std::min(1.0, sums_[z * std::size_t(slots_) + s] * share));
            }
        }
    }

private:
    template<class F>
    void collect(int object, F stretches) {
        stretches_.clear();
        stretches();
        for (const Stretch& s : stretches_) {
            events_.push_back({s.line, s.from, object, 1});
            events_.push_back({s.line, s.to, object, -1});
        }
    }
    void addStretch(double from, double to) {
        if (!(from < to)) {
            return;
        }
        int winner = int(objects_.size()) - 1;
        while (winner >= 0 && depths_[std::size_t(winner + 1)] <= 0) {
            --winner;
        }
        if (winner < 0 && depths_[0] <= 0) {
            return;
        }
        const int slot = winner < 0 ? body_.material : objects_[std::size_t(winner)].material;
        if (slot < 0) {
            return;
        }
        if (winner >= 0) {
            // Is there something below it that is solid already?
            int below = winner - 1;
            while (below >= 0 && depths_[std::size_t(below + 1)] <= 0) {
                --below;
            }
            if (below < 0 ? depths_[0] <= 0 : objects_[std::size_t(below)].material < 0) {
                shared_.protrudes[std::size_t(winner)].store(true, std::memory_order_relaxed);
            }
        }
        const double h = grid_.voxelMm.z;
        for (int z = std::clamp(int(from / h), 0, grid_.size.z - 1); z < grid_.size.z && z * h < to; ++z) {
            const double part = std::min(to, (z + 1) * h) - std::max(from, z * h);
            if (part > 0) {
                sums_[std::size_t(z) * std::size_t(slots_) + std::size_t(slot)] += part;
            }
        }
    }

    const CoverBody& body_;
    const std::vector<CoverObject>& objects_;
    const TileGrid& grid_;
    const int slots_;
    Shared& shared_;
    std::vector<Stretch> stretches_;
    std::vector<Event> events_;
    std::vector<int> depths_; ///< how often the line is in the body and in each object
    std::vector<double> sums_;
};

} // namespace

void bodyStretches(const CoverBody& body, const TileGrid& grid, int x, int y, const std::vector<Vec2d>& lines,
                   std::vector<Stretch>& out, std::size_t* missing) {
    const double bottom = grid.extentMm().z;
    if (body.material < 0) {
        return;
    }
    if (body.kind == CoverBody::Kind::Meshes) {
        for (const MeshColumns* mesh : body.meshes) {
            mesh->inside(x, y, lines, out);
        }
        return;
    }
    std::vector<double> top(lines.size(), 0.0);
    if (body.kind == CoverBody::Kind::Relief) {
        top = body.meshes.front()->first(x, y, lines);
    }
    for (std::size_t l = 0; l < lines.size(); ++l) {
        if (std::isinf(top[l])) {
            top[l] = body.reliefFloor;
            if (missing) {
                ++*missing;
            }
        }
        if (top[l] < bottom) {
            out.push_back({int(l), std::max(0.0, top[l]), bottom});
        }
    }
}

TileCover coverTile(const CoverBody& body, const std::vector<CoverObject>& objects, const TileGrid& grid, int slots,
                    Progress& progress) {
    const std::size_t columns = std::size_t(grid.size.x) * std::size_t(grid.size.y);
    TileCover cover;
    cover.fractions.assign(columns * std::size_t(grid.size.z) * std::size_t(slots), 0.0f);
    Shared shared;
    shared.protrudes = std::vector<std::atomic<bool>>(objects.size());
    const std::vector<Vec2d> lines = coverLines();
    std::atomic<std::size_t> done{0};
    parallelFor(columns, 64, [&](std::size_t begin, std::size_t end) {
        ColumnCover column(body, objects, grid, slots, shared);
        for (std::size_t i = begin; i < end; ++i) {
            column.fill(int(i % std::size_t(grid.size.x)), int(i / std::size_t(grid.size.x)), lines,
                        cover.fractions.data());
        }
        progress.update("cover", double(done += end - begin) / double(columns));
    });
    for (const std::atomic<bool>& p : shared.protrudes) {
        cover.protrudes.push_back(p);
    }
    cover.reliefMissing = double(shared.missing) / double(columns * lines.size());
    cover.meanShare.assign(std::size_t(slots), 0.0);
    for (std::size_t i = 0; i < cover.fractions.size(); ++i) {
        cover.meanShare[i % std::size_t(slots)] += double(cover.fractions[i]);
    }
    for (double& share : cover.meanShare) {
        share /= double(columns) * grid.size.z;
    }
    return cover;
}

} // namespace stf
