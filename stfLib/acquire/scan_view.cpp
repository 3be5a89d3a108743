// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_view.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace stf {

namespace {

constexpr const char* kAxes = "xyz";

int axisOf(const std::string& depth) {
    for (int a = 0; a < 3; ++a) {
        if (depth.size() == 2 && (depth[0] == '+' || depth[0] == '-') && depth[1] == kAxes[a]) {
            return a;
        }
    }
    throw Error("no axis '" + depth + "' (known: +x, -x, +y, -y, +z, -z)");
}

// One end of a range; its default where the text is empty.
double endOf(const std::string& text, double ifEmpty, const std::string& whole) {
    if (text.empty()) {
        return ifEmpty;
    }
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (*end != 0 || !std::isfinite(value)) {
        throw Error("crop '" + whole + "': '" + text + "' is no number");
    }
    return value;
}

} // namespace

Vec3i axesAlong(const std::string& depth) {
    const int a = axisOf(depth);
    return {(a + 1) % 3, (a + 2) % 3, a};
}

ScanView viewAlong(const Scan& scan, const std::string& depth) {
    const Vec3i axes = axesAlong(depth);
    const Vec3<std::ptrdiff_t> stride(1, scan.size.x, std::ptrdiff_t(scan.size.x) * scan.size.y);
    ScanView view;
    view.origin = scan.values.data();
    for (int k = 0; k < 3; ++k) {
        view.size[k] = scan.size[axes[k]];
        view.spacingMm[k] = scan.spacingMm[axes[k]];
        view.stride[k] = stride[axes[k]];
        if (depth[0] == '-' && k > 0) {
            view.origin += view.stride[k] * (view.size[k] - 1);
            view.stride[k] = -view.stride[k];
        }
    }
    return view;
}

VoxelBox parseCrop(const std::string& text, const Vec3i& size, const Vec3d& spacingMm) {
    VoxelBox box{Vec3i(0), size};
    std::size_t at = 0;
    for (int a = 0; a < 3 && !text.empty(); ++a) {
        const std::size_t comma = text.find(',', at);
        if ((comma == std::string::npos) != (a == 2)) {
            throw Error("crop '" + text + "' must have three parts: x0:x1,y0:y1,z0:z1");
        }
        std::string part = text.substr(at, comma == std::string::npos ? comma : comma - at);
        at = comma + 1;
        if (part.empty()) {
            continue;
        }
        double unit = 1;
        if (part.size() > 2 && part.compare(part.size() - 2, 2, "mm") == 0) {
            unit = spacingMm[a];
            part.resize(part.size() - 2);
        }
        const std::size_t colon = part.find(':');
        if (colon == std::string::npos) {
            throw Error("crop '" + text + "': '" + part + "' is no range a:b");
        }
        const double lo = std::round(endOf(part.substr(0, colon), 0, text) / unit);
        const double hi = std::round(endOf(part.substr(colon + 1), size[a] * unit, text) / unit);
        if (!(lo >= 0 && hi <= size[a] && lo < hi)) {
            const auto whole = [](double v) { return std::to_string((long long)(std::clamp(v, -1e15, 1e15))); };
            throw Error("crop '" + text + "': voxels " + whole(lo) + " to " + whole(hi) + " along " + kAxes[a] +
                        " are empty or outside of 0 to " + std::to_string(size[a]));
        }
        box.lo[a] = int(lo);
        box.hi[a] = int(hi);
    }
    return box;
}

} // namespace stf
