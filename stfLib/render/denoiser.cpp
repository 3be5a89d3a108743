// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/denoiser.h"

#include "stfLib/base/error.h"

#include <cstdlib>
#include <memory>

#include <dlfcn.h>

namespace stf {

namespace {

// The C interface of Open Image Denoise, as far as it is the same from 1.0 to 2.x; handles are opaque there too.
constexpr int kCpuDevice = 1; // OIDN_DEVICE_TYPE_CPU: takes memory of ours in every version
constexpr int kFloat3 = 3;    // OIDN_FORMAT_FLOAT3
using Device = void*;
using Filter = void*;

struct Library {
    Device (*newDevice)(int) = nullptr;
    void (*commitDevice)(Device) = nullptr;
    int (*getDeviceError)(Device, const char**) = nullptr;
    void (*releaseDevice)(Device) = nullptr;
    Filter (*newFilter)(Device, const char*) = nullptr;
    void (*setImage)(Filter, const char*, void*, int, std::size_t, std::size_t, std::size_t, std::size_t,
                     std::size_t) = nullptr;
    void (*setBool)(Filter, const char*, bool) = nullptr;
    void (*commitFilter)(Filter) = nullptr;
    void (*executeFilter)(Filter) = nullptr;
    void (*releaseFilter)(Filter) = nullptr;
    std::string missing; ///< why it cannot be used; empty: it can
};

template<class F>
bool find(void* handle, const char* name, F& function) {
    function = reinterpret_cast<F>(dlsym(handle, name));
    return function != nullptr;
}

Library load() {
    Library l;
    const char* const given = std::getenv("HDSTF_OIDN_LIBRARY");
    void* handle = nullptr;
    std::string problem;
    const std::vector<std::string> usual = {
#ifdef __APPLE__
        "libOpenImageDenoise.2.dylib", "libOpenImageDenoise.1.dylib", "libOpenImageDenoise.dylib"
#else
        "libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1", "libOpenImageDenoise.so"
#endif
    };
    for (const std::string& name : given&&* given ? std::vector<std::string>{given} : usual) {
        // Never closed again: its threads may outlive any user of it.
        handle = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
        if (handle) {
            break;
        }
        const char* const error = dlerror();
        problem = error ? error : name;
    }
    if (!handle) {
        l.missing = given && *given ? "Open Image Denoise (HDSTF_OIDN_LIBRARY) cannot be loaded: " + problem
                                    : "Open Image Denoise is not installed (HDSTF_OIDN_LIBRARY may name its library)";
        return l;
    }
    const bool whole =
        find(handle, "oidnNewDevice", l.newDevice) && find(handle, "oidnCommitDevice", l.commitDevice) &&
        find(handle, "oidnGetDeviceError", l.getDeviceError) && find(handle, "oidnReleaseDevice", l.releaseDevice) &&
        find(handle, "oidnNewFilter", l.newFilter) && find(handle, "oidnSetSharedFilterImage", l.setImage) &&
        (find(handle, "oidnSetFilterBool", l.setBool) || find(handle, "oidnSetFilter1b", l.setBool)) &&
        find(handle, "oidnCommitFilter", l.commitFilter) && find(handle, "oidnExecuteFilter", l.executeFilter) &&
        find(handle, "oidnReleaseFilter", l.releaseFilter);
    if (!whole) {
        l.missing = "the Open Image Denoise found is of a version that is not known";
    }
    return l;
}

const Library& library() {
    static const Library l = load();
    return l;
}

void throwIfFailed(const Library& l, Device device) {
    const char* message = nullptr;
    if (l.getDeviceError(device, &message) != 0) {
        throw Error(std::string("Open Image Denoise: ") + (message ? message : "an error without a message"));
    }
}

} // namespace

bool Denoiser::available(std::string* why) {
    if (why) {
        *why = library().missing;
    }
    return library().missing.empty();
}

std::vector<float> Denoiser::denoise(const DenoiserInput& input) {
    const Library& l = library();
    if (!l.missing.empty()) {
        throw Error(l.missing);
    }
    const std::size_t width = std::size_t(input.width), height = std::size_t(input.height), size = 3 * width * height;
    if (input.width < 0 || input.height < 0 || input.color.size() != size ||
        (!input.albedo.empty() && input.albedo.size() != size) ||
        (!input.normal.empty() && (input.normal.size() != size || input.albedo.empty()))) {
        throw Error("the images to be denoised have not the same size");
    }
    std::vector<float> out(size);
    if (size == 0) {
        return out;
    }
    const std::unique_ptr<void, void (*)(Device)> device(l.newDevice(kCpuDevice), l.releaseDevice);
    if (!device) {
        throw Error("Open Image Denoise does not run on this processor");
    }
    l.commitDevice(device.get());
    throwIfFailed(l, device.get());
    const std::unique_ptr<void, void (*)(Filter)> filter(l.newFilter(device.get(), "RT"), l.releaseFilter);
    throwIfFailed(l, device.get());
    const auto set = [&](const char* name, const std::vector<float>& image) {
        // One signature for images that are read and for the one that is written; strides 0: pixels are packed.
        l.setImage(filter.get(), name, const_cast<float*>(image.data()), kFloat3, width, height, 0, 0, 0);
    };
    set("color", input.color);
    if (!input.albedo.empty()) {
        set("albedo", input.albedo);
    }
    if (!input.normal.empty()) {
        set("normal", input.normal);
    }
    set("output", out);
    l.setBool(filter.get(), "hdr", true);
    l.commitFilter(filter.get());
    throwIfFailed(l, device.get());
    l.executeFilter(filter.get());
    throwIfFailed(l, device.get());
    return out;
}

} // namespace stf
