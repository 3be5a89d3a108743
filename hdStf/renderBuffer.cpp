// SPDX-License-Identifier: Apache-2.0
#include "hdStf/renderBuffer.h"

#include "hdStf/renderParam.h"

#include "pxr/base/gf/half.h"
#include "pxr/base/gf/vec2f.h"
#include "pxr/base/gf/vec3f.h"
#include "pxr/base/gf/vec3i.h"
#include "pxr/base/gf/vec4f.h"
#include "pxr/base/tf/diagnostic.h"
#include "pxr/imaging/hd/types.h"

#include <algorithm>
#include <cmath>
#include <cstring>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

float _Clamp(float value, float low, float high) {
    return value > low ? std::min(value, high) : low; // also turns NaN into `low`
}

/// Stores one component of a pixel in the buffer's component format.
template<class T>
void _Store(HdFormat component, uint8_t* pixel, size_t index, T value) {
    switch (component) {
    case HdFormatUNorm8:
        pixel[index] = static_cast<uint8_t>(std::lround(_Clamp(static_cast<float>(value), 0.0f, 1.0f) * 255.0f));
        break;
    case HdFormatSNorm8:
        pixel[index] = static_cast<uint8_t>(
            static_cast<int8_t>(std::lround(_Clamp(static_cast<float>(value), -1.0f, 1.0f) * 127.0f)));
        break;
    case HdFormatFloat16: {
        const uint16_t bits = GfHalf(static_cast<float>(value)).bits();
        std::memcpy(pixel + 2 * index, &bits, sizeof(bits));
        break;
    }
    case HdFormatFloat32: {
        const float real = static_cast<float>(value);
        std::memcpy(pixel + 4 * index, &real, sizeof(real));
        break;
    }
    case HdFormatInt32: {
        const int32_t integer = static_cast<int32_t>(value);
        std::memcpy(pixel + 4 * index, &integer, sizeof(integer));
        break;
    }
    default:
        break;
    }
}

bool _CanStore(HdFormat format) {
    switch (HdGetComponentFormat(format)) {
    case HdFormatUNorm8:
    case HdFormatSNorm8:
    case HdFormatFloat16:
    case HdFormatFloat32:
    case HdFormatInt32:
        return true;
    default:
        return false;
    }
}

} // namespace

size_t HdStfClearComponents(VtValue const& value, float components[4]) {
    std::fill(components, components + 4, 0.0f);
    const auto copy = [components](auto const& vector) {
        for (size_t i = 0; i < vector.dimension; ++i) {
            components[i] = static_cast<float>(vector[i]);
        }
        return size_t(vector.dimension);
    };
    if (value.IsEmpty()) {
        return 0;
    }
    if (value.CanCast<GfVec4f>()) {
        return copy(VtValue::Cast<GfVec4f>(value).UncheckedGet<GfVec4f>());
    }
    if (value.CanCast<GfVec3f>()) {
        return copy(VtValue::Cast<GfVec3f>(value).UncheckedGet<GfVec3f>());
    }
    if (value.CanCast<GfVec2f>()) {
        return copy(VtValue::Cast<GfVec2f>(value).UncheckedGet<GfVec2f>());
    }
    if (value.CanCast<float>()) {
        const VtValue number = VtValue::Cast<float>(value);
        components[0] = number.UncheckedGet<float>(); // of a temporary it would be moved from, which compilers warn of
        return 1;
    }
    return 0;
}

HdStfRenderBuffer::HdStfRenderBuffer(SdfPath const& id) : HdRenderBuffer(id) {}

HdStfRenderBuffer::~HdStfRenderBuffer() = default;

void HdStfRenderBuffer::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) {
    if (*dirtyBits & DirtyDescription) {
        static_cast<HdStfRenderParam*>(renderParam)->AcquireSceneForEdit();
    }
    HdRenderBuffer::Sync(sceneDelegate, renderParam, dirtyBits);
}

void HdStfRenderBuffer::Finalize(HdRenderParam* renderParam) {
    static_cast<HdStfRenderParam*>(renderParam)->ForgetBuffer(this);
    HdRenderBuffer::Finalize(renderParam);
}

void HdStfRenderBuffer::_Deallocate() {
    std::lock_guard<std::mutex> lock(_mutex);
    TF_VERIFY(_mappers.load() == 0, "render buffer %s is released while mapped", GetId().GetText());
    _width = 0;
    _height = 0;
    _format = HdFormatInvalid;
    _multiSampled = false;
    _front = {};
    _back = {};
    _backIsNewer = false;
    _converged.store(false);
}

