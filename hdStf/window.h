// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/base/gf/vec4f.h"
#include "pxr/pxr.h"

#include <algorithm>
#include <cmath>

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

/// The pixels of a frame of \p width by \p height that a data window holds: x and y from, x and y to, as shares of the
/// frame from its lower left corner (USD's `dataWindowNDC`). Each edge goes to the nearest pixel; the window may reach
/// beyond the frame, and is empty where nothing lies between its edges.
inline HdStfWindow HdStfDataWindow(GfVec4f const& window, int width, int height) {
    const auto edge = [](float share, int size) { return static_cast<int>(std::lround(double(share) * size)); };
    const int x = edge(window[0], width);
    const int y = edge(window[1], height);
    return {x, y, std::max(0, edge(window[2], width) - x), std::max(0, edge(window[3], height) - y)};
}

PXR_NAMESPACE_CLOSE_SCOPE
