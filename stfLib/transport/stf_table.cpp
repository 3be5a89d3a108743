// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/stf_table.h"

#include <cmath>

namespace stf {

double TableError::total() const {
    return std::sqrt(noise * noise + directions * directions + truncation * truncation + filter * filter +
                     storage * storage);
}

std::size_t StfTable::bytes() const {
    if (headerBytes > 0) {
        return headerBytes;
    }
    std::size_t sum = (reflectedBelow.size() + emittedBelow.size() + reflectedAbove.size()) * sizeof(Rgb);
    for (const Lazy<FactoredField>* part : {&multiple, &single, &backlight, &emitted, &transmitted, &direct}) {
        sum += part->get().bytes();
    }
    return sum;
}

} // namespace stf
