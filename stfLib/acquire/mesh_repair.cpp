// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_repair.h"

#include "stfLib/acquire/mesh_tree.h"
#include "stfLib/base/error.h"

#include <array>
#include <cstdint>
#include <numeric>
#include <sstream>
#include <tuple>
#include <unordered_map>
#include <unordered_set>

namespace stf {

namespace {

constexpr double kMaxCoordinate = 1e9;
// More pieces than this are debris or a soup: cavities are not looked for.
constexpr std::size_t kMaxNestedPieces = 256;

struct PointHash {
    std::size_t operator()(const std::array<double, 3>& p) const {
        std::size_t h = 0;
        for (const double v : p) {
            h = (h ^ std::hash<double>()(v)) * 0x9E3779B97F4A7C15ull;
            h ^= h >> 29;
        }
        return h;
    }
};

struct FaceHash {
    std::size_t operator()(const std::array<int, 3>& f) const {
        return PointHash()({double(f[0]), double(f[1]), double(f[2])});
    }
};

void check(const TriangleMesh& mesh, const std::string& name) {
    if (mesh.triangles.empty()) {
        throw Error(name + ": holds no triangle");
    }
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        const Vec3d& p = mesh.points[i];
        if (!isFinite(p) || std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > kMaxCoordinate) {
            std::ostringstream s;
            s << name << ": vertex " << i << " is at (" << p.x << ", " << p.y << ", " << p.z
              << "), which is not finite or beyond 1e9";
            throw Error(s.str());
        }
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
            const int v = mesh.triangles[i][k];
            if (v < 0 || std::size_t(v) >= mesh.points.size()) {
                throw Error(name + ": triangle " + std::to_string(i) + " names vertex " + std::to_string(v) + " of " +
                            std::to_string(mesh.points.size()));
            }
        }
    }
}

TriangleMesh mergePoints(const TriangleMesh& mesh) {
    TriangleMesh result;
    std::unordered_map<std::array<double, 3>, int, PointHash> numbers;
    numbers.reserve(mesh.points.size());
    std::vector<int> merged(mesh.points.size());
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        // Adding 0 makes -0 a 0.
        const Vec3d p = mesh.points[i] + Vec3d(0.0);
        const auto [at, added] = numbers.emplace(std::array<double, 3>{p.x, p.y, p.z}, int(result.points.size()));
        if (added) {
            result.points.push_back(p);
        }
        merged[i] = at->second;
    }
    result.triangles.reserve(mesh.triangles.size());
    for (const Vec3i& t : mesh.triangles) {
        result.triangles.push_back({merged[std::size_t(t.x)], merged[std::size_t(t.y)], merged[std::size_t(t.z)]});
    }
    return result;
}

void dropFaces(TriangleMesh& mesh, MeshRepair& found) {
    std::unordered_set<std::array<int, 3>, FaceHash> seen;
    seen.reserve(mesh.triangles.size());
    std::vector<Vec3i> kept;
    kept.reserve(mesh.triangles.size());
    for (const Vec3i& t : mesh.triangles) {
        if (t.x == t.y || t.y == t.z || t.z == t.x) {
            ++found.degenerate;
            continue;
        }
        std::array<int, 3> key{t.x, t.y, t.z};
        std::sort(key.begin(), key.end());
        if (seen.insert(key).second) {
            kept.push_back(t);
        } else {
            ++found.duplicates;
        }
    }
    mesh.triangles = std::move(kept);
}

/// One side of an edge: sorted, sides of the same edge are neighbours.
struct Side {
    int lo, hi;
    bool forward; ///< from lo to hi
    std::size_t triangle;
    bool sameEdge(const Side& s) const { return lo == s.lo && hi == s.hi; }
};

std::vector<Side> sidesOf(const TriangleMesh& mesh) {
    std::vector<Side> sides;
    sides.reserve(3 * mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
            const int a = mesh.triangles[i][k], b = mesh.triangles[i][(k + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), a < b, i});
        }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) {
        return std::tie(s.lo, s.hi, s.triangle) < std::tie(t.lo, t.hi, t.triangle);
    });
    return sides;
}

/// Calls visit(begin, end) for the sides of each edge.
template<class Visit>
void forEachEdge(const std::vector<Side>& sides, Visit visit) {
    for (std::size_t begin = 0; begin < sides.size();) {
        std::size_t end = begin + 1;
        while (end < sides.size() && sides[end].sameEdge(sides[begin])) {
            ++end;
        }
        visit(begin, end);
        begin = end;
    }
}

