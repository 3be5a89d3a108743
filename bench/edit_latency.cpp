// SPDX-License-Identifier: Apache-2.0
// How long a host waits after an edit until it can show something new, and until the whole first pass is there: the
// delegate's own classes, a stage, edits of its camera and of a light. Prints a line of JSON.

#include "tests/hydra/test_host.h"

#include "pxr/usd/usd/attribute.h"
#include "pxr/usd/usdGeom/xformCommonAPI.h"
#include "pxr/usd/usdLux/distantLight.h"

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <thread>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

using Clock = std::chrono::steady_clock;

struct Arguments {
    std::string scene, camera = "/World/Camera", light = "/World/Key";
    int width = 620, height = 775, rounds = 8;
};

double since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What the buffer shows, as a host sees it.
class Shown {
public:
    explicit Shown(HdStfRenderBuffer& buffer) : buffer_(buffer) { take(); }
    /// Whether it has changed since the last time; that it was allocated does not count.
    bool changed() {
        const bool same = size() == last_.size();
        const void* now = buffer_.Map();
        const bool other = same && std::memcmp(now, last_.data(), last_.size()) != 0;
        buffer_.Unmap();
        if (other || !same) {
            take();
        }
        return other;
    }

private:
    std::size_t size() const {
        return std::size_t(buffer_.GetWidth()) * buffer_.GetHeight() * HdDataSizeOfFormat(buffer_.GetFormat());
    }
    void take() {
        const auto* now = static_cast<const unsigned char*>(buffer_.Map());
        last_.assign(now, now + size());
        buffer_.Unmap();
    }

    HdStfRenderBuffer& buffer_;
    std::vector<unsigned char> last_;
};

/// Seconds from an edit to the first new picture, and to the end of the first pass over all pixels.
nlohmann::ordered_json timeOf(TestHost& host, int rounds, const std::function<void(int)>& edit) {
    std::vector<double> first, whole;
    for (int i = 0; i < rounds; ++i) {
        Shown shown(*host.buffer("color"));
        const Clock::time_point start = Clock::now();
        edit(i);
        host.execute();
        while (!shown.changed()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        first.push_back(since(start));
        while (!host.converged()) { // of one sample
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            host.execute();
        }
        whole.push_back(since(start));
    }
    std::sort(first.begin(), first.end());
    std::sort(whole.begin(), whole.end());
    return {{"firstMs", 1e3 * first[first.size() / 2]},
            {"firstMostMs", 1e3 * first.back()},
            {"wholeMs", 1e3 * whole[whole.size() / 2]}};
}

nlohmann::ordered_json run(const Arguments& a) {
    const UsdStageRefPtr stage = UsdStage::Open(a.scene);
    if (!stage) {
        throw std::runtime_error(a.scene + " cannot be opened");
    }
    TestHost host(stage);
    host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(1));
    host.setOutputs({"color"}, a.width, a.height);
    host.setCamera(a.camera);
    nlohmann::ordered_json j;
    const Clock::time_point start = Clock::now();
    {
        Shown shown(*host.buffer("color"));
        host.execute();
        while (!shown.changed()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        j["loadFirstMs"] = 1e3 * since(start);
        while (!host.converged()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            host.execute();
        }
        j["loadWholeMs"] = 1e3 * since(start);
    }
    const UsdPrim camera = stage->GetPrimAtPath(SdfPath(a.camera)), light = stage->GetPrimAtPath(SdfPath(a.light));
    UsdGeomXformOp moves = UsdGeomXformable(camera).AddTranslateOp(UsdGeomXformOp::PrecisionDouble, TfToken("bench"));
    UsdGeomXformOp turns = UsdGeomXformable(light).AddRotateYOp(UsdGeomXformOp::PrecisionFloat, TfToken("bench"));
    j["camera"] = timeOf(host, a.rounds, [&](int i) { moves.Set(GfVec3d(0.01 * (i + 1), 0, 0)); });
    j["light"] = timeOf(host, a.rounds, [&](int i) { turns.Set(float(i + 1)); });
    return j;
}

} // namespace

int main(int argc, char** argv) {
    Arguments a;
    CLI::App app("Milliseconds from an edit to the first new picture", "stf_bench_edits");
    app.add_option("scene", a.scene, "A stage with shells")->required();
    app.add_option("--camera", a.camera, "Its path");
    app.add_option("--light", a.light, "That of a light");
    app.add_option("--width", a.width, "Of the picture, pixels");
    app.add_option("--height", a.height, "The same");
    app.add_option("--rounds", a.rounds, "Edits of each kind")->check(CLI::Range(1, 1000));
    CLI11_PARSE(app, argc, argv);
    try {
        std::puts(run(a).dump().c_str());
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stf_bench_edits: %s\n", e.what());
        return 2;
    }
}
