// SPDX-License-Identifier: Apache-2.0
#include "hdStf/motionSamples.h"

#include "hdStf/hydraCompat.h"

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

#if HDSTF_HAS_SAMPLING_INTERVAL
#define HDSTF_SAMPLE(method)                                                                                           \
    sceneDelegate->method(id, static_cast<float>(shutter.open), static_cast<float>(shutter.close), capacity, times,    \
                          matrices)
#else
#define HDSTF_SAMPLE(method) sceneDelegate->method(id, capacity, times, matrices)
#endif

HdStfMatrixSamples HdStfSampleTransform(HdSceneDelegate* sceneDelegate, SdfPath const& id,
                                        [[maybe_unused]] stf::Shutter const& shutter) {
    return _Collect([&](size_t capacity, float* times, GfMatrix4d* matrices) { return HDSTF_SAMPLE(SampleTransform); });
}

HdStfMatrixSamples HdStfSampleInstancerTransform(HdSceneDelegate* sceneDelegate, SdfPath const& id,
                                                 [[maybe_unused]] stf::Shutter const& shutter) {
    return _Collect(
        [&](size_t capacity, float* times, GfMatrix4d* matrices) { return HDSTF_SAMPLE(SampleInstancerTransform); });
}

PXR_NAMESPACE_CLOSE_SCOPE