/// Number of the piece of each triangle; pieces hang together by edges of two triangles, `turn` says which triangles
/// must be turned to agree with the first one of their piece.
std::vector<std::size_t> findPieces(const TriangleMesh& mesh, const std::vector<Side>& sides, std::vector<bool>& turn,
                                    std::size_t& count) {
    const std::size_t none = ~std::size_t(0);
    struct Neighbour {
        std::size_t triangle = ~std::size_t(0);
        bool against = false;
    };
    std::vector<std::array<Neighbour, 3>> neighbours(mesh.triangles.size());
    std::vector<int> used(mesh.triangles.size(), 0);
    forEachEdge(sides, [&](std::size_t begin, std::size_t end) {
        const std::size_t s = sides[begin].triangle, t = sides[end - 1].triangle;
        if (end - begin == 2 && s != t) {
            const bool against = sides[begin].forward == sides[begin + 1].forward;
            neighbours[s][std::size_t(used[s]++)] = {t, against};
            neighbours[t][std::size_t(used[t]++)] = {s, against};
        }
    });
    std::vector<std::size_t> piece(mesh.triangles.size(), none), stack;
    turn.assign(mesh.triangles.size(), false);
    count = 0;
    for (std::size_t start = 0; start < piece.size(); ++start) {
        if (piece[start] != none) {
            continue;
        }
        piece[start] = count;
        stack = {start};
        while (!stack.empty()) {
            const std::size_t t = stack.back();
            stack.pop_back();
            for (const Neighbour& n : neighbours[t]) {
                if (n.triangle != none && piece[n.triangle] == none) {
                    piece[n.triangle] = count;
                    turn[n.triangle] = turn[t] != n.against;
                    stack.push_back(n.triangle);
                }
            }
        }
        ++count;
    }
    return piece;
}

void applyTurns(TriangleMesh& mesh, const std::vector<bool>& turn) {
    for (std::size_t i = 0; i < turn.size(); ++i) {
        if (turn[i]) {
            std::swap(mesh.triangles[i].y, mesh.triangles[i].z);
        }
    }
}

/// Fans that close the mesh, one about the middle of each loop of open edges.
TriangleMesh capsOf(const TriangleMesh& mesh, std::size_t& loops, double& boundary) {
    std::vector<std::pair<int, int>> open; // as the mesh runs along them
    const std::vector<Side> sides = sidesOf(mesh);
    forEachEdge(sides, [&](std::size_t begin, std::size_t end) {
        int net = 0;
        for (std::size_t s = begin; s < end; ++s) {
            net += sides[s].forward ? 1 : -1;
        }
        for (; net > 0; --net) {
            open.push_back({sides[begin].lo, sides[begin].hi});
        }
        for (; net < 0; ++net) {
            open.push_back({sides[begin].hi, sides[begin].lo});
        }
    });
    // Loops are what hangs together by points.
    std::unordered_map<int, int> parent;
    const auto root = [&parent](int v) {
        int r = v;
        while (parent[r] != r) {
            r = parent[r];
        }
        while (parent[v] != r) {
            const int next = parent[v];
            parent[v] = r;
            v = next;
        }
        return r;
    };
    for (const auto& [a, b] : open) {
        parent.emplace(a, a);
        parent.emplace(b, b);
        parent[root(a)] = root(b);
    }
    struct Loop {
        Vec3d sum;
        double length = 0;
        int apex = -1;
    };
    std::unordered_map<int, Loop> found;
    boundary = 0;
    for (const auto& [a, b] : open) {
        const Vec3d p = mesh.points[std::size_t(a)], q = mesh.points[std::size_t(b)];
        Loop& loop = found[root(a)];
        loop.sum += (p + q) * (0.5 * length(q - p));
        loop.length += length(q - p);
        boundary += length(q - p);
    }
    TriangleMesh caps;
    std::unordered_map<int, int> numbers;
    const auto number = [&](int v) {
        const auto [at, added] = numbers.emplace(v, int(caps.points.size()));
        if (added) {
            caps.points.push_back(mesh.points[std::size_t(v)]);
        }
        return at->second;
    };
    for (const auto& [a, b] : open) {
        Loop& loop = found[root(a)];
        if (loop.apex < 0) {
            loop.apex = int(caps.points.size());
            caps.points.push_back(loop.length > 0 ? loop.sum / loop.length : mesh.points[std::size_t(a)]);
        }
        const int from = number(b), to = number(a);
        caps.triangles.push_back({from, to, loop.apex});
    }
    loops = found.size();
    return caps;
}

/// Volume with the holes closed by fans, and whether that tells which side is out: not where the holes are wide, as of
/// the patches of a model that were saved each for itself.
struct Enclosed {
    double volume = 0;
    bool tells = true;
};

