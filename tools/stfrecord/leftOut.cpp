// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/leftOut.h"

#include "pxr/base/tf/stringUtils.h"
#include "pxr/imaging/hd/tokens.h"
#include "pxr/usd/usd/primRange.h"
#include "pxr/usd/usd/typed.h"
#include "pxr/usd/usdGeom/bboxCache.h"
#include "pxr/usd/usdGeom/curves.h"
#include "pxr/usd/usdGeom/imageable.h"
#include "pxr/usd/usdGeom/points.h"

#include <algorithm>
#include <map>

namespace stfrecord {

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

struct Kind {
    const char* name;
    TfToken type; // of Hydra
    int count = 0;
    SdfPath first;
    GfRange3d bounds;
};

std::string text(const GfVec3d& v) {
    return TfStringPrintf("(%g, %g, %g)", v[0], v[1], v[2]);
}

} // namespace

std::vector<std::string> describeLeftOut(const UsdStagePtr& stage, const TfTokenVector& drawnTypes,
                                         const std::vector<std::string>& purposes, UsdTimeCode time) {
    TfTokenVector included;
    for (const std::string& purpose : purposes) {
        included.emplace_back(purpose);
    }
    UsdGeomBBoxCache boxes(time, included);
    Kind kinds[] = {{"curves", HdPrimTypeTokens->basisCurves, 0, {}, {}},
                    {"points", HdPrimTypeTokens->points, 0, {}, {}},
                    {"volumes", HdPrimTypeTokens->volume, 0, {}, {}}};
    std::map<TfToken, Kind> unknown; // types without a schema, as those of usdSkel where OpenUSD is built without it
    for (const UsdPrim& prim : stage->Traverse(UsdTraverseInstanceProxies())) {
        if (!prim.GetTypeName().IsEmpty() && !prim.IsA<UsdTyped>()) {
            Kind& type = unknown[prim.GetTypeName()];
            if (type.count++ == 0) {
                type.first = prim.GetPath();
            }
            continue;
        }
        Kind* kind = prim.IsA<UsdGeomCurves>()        ? &kinds[0]
                     : prim.IsA<UsdGeomPoints>()      ? &kinds[1]
                     : prim.GetTypeName() == "Volume" ? &kinds[2]
                                                      : nullptr;
        if (!kind || std::find(drawnTypes.begin(), drawnTypes.end(), kind->type) != drawnTypes.end()) {
            continue;
        }
        const UsdGeomImageable imageable(prim);
        if (imageable.ComputeVisibility(time) == UsdGeomTokens->invisible ||
            std::find(included.begin(), included.end(), imageable.ComputePurpose()) == included.end()) {
            continue;
        }
        if (kind->count++ == 0) {
            kind->first = prim.GetPath();
        }
        if (kind == &kinds[2]) {
            kind->bounds.UnionWith(boxes.ComputeWorldBound(prim).ComputeAlignedRange());
        }
    }
    std::vector<std::string> sentences;
    for (const Kind& kind : kinds) {
        if (kind.count == 0) {
            continue;
        }
        std::string sentence = std::string("the renderer draws no ") + kind.name + ": " + std::to_string(kind.count) +
                               (kind.count == 1 ? " prim is" : " prims are") + " left out, the first is " +
                               kind.first.GetString();
        if (!kind.bounds.IsEmpty()) {
            sentence += "; all lie in " + text(kind.bounds.GetMin()) + " to " + text(kind.bounds.GetMax());
        } else if (kind.type == HdPrimTypeTokens->volume) {
            sentence += "; they say no extent";
        }
        sentences.push_back(sentence);
    }
    for (const auto& [type, kind] : unknown) {
        sentences.push_back("this OpenUSD has no schema for " + type.GetString() + ": " + std::to_string(kind.count) +
                            (kind.count == 1 ? " prim is" : " prims are") +
                            " left out with what is below, the first is " + kind.first.GetString());
    }
    return sentences;
}

} // namespace stfrecord
