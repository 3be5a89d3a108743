// SPDX-License-Identifier: Apache-2.0
#include "hdStf/motionSamples.h"

#include "pxr/imaging/hd/sceneDelegate.h"

#include <algorithm>
#include <cmath>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

template<class Sample>
HdStfMatrixSamples _Collect(Sample const& sample) {
    std::vector<float> times(16);
    std::vector<GfMatrix4d> matrices(times.size());
    size_t count = sample(times.size(), times.data(), matrices.data());
    if (count > times.size()) { // there are more
        times.resize(count);
        matrices.resize(count);
        count = std::min(count, sample(times.size(), times.data(), matrices.data()));
    }
    HdStfMatrixSamples result;
    for (size_t i = 0; i < count; ++i) {
        if (std::isfinite(times[i])) {
            result.emplace_back(times[i], matrices[i]);
        }
    }
    std::stable_sort(result.begin(), result.end(), [](auto const& a, auto const& b) { return a.first < b.first; });
    return result;
}

} // namespace

HdStfMatrixSamples HdStfSampleTransform(HdSceneDelegate* sceneDelegate, SdfPath const& id) {
    return _Collect([&](size_t capacity, float* times, GfMatrix4d* matrices) {
        return sceneDelegate->SampleTransform(id, capacity, times, matrices);
    });
}

HdStfMatrixSamples HdStfSampleInstancerTransform(HdSceneDelegate* sceneDelegate, SdfPath const& id) {
    return _Collect([&](size_t capacity, float* times, GfMatrix4d* matrices) {
        return sceneDelegate->SampleInstancerTransform(id, capacity, times, matrices);
    });
}

PXR_NAMESPACE_CLOSE_SCOPE
