// SPDX-License-Identifier: Apache-2.0
// Point 10: geometry.
#include "stfLib/shell/shell_surface.h"
#include "stfLib/surface/refined_surface.h"
#include "tools/stability/small_scene.h"

#include <cmath>
#include <limits>

namespace stf {

namespace {

// A body that fills the picture, under a sun and a sky.
SmallScene bodyScene(StabilityRun& run, const ControlMesh& mesh) {
    SmallScene scene(run);
    scene.mesh = mesh;
    scene.setLightCosine(0.6);
    scene.lights["/sky"].type = Light::Type::Dome;
    scene.lights["/sky"].emission = Rgb(0.5f);
    scene.setCore(0.9);
    scene.settings.quality = 0.1f;
    scene.size = 16;
    scene.viewMm = 4;
    return scene;
}

// Under light of irradiance pi and a sky of .5 nothing that only scatters is brighter than some 1.5 times Lambert's.
bool sane(const SmallPicture& p) {
    return p.finite() && p.largest() < 2.5f && p.largest() > 0;
}

StabilityOutcome body(StabilityRun& run, const ControlMesh& mesh) {
    const SmallPicture p = bodyScene(run, mesh).render();
    return {measuredText("radiance up to %.3f, mean %.3f; %s", double(p.largest()), p.mean().y,
                         p.messages.empty() ? "nothing was said" : p.messages[0].c_str()),
            sane(p)};
}

StabilityOutcome foldOver(StabilityRun& run) {
    ControlMesh mesh = cubeMesh(2, ControlMesh::Scheme::CatmullClark); // its radius of curvature is below 1 mm
    SmallScene scene = bodyScene(run, mesh);
    scene.volume = uniformVolume(4, 0.9, 0, 16, 4);
    scene.viewMm = 2;
    const SmallPicture p = scene.render();
    RefineOptions how;
    how.targetEdge = 0.1f;
    const RefinedSurface surface = refine(mesh, how, {});
    const ShellBoundary inner = offsetInward(surface, 4, {});
    int turned = 0;
    for (const Vec3i& t : surface.triangles) {
        const auto side = [&](const std::vector<Vec3f>& q) {
            return cross(q[std::size_t(t.y)] - q[std::size_t(t.x)], q[std::size_t(t.z)] - q[std::size_t(t.x)]);
        };
        turned += dot(side(surface.points), side(inner.inner)) < 0 ? 1 : 0;
    }
    return {measuredText("%d of %d triangles turned over; radiance up to %.3f; %s", turned,
                         int(surface.triangles.size()), double(p.largest()),
                         p.messages.empty() ? "nothing was said" : p.messages[0].c_str()),
            sane(p) && turned == 0 && !p.messages.empty()};
}

StabilityOutcome oneFace(StabilityRun& run) {
    ControlMesh mesh;
    mesh.scheme = ControlMesh::Scheme::None;
    mesh.points = {{-10, -10, 0}, {10, -10, 0}, {0, 15, 0}};
    mesh.faceVertexCounts = {3};
    mesh.faceVertexIndices = {0, 1, 2};
    return body(run, mesh);
}

// Three squares that share an edge.
StabilityOutcome nonManifold(StabilityRun& run) {
    ControlMesh mesh = squareMesh();
    mesh.uvs.clear();
    mesh.uvIndices.clear();
    mesh.points = {{-3, -3, 0}, {-3, 3, 0}, {0, 3, 0}, {0, -3, 0}, {3, 3, 0}, {3, -3, 0}, {0, 3, 3}, {0, -3, 3}};
    mesh.faceVertexCounts = {4, 4, 4};
    mesh.faceVertexIndices = {0, 3, 2, 1, 3, 5, 4, 2, 3, 7, 6, 2};
    return body(run, mesh);
}

StabilityOutcome degenerate(StabilityRun& run) {
    ControlMesh mesh = squareMesh();
    const auto add = [&](std::vector<int> face) {
        mesh.faceVertexCounts.push_back(int(face.size()));
        for (int i : face) {
            mesh.faceVertexIndices.push_back(i);
            mesh.uvIndices.push_back(0);
        }
    };
    mesh.points.push_back({0, 0, 0.5f});
    mesh.points.push_back({1, 0, std::numeric_limits<float>::quiet_NaN()});
    add({0, 0, 1});    // two vertices
    add({0, 1, 99});   // an index out of range
    add({0, 1, 5});    // a point that is not finite
    add({0, 4, 2, 4}); // no area
    add({1});
    return body(run, mesh);
}

StabilityOutcome invertedTwice(StabilityRun& run) {
    SmallScene scene = bodyScene(run, squareMesh());
    const SmallPicture straight = scene.render();
    std::reverse(scene.mesh.faceVertexIndices.begin(), scene.mesh.faceVertexIndices.end());
    std::reverse(scene.mesh.uvIndices.begin(), scene.mesh.uvIndices.end());
    scene.mesh.leftHanded = true;
    const SmallPicture turned = scene.render();
    const double off = std::abs(turned.mean().y / straight.mean().y - 1);
    scene.mesh = cubeMesh(6, ControlMesh::Scheme::CatmullClark);
    scene.mesh.leftHanded = true; // inside out
    const SmallPicture inverted = scene.render();
    return {measuredText("left-handed: mean differs by %.2e; inside out: radiance up to %.3f", off,
                         double(inverted.largest())),
            sane(turned) && off < 0.01 && inverted.finite() && inverted.largest() < 2.5f};
}

StabilityOutcome mirrored(StabilityRun& run) {
    SmallScene scene = bodyScene(run, squareMesh());
    scene.lights.erase("/sky");
    const SmallPicture straight = scene.render();
    scene.instances[0].objectToWorld.x = {-1, 0, 0};
    const SmallPicture p = scene.render();
    const double off = p.mean().y / straight.mean().y - 1, noise = 3 * (p.error() + straight.error()) / p.mean().y;
    return {measuredText("mean differs by %+.2f %%, noise %.2f %%", 100 * off, 100 * noise),
            sane(p) && std::abs(off) < 0.005 + noise};
}

StabilityOutcome singular(StabilityRun& run) {
    SmallScene scene = bodyScene(run, squareMesh());
    ControlMesh other = squareMesh();
    for (Vec3f& p : other.points) {
        p.z = -8;
    }
    other.colors = {Rgb(0.5f)};
    scene.plain["/below"] = other;
    MeshInstance flat, infinite;
    flat.objectToWorld.y = {0, 0, 0};
    infinite.objectToWorld.translation.x = std::numeric_limits<double>::infinity();
    scene.instances = {flat, infinite};
    const SmallPicture p = scene.render();
    return {measuredText("what lies below has mean %.3f; %s", p.mean().y,
                         p.messages.empty() ? "nothing was said" : p.messages[0].c_str()),
            sane(p) && p.said("/object") && p.said("singular") && p.mean().y > 0.3};
}

StabilityOutcome stretched(StabilityRun& run) {
    SmallScene scene = bodyScene(run, cubeMesh(6, ControlMesh::Scheme::CatmullClark));
    Transform& t = scene.instances[0].objectToWorld;
    t.x = {2, 0.3, 0};
    t.y = {0.4, 0.1, -0.5};
    t.z = {0, 0.5, -3};
    const SmallPicture p = scene.render();
    return {measuredText("determinant %.2f, radiance up to %.3f", t.determinant(), double(p.largest())), sane(p)};
}

StabilityOutcome hardEdges(StabilityRun& run) {
    ControlMesh creased = cubeMesh(6, ControlMesh::Scheme::CatmullClark);
    creased.creaseIndices = {0, 1, 3, 2, 0};
    creased.creaseLengths = {5};
    creased.creaseSharpnesses = {10};
    const StabilityOutcome a = body(run, cubeMesh(6, ControlMesh::Scheme::None)), b = body(run, creased);
    return {"cube: " + a.measured + "; creased: " + b.measured, a.ok && b.ok};
}

// A camera a little above the surface, on it, a little below; on the inner boundary and in the core.
StabilityOutcome cameraInside(StabilityRun& run) {
    SmallScene scene(run);
    scene.setCore(0.9);
    scene.inside = true;
    scene.settings.samples = 64;
    scene.settings.quality = 0.02f;
    std::string text = "mean radiance:";
    bool ok = true;
    double before = 0;
    for (const double z : {1e-3, 0.0, -1e-3}) {
        scene.lookAt = {0, 0, z};
        const SmallPicture p = scene.render();
        text += measuredText(" %.4f", p.mean().y);
        ok = ok && sane(p) && (before == 0 || std::abs(p.mean().y / before - 1) < 0.02);
        before = p.mean().y;
    }
    for (const double z : {-1.0, -2.0, -2.5}) {
        for (const bool up : {false, true}) {
            scene.lookAt = {0, 0, z};
            scene.upward = up;
            const SmallPicture p = scene.render();
            text += measuredText(" %.4f", p.mean().y);
            ok = ok && p.finite() && p.largest() < 10;
        }
    }
    return {text, ok};
}

// The tile as it is, and as many columns of the same.
StabilityOutcome tinyTiles(StabilityRun& run) {
    SmallScene scene(run);
    scene.setCore(0.9);
    scene.settings.samples = 64;
    const SmallPicture column = scene.render();
    const BaseVolume one = scene.volume;
    BaseVolume& v = scene.volume;
    v.size = {4, 4, one.size.z};
    v.extinction.assign(v.voxelCount(), one.extinction[0]);
    v.albedo.assign(v.voxelCount(), one.albedo[0]);
    v.g.assign(one.g.empty() ? 0 : v.voxelCount(), 0.0f);
    const SmallPicture many = scene.render();
    scene.volume = uniformVolume(2, 0.9, 0, 1, 2);
    const SmallPicture single = scene.render();
    const double columns = many.mean().y / column.mean().y - 1, layers = single.mean().y / column.mean().y - 1;
    return {measuredText("4x4x8 for 1x1x8: %+.2e; 1x1x1 for 1x1x8: %+.1f %%", columns, 100 * layers),
            sane(many) && sane(single) && std::abs(columns) < 0.005 && std::abs(layers) < 0.15};
}

// Sides that do not fit: half of the tile black.
StabilityOutcome notPeriodic(StabilityRun& run) {
    SmallScene scene(run);
    BaseVolume& v = scene.volume;
    v.size = {8, 8, 4};
    v.voxelMm = Vec3d(0.5);
    v.extinction.assign(v.voxelCount(), Rgb(1.0f));
    v.albedo.assign(v.voxelCount(), Rgb(0.0f));
    v.g.clear();
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.albedo[i] = Rgb(i % 8 < 4 ? 1.0f : 0.0f);
    }
    scene.settings.quality = 0.1f;
    scene.viewMm = 16;
    scene.size = 16;
    const SmallPicture p = scene.render();
    return {measuredText("radiance up to %.3f, mean %.3f", double(p.largest()), p.mean().y), sane(p)};
}

// Voxel faces on the line of sight, and light along them.
StabilityOutcome alongFaces(StabilityRun& run) {
    SmallScene scene(run);
    BaseVolume& v = scene.volume;
    v.size = {2, 2, 4};
    v.voxelMm = Vec3d(0.5);
    v.extinction.assign(v.voxelCount(), Rgb(1.0f));
    v.albedo.assign(v.voxelCount(), Rgb(0.9f));
    v.g.clear();
    v.extinction[0] = Rgb(1.5f);
    scene.settings.quality = 0.1f;
    const SmallPicture above = scene.render();
    scene.setLightCosine(1e-4);
    const SmallPicture grazing = scene.render();
    scene.setLightCosine(1);
    scene.viewCosine = 0.01;
    const SmallPicture along = scene.render();
    return {measuredText("radiance from above %.3f, with grazing light %.2e, seen along the surface %.3f",
                         double(above.largest()), double(grazing.largest()), double(along.largest())),
            sane(above) && sane(along) && grazing.finite() && grazing.largest() < 1e-2f};
}

} // namespace

