// SPDX-License-Identifier: Apache-2.0
#include "fuzz_session.h"

#include "scene_difference.h"

#include "pxr/imaging/hd/rprim.h"
#include "pxr/imaging/hd/tokens.h"
#include "pxr/usd/usdGeom/mesh.h"

#include <cmath>
#include <cstring>
#include <sstream>

PXR_NAMESPACE_USING_DIRECTIVE

namespace fuzz {

namespace {

const char* const firstStage = R"(#usda 1.0
def Camera "Camera" {
    float focalLength = 40
    float horizontalAperture = 36
    float verticalAperture = 24
    float2 clippingRange = (0.1, 100)
    matrix4d xformOp:transform = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 9, 1))
    uniform token[] xformOpOrder = ["xformOp:transform"]
}
def Camera "Camera2" {
    float focalLength = 40
    float horizontalAperture = 36
    float verticalAperture = 24
    float2 clippingRange = (0.1, 100)
    matrix4d xformOp:transform = ((1, 0, 0, 0), (0, 0.8, -0.6, 0), (0, 0.6, 0.8, 0), (0, 5, 7, 1))
    uniform token[] xformOpOrder = ["xformOp:transform"]
}
def Scope "Looks" {
    def Material "Paint" {
        token outputs:surface.connect = </Looks/Paint/Surface.outputs:surface>
        def Shader "Surface" {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0.6, 0.3, 0.2)
            token outputs:surface
        }
    }
}
def Xform "World" {
    def DistantLight "Key" {
        float intensity = 2
        float inputs:intensity = 2
        float angle = 0
        float inputs:angle = 0
        matrix4d xformOp:transform = ((1, 0, 0, 0), (0, 0.8, -0.6, 0), (0, 0.6, 0.8, 0), (0, 0, 0, 1))
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }
    def Mesh "Floor" {
        uniform token subdivisionScheme = "none"
        int[] faceVertexCounts = [4, 4]
        int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4]
        point3f[] points = [(-3, -2, -1), (0, -2, -1), (3, -2, -1), (-3, 2, -1), (0, 2, -1), (3, 2, -1)]
        color3f[] primvars:displayColor = [(0.3, 0.4, 0.7)] ( interpolation = "constant" )
    }
    def Mesh "Ball" {
        int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
        int[] faceVertexIndices = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5]
        point3f[] points = [(-1, -1, -1), (1, -1, -1), (-1, 1, -1), (1, 1, -1),
                            (-1, -1, 1), (1, -1, 1), (-1, 1, 1), (1, 1, 1)]
        matrix4d xformOp:transform = ((1, 0, 0, 0), (0, 0.8, -0.6, 0), (0, 0.6, 0.8, 0), (0, 0, 0, 1))
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }
}
def Scope "Library" {
    class Xform "Thing" {
        def Mesh "Geo" {
            uniform token subdivisionScheme = "none"
            int[] faceVertexCounts = [4, 4]
            int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4]
            point3f[] points = [(0, 0, 0), (0.5, 0, 0), (1, 0, 0), (0, 1, 0.3), (0.5, 1, 0), (1, 1, 0)]
        }
    }
}
)";

template<class T>
std::string compareValues(const std::vector<T>& a, const std::vector<T>& b) {
    if (a.size() != b.size()) {
        return std::to_string(a.size()) + " values, " + std::to_string(b.size());
    }
    std::size_t differing = 0, first = 0;
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (std::memcmp(&a[i], &b[i], sizeof(T)) != 0) {
            first = differing++ == 0 ? i : first;
            most = std::max(most, std::abs(double(a[i]) - double(b[i])));
        }
    }
    if (differing == 0) {
        return {};
    }
    std::ostringstream text;
    text << differing << " of " << a.size() << " values differ, by up to " << most << "; the first is value " << first
         << ": " << a[first] << ", " << b[first];
    return text.str();
}

template<class T>
std::vector<T> values(HdStfRenderBuffer& buffer) {
    const auto* data = static_cast<const T*>(buffer.Map());
    std::vector<T> result(data, data + std::size_t(buffer.GetWidth()) * buffer.GetHeight() *
                                           HdGetComponentCount(buffer.GetFormat()));
    buffer.Unmap();
    return result;
}

/// Prims by name: what number a prim has goes by when it came.
std::vector<std::string> primNames(TestHost& host, const std::vector<int>& ids, const HostNames& hostNames) {
    std::vector<std::string> names;
    for (const int id : ids) {
        names.push_back(id < 0 ? std::string()
                               : nameInFirst(hostNames, host.index().GetRprimPathFromPrimId(id).GetString()));
    }
    return names;
}

std::string compareNames(const std::vector<std::string>& a, const std::vector<std::string>& b) {
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        if (a[i] != b[i]) {
            return "pixel " + std::to_string(i) + " shows \"" + a[i] + "\", \"" + b[i] + "\"";
        }
    }
    return a.size() == b.size() ? std::string() : "different sizes";
}