Enclosed enclosedBy(const TriangleMesh& mesh) {
    std::size_t loops = 0;
    double boundary = 0, area = 0;
    TriangleMesh closed = mesh;
    append(closed, capsOf(mesh, loops, boundary));
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        area += 0.5 * length(cross(mesh.corner(i, 1) - mesh.corner(i, 0), mesh.corner(i, 2) - mesh.corner(i, 0)));
    }
    return {signedVolume(closed), boundary * boundary < 2 * area};
}

/// Turns pieces outward; `piece` is the piece of each triangle, `turn` collects.
void orientPieces(TriangleMesh& mesh, const std::vector<std::size_t>& piece, std::size_t count,
                  std::vector<bool>& turn) {
    std::vector<TriangleMesh> parts(count);
    std::vector<Box3d> boxes(count);
    {
        std::vector<std::unordered_map<int, int>> numbers(count);
        for (std::size_t i = 0; i < piece.size(); ++i) {
            TriangleMesh& part = parts[piece[i]];
            Vec3i t;
            for (int k = 0; k < 3; ++k) {
                const int v = mesh.triangles[i][k];
                const auto [at, added] = numbers[piece[i]].emplace(v, int(part.points.size()));
                if (added) {
                    part.points.push_back(mesh.points[std::size_t(v)]);
                }
                t[k] = at->second;
            }
            part.triangles.push_back(t);
        }
    }
    std::vector<Enclosed> enclosed(count);
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t(0));
    for (std::size_t p = 0; p < count; ++p) {
        enclosed[p] = enclosedBy(parts[p]);
        boxes[p] = boundsOf(parts[p]);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::abs(enclosed[a].volume) > std::abs(enclosed[b].volume);
    });
    std::vector<bool> flip(count, false);
    // Where the mesh as a whole faces inward, all of it is turned: cavities then face outward before and inward after.
    const bool all = enclosedBy(mesh).volume < 0;
    TriangleMesh larger;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t p = order[i];
        flip[p] = all;
        if (enclosed[p].tells && (enclosed[p].volume < 0) != all) {
            bool cavity = false;
            for (std::size_t j = 0; j < i && count <= kMaxNestedPieces && !cavity; ++j) {
                cavity = boxes[order[j]].distance(boxes[p].lo) == 0 && boxes[order[j]].distance(boxes[p].hi) == 0;
            }
            flip[p] = flip[p] != !(cavity && TriangleTree(larger).windingNumber(parts[p].points[0]) > 0.5);
        }
        if (count <= kMaxNestedPieces) {
            TriangleMesh part = parts[p];
            if (flip[p]) {
                applyTurns(part, std::vector<bool>(part.triangles.size(), true));
            }
            append(larger, part);
        }
    }
    for (std::size_t i = 0; i < piece.size(); ++i) {
        if (flip[piece[i]]) {
            turn[i] = !turn[i];
            std::swap(mesh.triangles[i].y, mesh.triangles[i].z);
        }
    }
}

} // namespace

std::string MeshRepair::summary() const {
    std::ostringstream s;
    s << triangles << " triangles in " << pieces << (pieces == 1 ? " piece" : " pieces");
    if (holes) {
        s << ", " << holes << (holes == 1 ? " hole" : " holes") << " of " << boundaryMm
          << " mm boundary in all (winding numbers decide what is inside)";
    } else {
        s << ", closed";
    }
    if (turned) {
        s << ", " << turned << " turned outward";
    }
    if (degenerate) {
        s << ", " << degenerate << " degenerate dropped";
    }
    if (duplicates) {
        s << ", " << duplicates << " repeated dropped";
    }
    if (crowdedEdges) {
        s << ", " << crowdedEdges << " edges of more than two triangles";
    }
    return s.str();
}

MendedMesh repair(const TriangleMesh& mesh, const std::string& name) {
    check(mesh, name);
    MendedMesh result;
    MeshRepair& found = result.repair;
    found.points = mesh.points.size();
    found.triangles = mesh.triangles.size();
    result.mesh = mergePoints(mesh);
    dropFaces(result.mesh, found);
    if (result.mesh.triangles.empty()) {
        throw Error(name + ": all of its " + std::to_string(found.triangles) + " triangles are degenerate");
    }
    const std::vector<Side> sides = sidesOf(result.mesh);
    forEachEdge(sides, [&](std::size_t begin, std::size_t end) { found.crowdedEdges += end - begin > 2; });
    std::vector<bool> turn;
    const std::vector<std::size_t> piece = findPieces(result.mesh, sides, turn, found.pieces);
    applyTurns(result.mesh, turn);
    orientPieces(result.mesh, piece, found.pieces, turn);
    found.turned = std::size_t(std::count(turn.begin(), turn.end(), true));
    result.caps = capsOf(result.mesh, found.holes, found.boundaryMm);
    TriangleMesh closed = result.mesh;
    append(closed, result.caps);
    found.volume = signedVolume(closed);
    return result;
}

} // namespace stf
