// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/refine_parts.h"

#include <cstdint>
#include <memory>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefiner.h>
#include <opensubdiv/far/topologyRefinerFactory.h>
#include <unordered_set>

namespace stf {

namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

/// What is subdivided together at a vertex. OpenSubdiv asks for Clear and AddWithWeight.
struct VertexValue {
    Vec3d position, posed, color, orientation;
    void Clear(void* = nullptr) { *this = {}; }
    void AddWithWeight(const VertexValue& v, double w) {
        position += v.position * w;
        posed += v.posed * w;
        color += v.color * w;
        orientation += v.orientation * w;
    }
};

struct Tangent {
    Vec3d v, posed;
    void Clear(void* = nullptr) { *this = {}; }
    void AddWithWeight(const VertexValue& s, double w) {
        v += s.position * w;
        posed += s.posed * w;
    }
};

struct UvValue {
    double u = 0, v = 0;
    void Clear(void* = nullptr) { u = v = 0; }
    void AddWithWeight(const UvValue& s, double w) {
        u += w * s.u;
        v += w * s.v;
    }
};

Sdc::Options subdivisionOptions(const ControlMesh& mesh) {
    Sdc::Options options;
    const std::string& boundary = mesh.interpolateBoundary;
    options.SetVtxBoundaryInterpolation(boundary == "none"       ? Sdc::Options::VTX_BOUNDARY_NONE
                                        : boundary == "edgeOnly" ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                                                 : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    const std::string& uv = mesh.faceVaryingInterpolation;
    options.SetFVarLinearInterpolation(uv == "none"           ? Sdc::Options::FVAR_LINEAR_NONE
                                       : uv == "cornersOnly"  ? Sdc::Options::FVAR_LINEAR_CORNERS_ONLY
                                       : uv == "cornersPlus2" ? Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2
                                       : uv == "boundaries"   ? Sdc::Options::FVAR_LINEAR_BOUNDARIES
                                       : uv == "all"          ? Sdc::Options::FVAR_LINEAR_ALL
                                                              : Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1);
    return options;
}

Sdc::SchemeType schemeType(const ControlMesh& mesh, const MessageSink& messages) {
    switch (mesh.scheme) {
    case ControlMesh::Scheme::Bilinear:
        return Sdc::SCHEME_BILINEAR;
    case ControlMesh::Scheme::Loop:
        for (int count : mesh.faceVertexCounts) {
            if (count != 3) {
                report(messages, Severity::Warning,
                       "scheme loop needs triangles only: subdivided by catmullClark instead");
                return Sdc::SCHEME_CATMARK;
            }
        }
        return Sdc::SCHEME_LOOP;
    default:
        return Sdc::SCHEME_CATMARK;
    }
}

/// Crease edges that exist in the mesh: OpenSubdiv prints a warning on stdout for each that does not.
void existingCreases(const ControlMesh& mesh, std::vector<int>& pairs, std::vector<float>& weights) {
    const auto key = [](int a, int b) { return std::uint64_t(std::min(a, b)) << 32 | std::uint32_t(std::max(a, b)); };
    if (mesh.creaseIndices.empty()) {
        return;
    }
    std::unordered_set<std::uint64_t> edges;
    std::size_t begin = 0;
    for (int count : mesh.faceVertexCounts) {
        for (int i = 0; i < count; ++i) {
            edges.insert(key(mesh.faceVertexIndices[begin + std::size_t(i)],
                             mesh.faceVertexIndices[begin + std::size_t((i + 1) % count)]));
        }
        begin += std::size_t(count);
    }
    std::size_t at = 0, edge = 0;
    const bool perCrease = mesh.creaseSharpnesses.size() == mesh.creaseLengths.size();
    for (std::size_t c = 0; c < mesh.creaseLengths.size(); ++c) {
        for (int i = 0; i + 1 < mesh.creaseLengths[c]; ++i, ++edge) {
            const int a = mesh.creaseIndices[at + std::size_t(i)], b = mesh.creaseIndices[at + std::size_t(i) + 1];
            if (edges.count(key(a, b))) {
                pairs.push_back(a);
                pairs.push_back(b);
                weights.push_back(mesh.creaseSharpnesses[perCrease ? c : edge]);
            }
        }
        at += std::size_t(mesh.creaseLengths[c]);
    }
}

std::unique_ptr<Far::TopologyRefiner> makeRefiner(const ControlMesh& mesh, const std::vector<int>& uvIndices,
                                                  std::size_t uvCount, const MessageSink& messages) {
    std::vector<int> creasePairs;
    std::vector<float> creaseWeights;
    existingCreases(mesh, creasePairs, creaseWeights);

    Far::TopologyDescriptor::FVarChannel channel;
    channel.numValues = int(uvCount);
    channel.valueIndices = uvIndices.data();
    Far::TopologyDescriptor desc;
    desc.numVertices = int(mesh.points.size());
    desc.numFaces = int(mesh.faceVertexCounts.size());
    desc.numVertsPerFace = mesh.faceVertexCounts.data();
    desc.vertIndicesPerFace = mesh.faceVertexIndices.data();
    desc.numCreases = int(creaseWeights.size());
    desc.creaseVertexIndexPairs = creasePairs.data();
    desc.creaseWeights = creaseWeights.data();
    desc.numCorners = int(mesh.cornerIndices.size());
    desc.cornerVertexIndices = mesh.cornerIndices.data();
    desc.cornerWeights = mesh.cornerSharpnesses.data();
    desc.numHoles = int(mesh.holeIndices.size());
    desc.holeIndices = mesh.holeIndices.data();
    desc.numFVarChannels = uvIndices.empty() ? 0 : 1;
    desc.fvarChannels = &channel;

    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    std::unique_ptr<Far::TopologyRefiner> refiner(
        Factory::Create(desc, Factory::Options(schemeType(mesh, messages), subdivisionOptions(mesh))));
    if (!refiner) {
        throw Error("OpenSubdiv refuses the topology of the mesh");
    }
    const Far::TopologyLevel& base = refiner->GetLevel(0);
    int nonManifold = 0;
    for (int e = 0; e < base.GetNumEdges(); ++e) {
        nonManifold += base.IsEdgeNonManifold(e);
    }
    if (nonManifold) {
        report(messages, Severity::Warning,
               std::to_string(nonManifold) +
                   " edges have more than two faces or faces of opposite winding: the surface "
                   "is creased there and inside and outside are not defined");
    }
    return refiner;
}

/// Vertex and uv values of one level.
struct LevelValues {
    std::vector<VertexValue> vertices;
    std::vector<UvValue> uvs;
};

LevelValues interpolate(const Far::TopologyRefiner& refiner, const LevelValues& base) {
    const Far::PrimvarRefinerReal<double> primvars(refiner);
    LevelValues values = base;
    for (int l = 1; l <= refiner.GetMaxLevel(); ++l) {
        LevelValues next;
        next.vertices.resize(std::size_t(refiner.GetLevel(l).GetNumVertices()));
        primvars.Interpolate(l, values.vertices, next.vertices);
        if (!base.uvs.empty()) {
            next.uvs.resize(std::size_t(refiner.GetLevel(l).GetNumFVarValues(0)));
            primvars.InterpolateFaceVarying(l, values.uvs, next.uvs);
        }
        values = std::move(next);
    }
    return values;
}

void refineTo(Far::TopologyRefiner& refiner, int level) {
    Far::TopologyRefiner::UniformOptions uniform(level);
    uniform.fullTopologyInLastLevel = true;
    refiner.Unrefine();
    refiner.RefineUniform(uniform);
}

double typicalEdge(const Far::TopologyLevel& level, const std::vector<VertexValue>& vertices) {
    std::vector<double> lengths;
    lengths.reserve(std::size_t(level.GetNumEdges()));
    for (int e = 0; e < level.GetNumEdges(); ++e) {
        const Far::ConstIndexArray ends = level.GetEdgeVertices(e);
        lengths.push_back(length(vertices[std::size_t(ends[1])].position - vertices[std::size_t(ends[0])].position));
    }
    return typicalLargest(lengths);
}

std::size_t triangleCount(const ControlMesh& mesh, bool loop, int level) {
    const std::size_t faces = mesh.faceVertexCounts.size(), corners = mesh.faceVertexIndices.size();
    if (loop) {
        return faces << (2 * level);
    }
    return level == 0 ? corners - 2 * faces : (2 * corners) << (2 * (level - 1));
}

/// Refines to the level that the options ask for.
LevelValues refineAsAsked(Far::TopologyRefiner& refiner, const ControlMesh& mesh, const LevelValues& base,
                          const RefineOptions& options, const MessageSink& messages) {
    const bool loop = refiner.GetSchemeType() == Sdc::SCHEME_LOOP;
    bool irregular = false;
    for (int count : mesh.faceVertexCounts) {
        irregular = irregular || count != (loop ? 3 : 4);
    }
    const int maxLevel = std::clamp(options.maxLevel, 0, 10);
    // Limits are defined for quads only, which other polygons become by one refinement.
    int level = std::clamp(options.level, irregular ? 1 : 0, std::max(maxLevel, irregular ? 1 : 0));
    const auto affordable = [&](int l) { return triangleCount(mesh, loop, l) <= options.maxTriangles; };
    int wanted = level;
    while (level > 0 && !affordable(level)) {
        --level;
    }
    refineTo(refiner, level);
    LevelValues values = interpolate(refiner, base);
    if (options.targetEdge > 0 && level == wanted) {
        // Edges halve with each level, nearly; one step is enough to know the length of smoothed edges.
        const double edge = typicalEdge(refiner.GetLevel(level), values.vertices);
        while (wanted < maxLevel && edge / double(1u << (wanted - level)) > double(options.targetEdge) &&
               triangleCount(mesh, loop, wanted + 1) <= options.maxEdgeTriangles) {
            ++wanted;
        }
        int reached = wanted;
        while (reached > level && !affordable(reached)) {
            --reached;
        }
        if (reached > level) {
            level = reached;
            refineTo(refiner, level);
            values = interpolate(refiner, base);
        }
    }
    if (level < wanted) {
        report(messages, Severity::Warning,
               "the mesh is refined to level " + std::to_string(level) + " instead of " + std::to_string(wanted) +
                   " to stay below " + std::to_string(options.maxTriangles) + " triangles");
    }
    return values;
}

std::vector<int> controlFaces(const Far::TopologyRefiner& refiner) {
    std::vector<int> face(std::size_t(refiner.GetLevel(0).GetNumFaces()));
    for (std::size_t f = 0; f < face.size(); ++f) {
        face[f] = int(f);
    }
    for (int l = 1; l <= refiner.GetMaxLevel(); ++l) {
        const Far::TopologyLevel& level = refiner.GetLevel(l);
        std::vector<int> next(std::size_t(level.GetNumFaces()));
        for (std::size_t f = 0; f < next.size(); ++f) {
            next[f] = face[std::size_t(level.GetFaceParentFace(int(f)))];
        }
        face.swap(next);
    }
    return face;
}

void triangulate(const Far::TopologyRefiner& refiner, bool withUvs, RefinedSurface& surface) {
    const Far::TopologyLevel& level = refiner.GetLevel(refiner.GetMaxLevel());
    const std::vector<int> control = controlFaces(refiner);
    std::vector<Vec3d> corners;
    std::vector<Vec3i> triangles;
    for (int f = 0; f < level.GetNumFaces(); ++f) {
        if (level.IsFaceHole(f)) {
            continue;
        }
        const Far::ConstIndexArray vertices = level.GetFaceVertices(f);
        corners.clear();
        for (int i = 0; i < vertices.size(); ++i) {
            corners.emplace_back(surface.points[std::size_t(vertices[i])]);
        }
        triangles.clear();
        triangulateFace(corners, triangles);
        for (const Vec3i& t : triangles) {
            surface.triangles.push_back({vertices[t.x], vertices[t.y], vertices[t.z]});
            surface.triangleFace.push_back(control[std::size_t(f)]);
            if (withUvs) {
                const Far::ConstIndexArray uv = level.GetFaceFVarValues(f);
                surface.uvTriangles.push_back({uv[t.x], uv[t.y], uv[t.z]});
            }
        }
    }
}

/// Where a limit tangent plane describes the surface on all sides of the vertex.
bool smoothVertex(const Far::TopologyLevel& level, int v) {
    if (level.IsVertexNonManifold(v)) {
        return false;
    }
    const Sdc::Crease::Rule rule = level.GetVertexRule(v);
    return rule == Sdc::Crease::RULE_SMOOTH || rule == Sdc::Crease::RULE_DART || level.IsVertexBoundary(v);
}

/// Limit normals of the positions, or of those posed.
std::vector<Vec3f> limitNormals(const Far::TopologyLevel& level, const std::vector<Tangent>& du,
                                const std::vector<Tangent>& dv, Vec3d Tangent::*which, const std::vector<Vec3f>& points,
                                const std::vector<Vec3i>& triangles) {
    const std::vector<Vec3f> mean = angleWeightedNormals(points, triangles);
    std::vector<Vec3f> normals(points.size());
    for (std::size_t v = 0; v < points.size(); ++v) {
        normals[v] = dot(mean[v], mean[v]) > 0.5f ? mean[v] : Vec3f(0, 0, 1);
        if (du.empty() || !smoothVertex(level, int(v))) {
            continue;
        }
        const Vec3d u = du[v].*which, w = dv[v].*which, n = cross(u, w);
        // Tangents that are zero or parallel, and those of reflex corners, say nothing.
        const bool degenerate = !(length(n) > 1e-7 * length(u) * length(w));
        const Vec3f unit(normalize(n));
        if (!degenerate && (dot(unit, mean[v]) > 0.2f || !(dot(mean[v], mean[v]) > 0.5f))) {
            normals[v] = unit;
        }
    }
    return normals;
}

} // namespace

RefinedSurface refineSubdivision(const ControlMesh& mesh, const RefineOptions& options, const MessageSink& messages,
                                 SurfacePose* pose) {
    LevelValues base;
    const std::vector<Rgb> colors = controlPointValues(mesh, mesh.colors, mesh.colorInterpolation);
    const std::vector<Vec3f> orientation = controlPointValues(mesh, mesh.orientation, mesh.orientationInterpolation);
    base.vertices.resize(mesh.points.size());
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        base.vertices[i] = {Vec3d(mesh.points[i]), pose ? Vec3d(pose->points[i]) : Vec3d(),
                            colors.empty() ? Vec3d() : Vec3d(colors[i]),
                            orientation.empty() ? Vec3d() : Vec3d(orientation[i])};
    }
    std::vector<Vec2f> uvs;
    std::vector<int> uvIndices;
    if (!mesh.uvIndices.empty()) {
        weldUvs(mesh, uvs, uvIndices);
    }
    for (const Vec2f& uv : uvs) {
        base.uvs.push_back({double(uv.x), double(uv.y)});
    }