std::string compareAov(const std::string& aov, TestHost& a, TestHost& b) {
    HdStfRenderBuffer &p = *a.buffer(aov), &q = *b.buffer(aov);
    if (p.GetFormat() != q.GetFormat() || p.GetWidth() != q.GetWidth() || p.GetHeight() != q.GetHeight()) {
        return "another format or size";
    }
    const HostNames names = hostNames(a.delegate->GetScene(), b.delegate->GetScene());
    if (aov == "primId") {
        return compareNames(primNames(a, values<int>(p), {}), primNames(b, values<int>(q), names));
    }
    if (HdGetComponentFormat(p.GetFormat()) == HdFormatInt32) {
        return compareValues(values<int>(p), values<int>(q));
    }
    // Meshes are rendered in the order of their names: with others, light between shells is drawn by other lots.
    return names.empty() ? compareValues(values<float>(p), values<float>(q)) : std::string();
}

} // namespace

Session::Session(Sabotage sabotage) : sabotage_(sabotage) {
    const SdfLayerRefPtr layer = SdfLayer::CreateAnonymous(".usda");
    TF_AXIOM(layer->ImportFromString(firstStage));
    stage = UsdStage::Open(layer);
    UsdGeomMesh ball(stage->GetPrimAtPath(SdfPath("/World/Ball")));
    ball.GetPrim()
        .CreateAttribute(TfToken("primvars:stf:baseVolume"), SdfValueTypeNames->Asset)
        .Set(SdfAssetPath(files.volume(0)));
    view.tags = {HdRenderTagTokens->geometry, HdRenderTagTokens->render};
    view.aovs = {"color", "depth", "primId"};
    view.settings[TfToken("stf:samples")] = VtValue(2);
    view.settings[TfToken("stf:quality")] = VtValue(0.3f);
    view.settings[TfToken("stf:maxDepth")] = VtValue(0);
    makeHost();
}

Session::~Session() {
    if (held_) {
        held_->Unmap();
    }
}

void Session::makeHost() {
    live_ = std::make_unique<TestHost>(stage);
    live_->setOutputs({}, view.width, view.height);
    live_->beforeSync = [this] { applySabotage(); };
    paused_ = stopped_ = false;
}

void Session::replaceHost() {
    if (held_) {
        held_->Unmap();
        held_ = nullptr;
    }
    instancersSeen_.clear();
    makeHost();
    execute();
}

void Session::show(TestHost& host) const {
    host.setCamera(view.camera);
    host.setTime(view.time);
    host.setRenderTags(view.tags);
    host.scene().setRefineLevelFallback(view.refineFallback);
    for (const auto& [path, level] : view.refine) {
        host.scene().setRefineLevel(path, level);
    }
    host.changeOutputs(view.aovs, view.width, view.height, view.frameWidth, view.frameHeight);
    for (const auto& [key, value] : view.settings) {
        host.delegate->SetRenderSetting(key, value);
    }
}

void Session::execute() {
    if (held_ && (heldAov_ != view.aovs.front() || int(held_->GetWidth()) != view.width ||
                  int(held_->GetHeight()) != view.height)) {
        held_->Unmap();
        held_ = nullptr;
    }
    show(*live_);
    live_->execute();
}

void Session::renderToEnd() {
    execute();
    live_->renderToEnd();
}

void Session::pause() {
    paused_ = true;
    live_->delegate->Pause();
}

void Session::stop() {
    stopped_ = true;
    live_->delegate->Stop();
}

void Session::goOn() {
    if (paused_) {
        live_->delegate->Resume();
    }
    if (stopped_) {
        live_->delegate->Restart();
    }
    paused_ = stopped_ = false;
}

void Session::applySabotage() {
    HdRenderIndex& index = live_->index();
    HdChangeTracker& tracker = index.GetChangeTracker();
    if (sabotage_ == Sabotage::DirtyBit) {
        for (const SdfPath& id : index.GetRprimIds()) {
            const HdDirtyBits bits = tracker.GetRprimDirtyBits(id);
            if (!(bits & HdChangeTracker::NewRepr)) {
                tracker.MarkRprimClean(id, bits & ~HdDirtyBits(HdChangeTracker::DirtyPrimvar));
            }
        }
    }
    if (sabotage_ == Sabotage::Instancer) {
        for (const SdfPath& id : index.GetRprimIds()) {
            const SdfPath instancer = index.GetRprim(id)->GetInstancerId();
            if (!instancer.IsEmpty() && !instancersSeen_.insert(instancer).second) {
                tracker.MarkInstancerClean(instancer);
            }
        }
    }
}

std::string Session::compare() {
    goOn();
    execute();
    if (!live_->renderToEnd()) {
        return "  the image is not finished after a minute\n";
    }
    if (sabotage_ == Sabotage::Aov && !held_) {
        heldAov_ = view.aovs.front();
        held_ = live_->buffer(heldAov_);
        held_->Map();
    }
    TestHost fresh(stage);
    fresh.setOutputs({}, view.width, view.height);
    show(fresh);
    if (!fresh.renderToEnd()) {
        return "  the image of the new host is not finished after a minute\n";
    }
    std::string found;
    for (const std::string& aov : view.aovs) {
        if (const std::string what = compareAov(aov, *live_, fresh); !what.empty()) {
            found += "  AOV " + aov + ": " + what + "\n";
        }
    }
    if (const std::string what = sceneDifference(live_->delegate->GetScene(), fresh.delegate->GetScene());
        !what.empty()) {
        found += "  scene (followed, new):\n" + what;
    }
    return found;
}

} // namespace fuzz
