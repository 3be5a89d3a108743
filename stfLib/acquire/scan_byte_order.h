// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan.h"

namespace stf {

/// Whether rows of stored values are far more plausible in the other byte order: integers when neighbours differ by
/// much of the spread as read but little of it when swapped (or, in four bytes, when all are small), floats when many
/// are not finite or of absurd size as read and next to none when swapped. `bytes` holds rows * rowLength values;
/// `bigEndian` tells how they are read now.
bool looksByteSwapped(const unsigned char* bytes, ScanType type, bool bigEndian, std::size_t rowLength,
                      std::size_t rows);

/// Stored values to float.
void decodeValues(const unsigned char* bytes, ScanType type, bool bigEndian, std::size_t count, float* out);

} // namespace stf
