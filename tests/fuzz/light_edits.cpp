// SPDX-License-Identifier: Apache-2.0
#include "edit_tools.h"

#include "hdStf/hydraCompat.h"

#include "pxr/usd/sdf/assetPath.h"

#include <algorithm>
#include <array>

PXR_NAMESPACE_USING_DIRECTIVE

namespace fuzz {

namespace {

/// Lights by type name: their classes differ from version to version.
std::vector<UsdPrim> lights(const Session& s, const char* type = nullptr) {
    static const std::array<const char*, 6> types = {"DistantLight", "DomeLight", "SphereLight",
                                                     "DiskLight",    "RectLight", "CylinderLight"};
    std::vector<UsdPrim> found;
    for (const UsdPrim& prim : s.stage->Traverse()) {
        const std::string& name = prim.GetTypeName().GetString();
        if (type ? name == type : std::find(types.begin(), types.end(), name) != types.end()) {
            found.push_back(prim);
        }
    }
    return found;
}

std::string attributeName(const std::string& name) {
    return HDSTF_LIGHT_PARAMS_ARE_ATTRIBUTES ? name : "inputs:" + name;
}

std::string addLight(Session& s, Random& r) {
    const SdfPath path = freePath(s, "/World", "Light", r);
    if (path.IsEmpty() || lights(s).size() > 4) {
        return {};
    }
    const TfToken type(r.of({"DistantLight", "DomeLight", "SphereLight", "DiskLight", "RectLight", "CylinderLight"}));
    const UsdPrim light = s.stage->DefinePrim(path, type);
    light.CreateAttribute(TfToken(attributeName("intensity")), SdfValueTypeNames->Float).Set(r.of({0.5f, 2.0f}));
    placeAt(light, randomPlace(r), UsdTimeCode::Default());
    return "add " + path.GetString() + ", a " + type.GetString();
}

template<class Value>
std::function<std::string(Session&, Random&)> number(const char* name, Value value) {
    return [name, value](Session& s, Random& r) {
        UsdPrim light = anyOf(lights(s), r);
        return light ? setAttribute(light, attributeName(name), SdfValueTypeNames->Float, VtValue(float(value(r))), r)
                     : std::string();
    };
}

std::string setExtent(Session& s, Random& r) {
    UsdPrim light = anyOf(lights(s), r);
    return light ? setAttribute(light, attributeName(r.of({"radius", "width", "height", "length", "angle"})),
                                SdfValueTypeNames->Float, VtValue(r.of({0.25f, 0.5f, 1.0f, 2.0f})), r)
                 : std::string();
}

std::string setFlag(Session& s, Random& r) {
    UsdPrim light = anyOf(lights(s), r);
    return light ? setAttribute(light, attributeName(r.of({"normalize", "enableColorTemperature", "shadow:enable"})),
                                SdfValueTypeNames->Bool, VtValue(r.chance(0.5)), r, false)
                 : std::string();
}

std::string setShaping(Session& s, Random& r) {
    UsdPrim light = anyOf(lights(s), r);
    return light ? setAttribute(light,
                                attributeName(r.of({"shaping:focus", "shaping:cone:angle", "shaping:cone:softness"})),
                                SdfValueTypeNames->Float, VtValue(r.of({0.0f, 0.5f, 40.0f})), r, false)
                 : std::string();
}

std::string setColor(Session& s, Random& r) {
    UsdPrim light = anyOf(lights(s), r);
    return light ? setAttribute(light, attributeName("color"), SdfValueTypeNames->Color3f, VtValue(r.vec(0, 1)), r)
                 : std::string();
}

std::string setTexture(Session& s, Random& r) {
    UsdPrim light = anyOf(lights(s, r.chance(0.7) ? "DomeLight" : "RectLight"), r);
    if (!light) {
        return {};
    }
    const std::string name = attributeName("texture:file");
    if (light.GetAttribute(TfToken(name)).HasAuthoredValue() && r.chance(0.3)) {
        light.RemoveProperty(TfToken(name));
        return "remove " + light.GetPath().GetString() + "." + name;
    }
    return setAttribute(light, name, SdfValueTypeNames->Asset,
                        VtValue(SdfAssetPath(r.chance(0.15) ? "missing.ppm" : s.files.image(r.below(s.files.images)))),
                        r, false);
}

} // namespace

void addLightEdits(EditKinds& kinds) {
    kinds.push_back({"light: add", 3, addLight});
    kinds.push_back({"light: remove", 1, [](Session& s, Random& r) { return removePrim(s, anyOf(lights(s), r)); }});
    kinds.push_back({"light: rename", 1, [](Session& s, Random& r) { return renamePrim(s, anyOf(lights(s), r), r); }});
    kinds.push_back({"light: intensity", 2, number("intensity", [](Random& r) { return r.of({0.0f, 0.5f, 2.0f}); })});
    kinds.push_back({"light: exposure", 1, number("exposure", [](Random& r) { return r.of({-1.0f, 0.0f, 1.0f}); })});
    kinds.push_back({"light: colour temperature", 1,
                     number("colorTemperature", [](Random& r) { return 3000 + 1000 * r.below(5); })});
    kinds.push_back({"light: colour", 2, setColor});
    kinds.push_back({"light: extent", 3, setExtent});
    kinds.push_back({"light: flags", 2, setFlag});
    kinds.push_back({"light: shaping", 2, setShaping});
    kinds.push_back({"light: texture", 2, setTexture});
}

} // namespace fuzz
