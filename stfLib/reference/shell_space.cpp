// SPDX-License-Identifier: Apache-2.0
#include "stfLib/reference/shell_space.h"

namespace stf {

bool ShellSpace::locate(const Vec3f& point, Vec3f& mm) {
    if (ShellLookup found; probe_.lookup(point, found)) {
        at_ = found;
        point_ = point;
        known_ = true;
    } else if (!known_) {
        return false;
    }
    const Vec3f d = point - point_;
    mm = {at_.exemplar.x + dot(at_.gradX, d), at_.exemplar.y + dot(at_.gradY, d),
          at_.depth - dot(at_.normal, d) * mmPerUnit_};
    return true;
}

} // namespace stf
