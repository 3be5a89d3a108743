// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/window.h"

#include "pxr/base/vt/value.h"
#include "pxr/imaging/hd/renderBuffer.h"
#include "pxr/pxr.h"

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfRenderBuffer
///
/// A CPU render buffer with two images: the render thread writes the back one, hosts read the front one. Map() brings
/// the newest finished image to the front unless somebody still has the front mapped, so that a mapped image neither
/// moves nor changes, and is always resolved: Resolve() has nothing to do.
///
/// Threading: Map, Unmap, Write, Clear and the convergence flag are thread-safe. Allocation (Sync, Finalize) goes
/// through the edit gate first.
class HdStfRenderBuffer final : public HdRenderBuffer {
public:
    explicit HdStfRenderBuffer(SdfPath const& id);
    ~HdStfRenderBuffer() override;

    void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* renderParam) override;

    /// Depth must be 1. A multi-sampled buffer is allocated like any other: what is written is resolved.
    bool Allocate(GfVec3i const& dimensions, HdFormat format, bool multiSampled) override;

    unsigned int GetWidth() const override { return _width; }
    unsigned int GetHeight() const override { return _height; }
    unsigned int GetDepth() const override { return 1; }
    HdFormat GetFormat() const override { return _format; }
    bool IsMultiSampled() const override { return _multiSampled; }

    void* Map() override;
    void Unmap() override;
    bool IsMapped() const override { return _mappers.load() > 0; }

    void Resolve() override {}

    /// True while nothing is being rendered into this buffer.
    bool IsConverged() const override { return _converged.load(); }
    void SetConverged(bool converged) { _converged.store(converged); }

    /// Fills the buffer with \p value (a number or a vector; empty: zeros).
    void Clear(VtValue const& value);
    /// The same where nothing was written since the last allocation, so that an edit does not make the image flash.
    void ClearIfUnwritten(VtValue const& value);

    /// Replaces the image: \p pixels holds \p channels values per pixel of \p window (in pixels of the buffer, rows
    /// from the bottom up); what lies outside is cropped, what is not covered becomes \p clearValue.
    void Write(std::vector<float> const& pixels, int channels, HdStfWindow const& window, VtValue const& clearValue);
    void Write(std::vector<int32_t> const& pixels, int channels, HdStfWindow const& window, VtValue const& clearValue);

private:
    void _Deallocate() override;
    template<class T>
    void _WriteBack(std::vector<T> const& pixels, int channels, HdStfWindow const& window, VtValue const& clearValue);
    void _ClearBack(VtValue const& value);

    unsigned int _width = 0;
    unsigned int _height = 0;
    HdFormat _format = HdFormatInvalid;
    bool _multiSampled = false;

    mutable std::mutex _mutex; // guards the two images and their flags
    std::vector<uint8_t> _front;
    std::vector<uint8_t> _back;
    bool _backIsNewer = false;
    bool _unwritten = true;

    std::atomic<int> _mappers{0};
    std::atomic<bool> _converged{false};
};

/// The components of a clear value, missing ones as 0; the number of components given.
size_t HdStfClearComponents(VtValue const& value, float components[4]);

PXR_NAMESPACE_CLOSE_SCOPE
