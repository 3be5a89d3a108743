// SPDX-License-Identifier: Apache-2.0
// How fast a shell grid is read: lookups a second along rays and at random, beside a loop that reads the same memory
// and computes nothing, and beside the index of OpenVDB and NanoVDB. Prints a line of JSON.

#include "stfLib/base/openvdb_headers.h"

#include "bench/bench_parts.h"
#include "stfLib/base/random.h"
#include "stfLib/shell/shell_grid_impl.h"
#include "stfLib/synthesis/choose_mapping.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#if STF_BENCH_NANOVDB
#include <nanovdb/util/OpenToNanoVDB.h>
#endif

using namespace stf;

namespace {

constexpr int kEntry = 16; ///< floats of a table's entry: a cache line

struct Arguments {
    std::string mesh;
    double samples = 5e6, thickness = 0.02;
    int lookups = 2'000'000, rounds = 3;
};

/// Stands for the table of transport: a line of memory for every voxel of a tile.
struct Table {
    int size = 128, layers = 16;
    double tileMm = 64, depthMm = 8;
    std::vector<float> entries =
        std::vector<float>(std::size_t(size) * std::size_t(size) * std::size_t(layers) * kEntry, 0.5f);

    float fetch(float x, float y, float depth) const {
        const auto index = [](float v, int n) { return int(v) & (n - 1); };
        const float* e =
            entries.data() +
            kEntry * ((std::size_t(index(depth, layers)) * std::size_t(size) + std::size_t(index(y, size))) *
                          std::size_t(size) +
                      std::size_t(index(x, size)));
        float sum = 0;
        for (int k = 0; k < kEntry; ++k) {
            sum += e[k];
        }
        return sum;
    }
};

/// Points on rays that enter the shell at random places, a voxel apart; each ray ends where it may have left.
std::vector<Vec3f> rayPoints(const RefinedSurface& s, const ShellBoundary& b, double voxel, int count, bool scattered) {
    std::vector<Vec3f> points;
    for (std::uint64_t i = 0; int(points.size()) < count; ++i) {
        CounterRng random(7, i);
        const std::size_t t =
            std::min(s.triangles.size() - 1, std::size_t(double(random.uniform()) * double(s.triangles.size())));
        const Vec3i& tri = s.triangles[t];
        float u = random.uniform(), v = random.uniform();
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        const auto blend = [&](const std::vector<Vec3f>& p) {
            return p[std::size_t(tri.x)] * (1 - u - v) + p[std::size_t(tri.y)] * u + p[std::size_t(tri.z)] * v;
        };
        const Vec3f from = blend(s.points), in = blend(b.inner) - from;
        const float thickness = length(in);
        Vec3f side{random.uniform() - 0.5f, random.uniform() - 0.5f, random.uniform() - 0.5f};
        const Vec3f direction = normalize(in / thickness + side);
        if (scattered) {
            points.push_back(from + in * random.uniform());
            continue;
        }
        const float reach = thickness / std::max(0.3f, dot(direction, in / thickness));
        for (float d = 0.5f * float(voxel); d < reach; d += float(voxel)) {
            points.push_back(from + direction * d);
        }
    }
    points.resize(std::size_t(count));
    return points;
}

nlohmann::ordered_json measure(const ShellGrid& grid, const ShellGridData& data, const Table& table,
                               const std::vector<Vec3f>& points, int rounds, const openvdb::Int32Tree& tree) {
    const ShellLevel& level = data.levels.front();
    const double perVoxel = 1 / level.voxel;
    const float toTable = float(table.size / table.tileMm), toLayer = float(table.layers / table.depthMm);
    const auto floorOf = [&](const Vec3f& p) {
        const Vec3d at = (Vec3d(p) - level.origin) * perVoxel;
        return Vec3i(int(quickFloor(at.x)), int(quickFloor(at.y)), int(quickFloor(at.z)));
    };
    nlohmann::ordered_json j;
    std::size_t found = 0;
    ShellGrid::Accessor accessor(grid);
    j["lookup"] = perSecond(points.size(), rounds, [&] {
        float sum = 0;
        ShellLookup l;
        found = 0;
        for (const Vec3f& p : points) {
            if (accessor.lookup(p, l)) {
                ++found;
                sum +=
                    table.fetch(l.exemplar.x * toTable + 1024, l.exemplar.y * toTable + 1024, l.depth * toLayer + 1024);
            }
        }
        return sum;
    });
    j["lookupPrefetched"] = perSecond(points.size(), rounds, [&] {
        float sum = 0;
        ShellLookup l;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const bool there = accessor.lookup(points[i], l);
            accessor.prefetch(points[std::min(i + 2, points.size() - 1)]);
            if (there) {
                sum +=
                    table.fetch(l.exemplar.x * toTable + 1024, l.exemplar.y * toTable + 1024, l.depth * toLayer + 1024);
            }
        }
        return sum;
    });
    ShellReader reader(data);
    j["bare"] = perSecond(points.size(), rounds, [&] {
        float sum = 0;
        std::uint32_t bits = 0;
        for (const Vec3f& p : points) {
            ShellReader::Corners c;
            if (reader.corners(floorOf(p), 0, c)) {
                const ShellSample* any = nullptr;
                for (int i = 0; i < 8; ++i) {
                    if (c.present >> i & 1) {
                        any = c.sample[i];
                        std::uint32_t words[8];
                        std::memcpy(words, any, sizeof words);
                        for (std::uint32_t w : words) {
                            bits += w;
                        }
                    }
                }
                sum += table.fetch(float(any->x >> 8) * (128.0f / 16777216), float(any->y >> 8) * (128.0f / 16777216),
                                   float(any->x & 15));
            }
        }
        return sum + float(bits & 1);
    });
    j["index"] = perSecond(points.size(), rounds, [&] {
        std::uint32_t sum = 0;
        for (const Vec3f& p : points) {
            ShellReader::Corners c;
            if (reader.corners(floorOf(p), 0, c)) {
                sum += c.number[0] + c.number[7] + c.present;
            }
        }
        return float(sum);
    });
    const auto eight = [&](auto& index) {
        return perSecond(points.size(), rounds, [&] {
            std::uint32_t sum = 0;
            for (const Vec3f& p : points) {
                const Vec3i f = floorOf(p);
                for (int i = 0; i < 8; ++i) {
                    sum += std::uint32_t(index(f.x + (i >> 2), f.y + (i >> 1 & 1), f.z + (i & 1)));
                }
            }
            return float(sum);
        });
    };
    openvdb::tree::ValueAccessor<const openvdb::Int32Tree, false> open(tree);
    const auto openIndex = [&](int x, int y, int z) { return open.getValue({x, y, z}); };
    j["indexOpenVDB"] = eight(openIndex);
#if STF_BENCH_NANOVDB
    const openvdb::Int32Grid::Ptr openGrid = openvdb::Int32Grid::create(std::make_shared<openvdb::Int32Tree>(tree));
    auto handle = nanovdb::openToNanoVDB(*openGrid);
    const auto nano = handle.grid<std::int32_t>()->getAccessor();
    const auto nanoIndex = [&](int x, int y, int z) { return nano.getValue({x, y, z}); };
    j["indexNanoVDB"] = eight(nanoIndex);
    j["bytesNanoVDB"] = handle.size();
#endif
    j["found"] = double(found) / double(points.size());
    j["ofBare"] = std::max(double(j["lookup"]), double(j["lookupPrefetched"])) / double(j["bare"]);
    return j;
}

