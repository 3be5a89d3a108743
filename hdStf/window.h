// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// A rectangle of pixels in a render buffer, rows counted from the bottom up. (GfRect2i changed its interface on the
/// way from 20.08.)
struct HdStfWindow {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;
    bool IsEmpty() const { return width <= 0 || height <= 0; }
    bool operator==(HdStfWindow const& w) const {
        return x == w.x && y == w.y && width == w.width && height == w.height;
    }
};

PXR_NAMESPACE_CLOSE_SCOPE
