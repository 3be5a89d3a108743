// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/shell_json.h"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace stf {

std::string shellJson(const ShellGrid& grid, const ShellBoundary& boundary, const ShellRun& run) {
    nlohmann::ordered_json j;
    j["triangles"] = run.triangles;
    j["mmPerUnit"] = run.mmPerUnit;
    j["thickness"] = run.thickness;
    j["mapping"] = run.mapping;
    j["levels"] = nlohmann::ordered_json::array();
    for (const ShellLevelReport& l : grid.levels()) {
        j["levels"].push_back({{"voxel", l.voxel},
                               {"samples", l.samples},
                               {"bytes", l.bytes},
                               {"seconds", l.seconds},
                               {"exemplarTexels", l.exemplarTexels},
                               {"depthTexels", l.depthTexels},
                               {"depthVoxels", l.depthVoxels},
                               {"normalDegrees", l.normalDegrees},
                               {"otherSheetShare", l.otherSheetShare},
                               {"seamWrongShare", l.seamWrongShare},
                               {"seamTexels", l.seamTexels},
                               {"missingShare", l.missingShare},
                               {"foldedVoxels", l.foldedVoxels}});
    }
    const ShellGridReport& r = grid.report();
    j["errorMet"] = r.errorMet;
    j["probes"] = r.probes;
    j["bytes"] = grid.memoryBytes();
    j["samples"] = grid.sampleCount();
    const ShellClamping& c = boundary.clamping;
    j["clamped"] = {{"points", boundary.clampedPoints},
                    {"curvature", c.curvature},
                    {"thinParts", c.thinParts},
                    {"turned", c.turned},
                    {"beside", c.beside},
                    {"lowest", c.lowest}};
    j["edges"] = {{"seamLength", r.seamLength},
                  {"rims", r.rimEdges},
                  {"rimLength", r.rimLength},
                  {"crowded", r.crowdedEdges},
                  {"turned", r.turnedEdges},
                  {"insideOut", r.insideOut},
                  {"unusableTriangles", r.unusableTriangles}};
    for (const auto& [stage, seconds] : run.seconds) {
        j["stageSeconds"][stage] = seconds;
    }
    j["peakBytes"] = run.peakBytes;
    return j.dump();
}

std::string shellText(const ShellGrid& grid, const ShellBoundary& boundary, const ShellRun& run) {
    char line[400];
    std::snprintf(line, sizeof line, "%zu triangles, thickness %.4g units, %.4g mm each; %s\n", run.triangles,
                  double(run.thickness), run.mmPerUnit, run.mapping.c_str());
    std::string text = line;
    text += "level     voxel     samples      MB       s   coord tx   depth tx   normal  seam wrong  seam tx  other  "
            "missing\n";
    int number = 0;
    for (const ShellLevelReport& l : grid.levels()) {
        std::snprintf(
            line, sizeof line, "%5d %9.4g %11zu %7.1f %7.2f %10.4f %10.4f %7.3f' %9.2f %% %8.3f %5.2f %% %6.3f %%\n",
            number++, l.voxel, l.samples, double(l.bytes) / 1e6, l.seconds, l.exemplarTexels, l.depthTexels,
            60 * l.normalDegrees, 100 * l.seamWrongShare, l.seamTexels, 100 * l.otherSheetShare, 100 * l.missingShare);
        text += line;
    }
    const ShellClamping& c = boundary.clamping;
    std::snprintf(line, sizeof line,
                  "thinner than wanted: %.2f %% of the surface by curvature, %.2f %% by thin parts, %.2f %% by turned "
                  "triangles, %.2f %% beside those; down to %.4g units\n",
                  100 * c.curvature, 100 * c.thinParts, 100 * c.turned, 100 * c.beside, double(c.lowest));
    text += line;
    const ShellGridReport& r = grid.report();
    std::snprintf(
        line, sizeof line,
        "seams %.4g units long, %zu rim edges (%.4g units), %zu edges of more than two triangles, %zu between "
        "opposite orientations%s\n",
        r.seamLength, r.rimEdges, r.rimLength, r.crowdedEdges, r.turnedEdges,
        r.insideOut ? "; the surface is inside out" : "");
    text += line;
    for (const auto& [stage, seconds] : run.seconds) {
        std::snprintf(line, sizeof line, "%s %.2f s, ", stage.c_str(), seconds);
        text += line;
    }
    std::snprintf(line, sizeof line, "grid %.1f MB, peak of the process %.1f MB\n", double(grid.memoryBytes()) / 1e6,
                  run.peakBytes / 1e6);
    return text + line;
}

} // namespace stf
