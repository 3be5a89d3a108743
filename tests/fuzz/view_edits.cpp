// SPDX-License-Identifier: Apache-2.0
#include "edit_tools.h"

#include "hdStf/window.h"

#include "pxr/base/tf/stringUtils.h"
#include "pxr/imaging/hd/tokens.h"
#include "pxr/usd/usdGeom/camera.h"

#include <chrono>
#include <thread>

PXR_NAMESPACE_USING_DIRECTIVE

namespace fuzz {

namespace {

std::string setTime(Session& s, Random& r) {
    s.view.time = r.of({1.0, 1.5, 2.0, 3.0});
    return "time " + TfStringify(s.view.time);
}

UsdPrim camera(Session& s) {
    return s.stage->GetPrimAtPath(SdfPath(s.view.camera));
}

std::string moveCamera(Session& s, Random& r) {
    GfMatrix4d place(1);
    place.SetTranslate(GfVec3d(r.vec(-0.5f, 0.5f)) + GfVec3d(0, 0, 9));
    placeAt(camera(s), place, r.chance(0.3) ? UsdTimeCode(1 + r.below(3)) : UsdTimeCode::Default());
    return "move " + s.view.camera;
}

std::string setLens(Session& s, Random& r) {
    const std::string name = r.of({"focalLength", "fStop", "focusDistance", "horizontalAperture", "exposure"});
    const float value = name == "focalLength"          ? r.of({30.0f, 40.0f, 60.0f})
                        : name == "fStop"              ? r.of({0.0f, 0.5f})
                        : name == "horizontalAperture" ? r.of({24.0f, 36.0f})
                        : name == "exposure"           ? r.of({0.0f, 1.0f})
                                                       : r.of({5.0f, 9.0f});
    return setAttribute(camera(s), name, SdfValueTypeNames->Float, VtValue(value), r);
}

std::string setClipping(Session& s, Random& r) {
    return setAttribute(camera(s), "clippingRange", SdfValueTypeNames->Float2,
                        VtValue(GfVec2f(r.of({0.1f, 1.0f, 8.5f}), r.of({100.0f, 9.0f}))), r);
}

std::string setProjection(Session& s, Random& r) {
    return setAttribute(camera(s), "projection", SdfValueTypeNames->Token,
                        VtValue(r.of({UsdGeomTokens->perspective, UsdGeomTokens->orthographic})), r, false);
}

std::string setShutter(Session& s, Random& r) {
    const double close = r.of({0.0, 0.5, 1.0});
    for (const char* path : {"/Camera", "/Camera2"}) {
        s.stage->GetPrimAtPath(SdfPath(path))
            .CreateAttribute(TfToken("shutter:close"), SdfValueTypeNames->Double)
            .Set(close);
    }
    return "shutter open until " + TfStringify(close);
}

std::string switchCamera(Session& s, Random&) {
    s.view.camera = s.view.camera == "/Camera" ? "/Camera2" : "/Camera";
    return "look through " + s.view.camera;
}

std::string setTags(Session& s, Random& r) {
    s.view.tags = {HdRenderTagTokens->geometry};
    for (const TfToken& tag : {HdRenderTagTokens->render, HdRenderTagTokens->proxy, HdRenderTagTokens->guide}) {
        if (r.chance(0.4)) {
            s.view.tags.push_back(tag);
        }
    }
    std::string names;
    for (const TfToken& tag : s.view.tags) {
        names += " " + tag.GetString();
    }
    return "render tags" + names;
}

/// Of buffers and frame; the crop stays as it is.
void resize(View& view, int frameWidth, int frameHeight) {
    const auto crop = view.settings.find(TfToken("dataWindowNDC"));
    const GfVec4f part = crop == view.settings.end() ? GfVec4f(0, 0, 1, 1) : crop->second.UncheckedGet<GfVec4f>();
    const HdStfWindow window = HdStfDataWindow(part, frameWidth, frameHeight);
    view.frameWidth = frameWidth;
    view.frameHeight = frameHeight;
    view.width = window.width;
    view.height = window.height;
}

std::string setSize(Session& s, Random& r) {
    resize(s.view, r.of({48, 32, 17}), r.of({32, 24, 13}));
    return "a frame of " + std::to_string(s.view.frameWidth) + " x " + std::to_string(s.view.frameHeight);
}

std::string setCrop(Session& s, Random& r) {
    const GfVec4f part =
        r.chance(0.4) ? GfVec4f(0, 0, 1, 1)
                      : GfVec4f(r.between(-0.1f, 0.4f), r.between(0, 0.4f), r.between(0.6f, 1), r.between(0.6f, 1.1f));
    s.view.settings[TfToken("dataWindowNDC")] = VtValue(part);
    resize(s.view, s.view.frameWidth, s.view.frameHeight);
    return "data window " + TfStringify(part);
}

std::string setAovs(Session& s, Random& r) {
    s.view.aovs = {"color"};
    for (const char* aov :
         {"alpha", "depth", "cameraDepth", "normal", "Neye", "position", "albedo", "primId", "instanceId", "elementId",
          "sampleCount", "variance", "stf:single", "stf:multiple", "stf:core", "stf:reflection", "noSuchAov"}) {
        if (r.chance(0.35)) {
            s.view.aovs.push_back(aov);
        }
    }
    if (r.chance(0.2)) {
        std::reverse(s.view.aovs.begin(), s.view.aovs.end());
    }
    return "AOVs " + TfStringJoin(s.view.aovs, ", ");
}

std::string setSetting(Session& s, Random& r) {
    const auto set = [&](const char* key, const VtValue& value) {
        s.view.settings[TfToken(key)] = value;
        return std::string(key) + " = " + TfStringify(value);
    };
    switch (r.below(18)) {
    case 0:
        return set("stf:samples", VtValue(r.of({1, 2, 3})));
    case 1:
        return set("stf:seed", VtValue(r.below(3)));
    case 2:
    case 3:
        return set("stf:maxDepth", VtValue(r.of({0, 0, 0, 1, 3})));
    case 4:
        return set("stf:pixelFilter", VtValue(std::string(r.of({"box", "gaussian", "blackmanHarris"}))));
    case 5:
        return set("stf:pixelFilterWidth", VtValue(r.of({0.0f, 2.0f})));
    case 6:
        return set("stf:depthOfField", VtValue(r.chance(0.5)));
    case 7:
        return set("stf:motionBlur", VtValue(r.chance(0.5)));
    case 8:
        return set("stf:regularize", VtValue(r.chance(0.5)));
    case 9:
        return set("stf:indirectClamp", VtValue(r.of({0.0f, 0.2f})));
    case 10:
        return set("stf:irradianceCache", VtValue(r.chance(0.5)));
    case 11:
        return set("stf:threads", VtValue(r.of({0, 1, 3})));
    case 12:
        return set("stf:quality", VtValue(r.of({0.3f, 0.5f})));
    case 13:
        return set("stf:transport", VtValue(std::string(r.of({"dE1", "classic"}))));
    case 14:
        return set("stf:errorTarget", VtValue(r.of({0.0f, 0.2f})));
    case 15:
        return set("stf:integrator", VtValue(std::string(r.of({"stf", "stf", "stf", "stf", "reference"}))));
    case 16:
        // Is refused, and the value stays what it was.
        s.live().delegate->SetRenderSetting(TfToken("stf:pixelFilter"), VtValue(std::string("nonsense")));
        return std::string("stf:pixelFilter = nonsense");
    default:
        return set("stageMetersPerUnit", VtValue(r.of({0.01, 0.02})));
    }
}

} // namespace

void addViewEdits(EditKinds& kinds) {
    kinds.push_back({"time", 6, setTime});
    kinds.push_back({"camera: move", 4, moveCamera});
    kinds.push_back({"camera: lens", 3, setLens});
    kinds.push_back({"camera: clipping", 2, setClipping});
    kinds.push_back({"camera: projection", 1, setProjection});
    kinds.push_back({"camera: shutter", 2, setShutter});
    kinds.push_back({"camera: another one", 1, switchCamera});
    kinds.push_back({"host: render tags", 3, setTags});
    kinds.push_back({"host: size", 3, setSize});
    kinds.push_back({"host: crop", 3, setCrop});
    kinds.push_back({"host: AOVs", 5, setAovs});
    kinds.push_back({"host: settings", 10, setSetting});
    kinds.push_back({"host: pause", 1, [](Session& s, Random&) {
                         s.pause();
                         return std::string("pause");
                     }});
    kinds.push_back({"host: stop", 1, [](Session& s, Random&) {
                         s.stop();
                         return std::string("stop");
                     }});
    kinds.push_back({"host: resume, restart", 2, [](Session& s, Random&) {
                         s.goOn();
                         return std::string("go on");
                     }});
    kinds.push_back({"host: another delegate", 1, [](Session& s, Random&) {
                         s.replaceHost();
                         return std::string("another delegate");
                     }});
    kinds.push_back({"execute, go on at once", 25, [](Session& s, Random&) {
                         s.execute();
                         return std::string("execute");
                     }});
    kinds.push_back({"execute, go on in the middle", 10, [](Session& s, Random& r) {
                         s.execute();
                         const int wait = r.below(30);
                         std::this_thread::sleep_for(std::chrono::milliseconds(wait));
                         return "execute, wait for " + std::to_string(wait) + " ms";
                     }});
}

} // namespace fuzz