openvdb::Int32Tree treeOf(const ShellLevel& level) {
    openvdb::Int32Tree tree(-1);
    for (const ShellLeaf& from : level.leaves()) {
        auto leaf = std::make_unique<openvdb::Int32Tree::LeafNodeType>(
            openvdb::Coord(from.origin.x, from.origin.y, from.origin.z), -1, false);
        std::uint32_t number = from.number;
        for (int v = 0; v < kLeafRows * kLeafSize; ++v) {
            if (from.row[v / kLeafSize] >> v % kLeafSize & 1) {
                leaf->setValueOn(openvdb::Index(v), std::int32_t(number++));
            }
        }
        tree.addLeaf(leaf.release());
    }
    return tree;
}

int run(const Arguments& a) {
    openvdb::initialize();
    const RefinedSurface surface = refine(meshOf(a.mesh), {}, {});
    const float thickness = float(a.thickness) * surface.bounds.diagonal();
    const ShellBoundary boundary = offsetInward(surface, thickness, {});
    const Table table;
    ShellGridOptions options;
    options.levels = 1;
    options.mmPerUnit = table.depthMm / double(thickness);
    const ExemplarMap map = mapAnywhere(surface, {table.tileMm, table.tileMm}, 1 / options.mmPerUnit);
    // The voxel size that gives the samples asked for: found by a coarse grid.
    options.voxelSize = thickness / 4;
    Progress progress;
    const double coarse = double(ShellGrid::build(surface, boundary, map, options, progress, {}).sampleCount());
    options.voxelSize *= float(std::cbrt(coarse / a.samples * (1 / 1.9)));
    options.maxBytes = std::size_t(1) << 40;
    const ShellGrid grid = ShellGrid::build(surface, boundary, map, options, progress, {});
    const ShellGridData& data = grid.data();
    const openvdb::Int32Tree tree = treeOf(data.levels.front());

    nlohmann::ordered_json j;
    j["samples"] = grid.sampleCount();
    j["bytes"] = grid.memoryBytes();
    j["bytesIndex"] = data.levels.front().leaves().size() * sizeof(ShellLeaf);
    j["bytesOpenVDB"] = tree.memUsage();
    j["scanSeconds"] = grid.levels().front().seconds;
    for (const bool scattered : {false, true}) {
        const std::vector<Vec3f> points = rayPoints(surface, boundary, double(grid.voxelSize()), a.lookups, scattered);
        j[scattered ? "random" : "rays"] = measure(grid, data, table, points, a.rounds, tree);
    }
    std::puts(j.dump().c_str());
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    Arguments a;
    CLI::App app("Lookups a second in a shell grid", "stf_bench_shell");
    app.add_option("mesh", a.mesh, "OBJ, PLY, STL or OFF")->required();
    app.add_option("--samples", a.samples, "Of the grid, about")->check(CLI::Range(1e3, 2e9));
    app.add_option("--thickness", a.thickness, "Of the mesh's diagonal")->check(CLI::Range(1e-4, 0.5));
    app.add_option("--lookups", a.lookups, "In each measurement")->check(CLI::Range(1000, 1000000000));
    app.add_option("--rounds", a.rounds, "The quickest counts")->check(CLI::Range(1, 100));
    CLI11_PARSE(app, argc, argv);
    try {
        return run(a);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stf_bench_shell: %s\n", e.what());
        return 2;
    }
}