void addGeometryCases(std::vector<StabilityCase>& all) {
    const char* whole = "finite, lit, no brighter than 2.5";
    all.push_back({"10.fold-over", "a rounded cube of 2 mm with a sample 4 mm deep",
                   "the boundary is not turned over anywhere, the user is told; finite", false, false, foldOver});
    all.push_back({"10.one-face", "a mesh of one triangle", whole, false, false, oneFace});
    all.push_back({"10.non-manifold", "three squares at one edge", whole, false, false, nonManifold});
    all.push_back(
        {"10.degenerate",
         "a square with faces of two vertices, one, no area, an index out of range, a point that is no number", whole,
         false, false, degenerate});
    all.push_back({"10.inverted", "turned faces that are left-handed; a cube inside out",
                   "the same mean within 1 %; finite", false, false, invertedTwice});
    all.push_back(
        {"10.mirrored", "an instance mirrored in x", "the same mean within .5 % and noise", false, false, mirrored});
    all.push_back({"10.singular", "an instance without volume and one at infinity, before a grey wall",
                   "both left out with a message, the wall is there", false, false, singular});
    all.push_back({"10.sheared", "an instance stretched, sheared and mirrored", whole, false, false, stretched});
    all.push_back(
        {"10.hard-edges", "a cube with hard edges, a rounded one with a creased face", whole, false, false, hardEdges});
    all.push_back({"10.camera-inside", "a camera .001 mm above the surface, on it, below; in shell, boundary and core",
                   "steps through the surface change the mean by less than 2 %; finite", false, false, cameraInside});
    all.push_back({"10.tiny-tiles", "tiles of 1x1x8, 4x4x8 and 1x1x1 voxels of one medium",
                   "columns do not matter (.5 %); one layer of 2 mean free paths is within 15 %", false, false,
                   tinyTiles});
    all.push_back({"10.not-periodic", "a tile half white, half black", whole, false, false, notPeriodic});
    all.push_back({"10.along-faces", "light and view along the faces of voxels, light and view at grazing angles",
                   whole, false, false, alongFaces});
}

} // namespace stf
