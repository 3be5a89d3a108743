// SPDX-License-Identifier: Apache-2.0
#include "hdStf/primvars.h"

#include "pxr/imaging/hd/extComputationUtils.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

VtVec3fArray HdStfPullPoints(SdfPath const& id, HdSceneDelegate* sceneDelegate) {
    HdExtComputationPrimvarDescriptorVector computed;
    for (auto const& primvar : sceneDelegate->GetExtComputationPrimvarDescriptors(id, HdInterpolationVertex)) {
        if (primvar.name == HdTokens->points) {
            computed.push_back(primvar);
        }
    }
    VtValue value;
    if (!computed.empty()) {
        auto values = HdExtComputationUtils::GetComputedPrimvarValues(computed, sceneDelegate);
        value = values[HdTokens->points];
    } else {
        value = sceneDelegate->Get(id, HdTokens->points);
    }
    VtVec3fArray points;
    if (!value.IsEmpty()) {
        HdStfAsArray(value, &points);
    }
    return points;
}

PXR_NAMESPACE_CLOSE_SCOPE