bool HdStfRenderBuffer::Allocate(GfVec3i const& dimensions, HdFormat format, bool multiSampled) {
    if (IsMapped()) {
        TF_WARN("render buffer %s cannot be resized while it is mapped", GetId().GetText());
        return false;
    }
    _Deallocate();
    if (dimensions[0] < 0 || dimensions[1] < 0 || dimensions[2] != 1 || !_CanStore(format)) {
        TF_WARN("render buffer %s cannot have size %d x %d x %d and format %d", GetId().GetText(), dimensions[0],
                dimensions[1], dimensions[2], static_cast<int>(format));
        return false;
    }
    std::lock_guard<std::mutex> lock(_mutex);
    _width = static_cast<unsigned int>(dimensions[0]);
    _height = static_cast<unsigned int>(dimensions[1]);
    _format = format;
    _multiSampled = multiSampled;
    _front.assign(size_t(_width) * _height * HdDataSizeOfFormat(format), 0);
    _unwritten = true;
    return true;
}

void* HdStfRenderBuffer::Map() {
    std::lock_guard<std::mutex> lock(_mutex);
    if (_mappers.fetch_add(1) == 0 && _backIsNewer) {
        _front.swap(_back);
        _backIsNewer = false;
    }
    return _front.data();
}

void HdStfRenderBuffer::Unmap() {
    if (!TF_VERIFY(_mappers.load() > 0)) {
        return;
    }
    --_mappers;
}

void HdStfRenderBuffer::_ClearBack(VtValue const& value) {
    const size_t stride = HdDataSizeOfFormat(_format);
    const size_t pixels = size_t(_width) * _height;
    _back.assign(pixels * stride, 0);
    float components[4];
    const size_t given = HdStfClearComponents(value, components);
    if (given == 0 || pixels == 0) {
        return;
    }
    const HdFormat component = HdGetComponentFormat(_format);
    const size_t count = HdGetComponentCount(_format);
    for (size_t c = 0; c < count; ++c) {
        _Store(component, _back.data(), c, components[c]);
    }
    for (size_t i = 1; i < pixels; ++i) {
        std::memcpy(_back.data() + i * stride, _back.data(), stride);
    }
}

void HdStfRenderBuffer::Clear(VtValue const& value) {
    std::lock_guard<std::mutex> lock(_mutex);
    _ClearBack(value);
    _backIsNewer = true;
}

void HdStfRenderBuffer::ClearIfUnwritten(VtValue const& value) {
    std::lock_guard<std::mutex> lock(_mutex);
    if (_unwritten) {
        _ClearBack(value);
        _backIsNewer = true;
    }
}

template<class T>
void HdStfRenderBuffer::_WriteBack(std::vector<T> const& pixels, int channels, HdStfWindow const& window,
                                   VtValue const& clearValue) {
    std::lock_guard<std::mutex> lock(_mutex);
    const int x0 = std::max(window.x, 0);
    const int y0 = std::max(window.y, 0);
    const int x1 = std::min(window.x + window.width, static_cast<int>(_width));
    const int y1 = std::min(window.y + window.height, static_cast<int>(_height));
    const bool covered = x0 == 0 && y0 == 0 && x1 == static_cast<int>(_width) && y1 == static_cast<int>(_height);
    const size_t stride = HdDataSizeOfFormat(_format);
    if (covered) {
        _back.resize(size_t(_width) * _height * stride);
    } else {
        _ClearBack(clearValue);
    }

    const HdFormat component = HdGetComponentFormat(_format);
    const int count = static_cast<int>(HdGetComponentCount(_format));
    const size_t sourceWidth = static_cast<size_t>(window.width);
    for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) {
            T const* source = pixels.data() + (size_t(y - window.y) * sourceWidth + size_t(x - window.x)) *
                                                  static_cast<size_t>(channels);
            uint8_t* target = _back.data() + (size_t(y) * _width + size_t(x)) * stride;
            for (int c = 0; c < count; ++c) {
                // A component that was not rendered is 0, an alpha that was not rendered is 1.
                _Store(component, target, static_cast<size_t>(c), c < channels ? source[c] : c == 3 ? T(1) : T(0));
            }
        }
    }
    _backIsNewer = true;
    _unwritten = false;
}

void HdStfRenderBuffer::Write(std::vector<float> const& pixels, int channels, HdStfWindow const& window,
                              VtValue const& clearValue) {
    _WriteBack(pixels, channels, window, clearValue);
}

void HdStfRenderBuffer::Write(std::vector<int32_t> const& pixels, int channels, HdStfWindow const& window,
                              VtValue const& clearValue) {
    _WriteBack(pixels, channels, window, clearValue);
}

PXR_NAMESPACE_CLOSE_SCOPE
