// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shell_mapping.h"

#include "stfLib/render/mesh_hash.h"
#include "stfLib/synthesis/synthesize.h"

#include <cstdio>
#include <optional>

namespace stf {

namespace {

constexpr std::size_t kMostSynthesisTriangles = 4'000'000;
constexpr std::size_t kMostRefinedTriangles = 600'000;
constexpr double kBlendTexels = 3; ///< between samples of a blend: weights and directions change slowly

template<class... T>
std::string format(const char* pattern, T... values) {
    char text[200];
    std::snprintf(text, sizeof text, pattern, values...);
    return text;
}

} // namespace

/// How a surface is sampled.
struct ShellMappings::Sampling {
    RefineOptions refine;
    double texelMm = 0; ///< 0: as the limit surface is refined
    double mmPerUnit = 1;

    /// Fine enough for a shell of that thickness (object units) and for the silhouette, no finer than anyone sees.
    Sampling(const ControlMesh& mesh, int refineLevel, double thickness) {
        Box3f box;
        for (const Vec3f& p : mesh.rest.empty() ? mesh.points : mesh.rest) {
            box.add(p);
        }
        refine.level = refineLevel;
        refine.targetEdge = std::clamp(0.6f * float(thickness), box.diagonal() / 400, box.diagonal() / 60);
        refine.maxTriangles = kMostRefinedTriangles;
    }
    std::string key() const {
        return format(";level=%d;edge=%.9g;texel=%.17g/%.17g", refine.level, double(refine.targetEdge), texelMm,
                      mmPerUnit);
    }
};

struct ShellMappings::Sampled {
    RefinedSurface surface;
    SurfacePose pose; ///< empty for a mesh without rest pose
};

ShellMappings::Sampled ShellMappings::refined(const ControlMesh& mesh, const Sampling& how,
                                              const ShellStage& stage) const {
    ++stage.stats.refinements;
    Sampled s;
    s.surface = mesh.rest.empty() ? refine(mesh, how.refine, stage.messages)
                                  : refineAtRest(mesh, how.refine, stage.messages, s.pose);
    return s;
}

ShellMappings::Sampled ShellMappings::sampled(Sampled s, const Sampling& how, const ShellStage& stage) const {
    if (how.texelMm > 0) {
        s.surface = sampleSurface(std::move(s.surface), how.texelMm, how.mmPerUnit, kMostSynthesisTriangles,
                                  stage.messages, s.pose.points.empty() ? nullptr : &s.pose);
    }
    return s;
}

MappedSurface ShellMappings::prepare(const ControlMesh& given, int refineLevel, const StfBinding& binding,
                                     const ShellObject& o, const std::string& volumeHash, const ShellStage& stage) {
    ControlMesh mesh = given;
    mesh.colors.clear(); // the sample's colours are what is seen
    if (binding.mapping == "uv") {
        mesh.orientation.clear();
    }
    const StageTimer timer;
    const double mmPerUnit = double(o.mmPerUnit);
    const std::string rest = restHash(mesh);
    MappedSurface out;

    // Which mapping, judged on the surface of a shell as deep as the sample, so that the thickness does not matter.
    Sampling how(mesh, refineLevel, o.source->extentMm().z / mmPerUnit);
    const std::string choiceKey = rest + how.key() + ";" + binding.mapping + ";volume=" + volumeHash +
                                  (o.volume->laterallyUniform() ? ";uniform" : "");
    std::optional<Sampled> limit, samples; ///< what was made on the way
    out.choice = choices_.find(choiceKey);
    if (!out.choice) {
        limit = refined(mesh, how, stage);
        out.choice = choices_.keep(choiceKey, chooseMapping(binding.mapping, limit->surface, *o.volume));
    }
    const float coarse = how.refine.targetEdge;
    if (out.choice->mapping == Mapping::Synthesize) {
        how.texelMm = std::max(o.volume->voxelMm.x, o.volume->voxelMm.y);
        how.mmPerUnit = mmPerUnit;
    } else if (out.choice->mapping == Mapping::Blend) {
        how.texelMm = kBlendTexels * std::max(o.volume->voxelMm.x, o.volume->voxelMm.y);
        how.mmPerUnit = mmPerUnit;
    } else {
        how = Sampling(mesh, refineLevel, double(o.thicknessMm) / mmPerUnit);
    }
    const auto make = [&]() -> Sampled& {
        if (!samples) {
            samples = sampled(limit && how.refine.targetEdge == coarse ? std::move(*limit) : refined(mesh, how, stage),
                              how, stage);
            limit.reset();
        }
        return *samples;
    };
    out.key = rest + how.key();
    out.surface = surfaces_.find(out.key);
    const bool kept = out.surface != nullptr;
    if (!kept) {
        out.surface = surfaces_.keep(out.key, std::move(make().surface));
    }
    stage.noteKept("surface", kept, std::to_string(out.surface->triangles.size()) + " triangles", timer.seconds());

    if (!mesh.rest.empty()) {
        const StageTimer posing;
        const bool moved = mesh.points != mesh.rest || !mesh.normals.empty();
        bool posedBefore = false;
        if (moved) {
            out.poseKey = out.key + ";pose=" + poseHash(mesh);
            out.posed = poses_.find(out.poseKey);
            posedBefore = out.posed != nullptr;
            if (!posedBefore) {
                out.posed = poses_.keep(out.poseKey, inPose(*out.surface, std::move(make().pose)));
                ++stage.stats.poses;
            }
        }
        stage.note("pose", moved && !posedBefore,
                   moved ? std::string("points follow stf:rest, the sample stays on them") +
                               (posedBefore ? "; already in memory" : "")
                         : "the mesh is at rest",
                   posing.seconds());
    }
    addMap(binding, o, volumeHash, stage, out);
    if (!given.orientation.empty() && out.choice->mapping != Mapping::Synthesize) {
        stage.note("orientation", false, "stf:orientation is for synthesis only", 0);
    }
    if (mesh.rest.empty() && out.choice->mapping == Mapping::Synthesize) {
        noticeMotion(mesh, stage);
    }
    stage.stats.synthesisSeconds += timer.seconds();
    return out;
}

void ShellMappings::addMap(const StfBinding& binding, const ShellObject& o, const std::string& volumeHash,
                           const ShellStage& stage, MappedSurface& out) {
    const StageTimer timer;
    const Vec3d extent = o.volume->extentMm();
    const Vec2d tile{extent.x, extent.y};
    const double mmPerUnit = double(o.mmPerUnit);
    const bool synthesized = out.choice->mapping == Mapping::Synthesize;
    out.key += format(";mapping=%d;tile=%.17g,%.17g;scale=%.17g", int(out.choice->mapping), tile.x, tile.y, mmPerUnit);
    if (out.choice->mapping == Mapping::Blend) {
        out.key += format(";seed=%d", binding.seed);
    }
    if (synthesized) {
        out.key += ";volume=" + volumeHash + format(";seed=%d", binding.seed);
    }
    const auto finish = [&](bool ran, const char* how) {
        stage.note("synthesis", ran, out.choice->why + "; " + out.map->description + how, timer.seconds());
    };
    if (out.choice->mapping == Mapping::Blend) {
        out.blend = blendMaps_.find(out.key);
        const bool kept = out.blend != nullptr;
        if (!kept) {
            out.blend = blendMaps_.keep(out.key, blendMap(*out.surface, tile, mmPerUnit,
                                                          std::uint64_t(std::uint32_t(binding.seed)), stage.progress));
        }
        out.map = std::shared_ptr<const ExemplarMap>(out.blend, &out.blend->first);
        finish(!kept, kept ? "; already in memory" : "");
        return;
    }
    if ((out.map = exemplarMaps_.find(out.key))) {
        finish(false, "; already in memory");
        return;
    }
    exemplarMaps_.dropUnused(); // the one before, rather than both at once
    if (!synthesized) {
        out.map = exemplarMaps_.keep(out.key, out.choice->mapping == Mapping::Uv
                                                  ? tileByUv(*out.surface, tile, 1 / mmPerUnit, stage.messages)
                                                  : mapAnywhere(*out.surface, tile, 1 / mmPerUnit));
        finish(false, "");
        return;
    }
    bool made = false;
    const auto make = [&] {
        made = true;
        ++stage.stats.syntheses;
        SynthesisOptions options;
        options.seed = std::uint64_t(std::uint32_t(binding.seed));
        options.orientation = out.surface->orientation;
        // The whole sample, however thin the shell: its thickness must not lay it out anew.
        return exemplarMap(synthesize(*out.surface, *o.source, mmPerUnit, options, stage.progress));
    };
    const std::size_t corners = 3 * out.surface->triangles.size();
    const std::string key = format("exemplar map %d;corners=%zu;", kSynthesisVersion, corners) + out.key;
    std::shared_ptr<const ExemplarMap> map =
        maps_ ? maps_(key, make, stage.progress, stage.messages) : std::make_shared<const ExemplarMap>(make());
    if (map->cornerCoords.size() != corners) {
        throw Error("the exemplar coordinates do not belong to the surface");
    }
    out.map = exemplarMaps_.keep(out.key, std::move(map));
    finish(made, made ? "" : "; kept from an earlier run");
}

void ShellMappings::noticeMotion(const ControlMesh& mesh, const ShellStage& stage) {
    Seen now{topologyHash(mesh), poseHash(mesh)};
    Seen& before = seen_[stage.id];
    if (before.topology == now.topology && before.points != now.points) {
        report(stage.messages, Severity::Warning,
               "its points moved and the sample is laid out anew; primvars:stf:rest would keep it where it is");
    }
    before = std::move(now);
}

void ShellMappings::dropUnused() {
    choices_.dropUnused();
    surfaces_.dropUnused();
    poses_.dropUnused();
    exemplarMaps_.dropUnused();
    blendMaps_.dropUnused();
}

} // namespace stf
