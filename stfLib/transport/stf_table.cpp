// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/stf_table.h"

namespace stf {

std::size_t StfTable::bytes() const {
    return (multiple.size() + transmitted.size() + direct.size()) * sizeof(float) +
           (backlight.size() + reflectedBelow.size()) * sizeof(Rgb);
}

} // namespace stf