    const std::unique_ptr<Far::TopologyRefiner> refiner = makeRefiner(mesh, uvIndices, uvs.size(), messages);
    LevelValues values = refineAsAsked(*refiner, mesh, base, options, messages);
    const Far::TopologyLevel& level = refiner->GetLevel(refiner->GetMaxLevel());

    bool limitDefined = refiner->GetSchemeType() != Sdc::SCHEME_BILINEAR;
    if (refiner->GetMaxLevel() == 0 && refiner->GetSchemeType() == Sdc::SCHEME_CATMARK) {
        for (int count : mesh.faceVertexCounts) {
            limitDefined = limitDefined && count == 4;
        }
    }
    std::vector<Tangent> du, dv;
    if (limitDefined) {
        const Far::PrimvarRefinerReal<double> primvars(*refiner);
        std::vector<VertexValue> limit(values.vertices.size());
        du.resize(limit.size());
        dv.resize(limit.size());
        primvars.Limit(values.vertices, limit, du, dv);
        values.vertices.swap(limit);
        if (!values.uvs.empty()) {
            std::vector<UvValue> uvLimit(values.uvs.size());
            primvars.LimitFaceVarying(values.uvs, uvLimit);
            values.uvs.swap(uvLimit);
        }
    }

    RefinedSurface surface;
    if (pose) {
        pose->points.clear();
    }
    for (const VertexValue& v : values.vertices) {
        surface.points.emplace_back(v.position);
        if (pose) {
            pose->points.emplace_back(v.posed);
        }
        if (!colors.empty()) {
            surface.colors.emplace_back(v.color);
        }
        if (!orientation.empty()) {
            surface.orientation.emplace_back(v.orientation);
        }
    }
    normalizeOrientation(surface.orientation);
    for (const UvValue& uv : values.uvs) {
        surface.uvs.push_back({float(uv.u), float(uv.v)});
    }
    triangulate(*refiner, !values.uvs.empty(), surface);
    surface.normals = limitNormals(level, du, dv, &Tangent::v, surface.points, surface.triangles);
    if (pose) {
        pose->normals = limitNormals(level, du, dv, &Tangent::posed, pose->points, surface.triangles);
    }
    return surface;
}

} // namespace stf
