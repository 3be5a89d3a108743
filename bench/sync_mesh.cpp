// SPDX-License-Identifier: Apache-2.0
// How long a delegate takes to take in a large mesh without a shell: the host's first call with it, which syncs, and
// the whole first picture. Any delegate that the host finds (PXR_PLUGINPATH_NAME), so that two can be compared. Prints
// a line of JSON.

#include "tools/stfrecord/host.h"

#include "pxr/usd/usdGeom/camera.h"
#include "pxr/usd/usdGeom/mesh.h"
#include "pxr/usd/usdGeom/xformCommonAPI.h"
#include "pxr/usd/usdLux/distantLight.h"

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

struct Arguments {
    std::string renderer = "Stf", scheme = "none";
    int edge = 1000, width = 64;
};

/// Seconds of the clock, and of the processor in all threads.
struct Times {
    std::chrono::steady_clock::time_point wall = std::chrono::steady_clock::now();
    std::clock_t cpu = std::clock();

    nlohmann::ordered_json since() const {
        return {{"wall", std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count()},
                {"cpu", double(std::clock() - cpu) / CLOCKS_PER_SEC}};
    }
};

/// A wavy sheet of edge * edge quads over the unit square.
void addSheet(const UsdStageRefPtr& stage, const Arguments& a, float phase) {
    const int n = a.edge;
    VtVec3fArray points;
    points.reserve(std::size_t(n + 1) * std::size_t(n + 1));
    for (int y = 0; y <= n; ++y) {
        for (int x = 0; x <= n; ++x) {
            const float u = float(x) / float(n), v = float(y) / float(n);
            points.push_back(GfVec3f(u, v, 0.05f * std::sin(20 * u + phase) * std::cos(17 * v)));
        }
    }
    UsdGeomMesh mesh = UsdGeomMesh::Define(stage, SdfPath("/Sheet"));
    mesh.CreatePointsAttr().Set(points);
    if (mesh.GetFaceVertexCountsAttr().HasAuthoredValue()) {
        return;
    }
    VtIntArray counts(std::size_t(n) * std::size_t(n), 4), indices;
    indices.reserve(4 * counts.size());
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            const int i = y * (n + 1) + x;
            for (const int corner : {i, i + 1, i + n + 2, i + n + 1}) {
                indices.push_back(corner);
            }
        }
    }
    mesh.CreateFaceVertexCountsAttr().Set(counts);
    mesh.CreateFaceVertexIndicesAttr().Set(indices);
    mesh.CreateSubdivisionSchemeAttr().Set(TfToken(a.scheme));
}

nlohmann::ordered_json pictured(stfrecord::Host& host, double frame) {
    const Times start;
    nlohmann::ordered_json out;
    host.render(SdfPath("/Camera"), UsdTimeCode(frame), [&] {
        if (out.is_null()) {
            out["sync"] = start.since();
        }
        return true;
    });
    if (out.is_null()) {
        out["sync"] = start.since();
    }
    out["picture"] = start.since();
    return out;
}

nlohmann::ordered_json run(const Arguments& a) {
    std::vector<std::string> available;
    stfrecord::registerPlugins();
    const TfToken plugin = stfrecord::findRenderer(a.renderer, available);
    if (plugin.IsEmpty()) {
        throw std::runtime_error("no renderer " + a.renderer);
    }
    const UsdStageRefPtr stage = UsdStage::CreateInMemory();
    addSheet(stage, a, 0);
    UsdGeomCamera camera = UsdGeomCamera::Define(stage, SdfPath("/Camera"));
    UsdGeomXformCommonAPI(camera).SetTranslate(GfVec3d(0.5, 0.5, 3));
    UsdLuxDistantLight::Define(stage, SdfPath("/Sun"));
    stfrecord::Host host(stage, plugin);
    host.delegate().SetRenderSetting(TfToken("stf:samples"), VtValue(1));
    host.delegate().SetRenderSetting(TfToken("convergedSamplesPerPixel"), VtValue(1));
    host.delegate().SetRenderSetting(TfToken("enableInteractive"), VtValue(false));
    host.populate({"default"}, 0, false);
    host.setOutputs({"color"}, a.width, a.width, HdStfWindow{0, 0, a.width, a.width});
    nlohmann::ordered_json j{{"renderer", a.renderer}, {"quads", a.edge * a.edge}, {"scheme", a.scheme}};
    j["load"] = pictured(host, 0);
    addSheet(stage, a, 1);
    j["points"] = pictured(host, 0); // all of them move
    return j;
}

} // namespace

int main(int argc, char** argv) {
    Arguments a;
    CLI::App app("Seconds in which a delegate takes in a large mesh", "stf_bench_sync");
    app.add_option("--renderer", a.renderer, "Its name, or that of its plugin");
    app.add_option("--edge", a.edge, "Quads along an edge of the mesh")->check(CLI::Range(1, 10000));
    app.add_option("--scheme", a.scheme, "Of subdivision; complexity is low");
    app.add_option("--width", a.width, "Of the picture, pixels")->check(CLI::Range(1, 10000));
    CLI11_PARSE(app, argc, argv);
    try {
        std::puts(run(a).dump().c_str());
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stf_bench_sync: %s\n", e.what());
        return 2;
    }
}
