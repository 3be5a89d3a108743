// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_byte_order.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace stf {

namespace {

// The machine's order is little on every platform that this builds for.
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "decode() takes little-endian machines for granted");

template<class T>
void decode(const unsigned char* bytes, bool bigEndian, std::size_t count, float* out) {
    for (std::size_t i = 0; i < count; ++i, bytes += sizeof(T)) {
        unsigned char swapped[sizeof(T)];
        T value;
        if (bigEndian && sizeof(T) > 1) {
            std::reverse_copy(bytes, bytes + sizeof(T), swapped);
            std::memcpy(&value, swapped, sizeof(T));
        } else {
            std::memcpy(&value, bytes, sizeof(T));
        }
        out[i] = float(value);
    }
}

bool absurd(float v) {
    return !std::isfinite(v) || std::abs(v) > 1e20f || (v != 0 && std::abs(v) < 1e-20f);
}

double absurdShare(const std::vector<float>& values) {
    return double(std::count_if(values.begin(), values.end(), absurd)) / double(values.size());
}

// Mean difference of neighbours in a row over the mean deviation from the mean: about 1 for noise, small for images;
// negative where all values are the same.
double roughness(const std::vector<float>& values, std::size_t rowLength) {
    double sum = 0;
    for (float v : values) {
        sum += double(v);
    }
    const double mean = sum / double(values.size());
    double deviation = 0, difference = 0;
    std::size_t pairs = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        deviation += std::abs(double(values[i]) - mean);
        if (i % rowLength + 1 < rowLength) {
            difference += std::abs(double(values[i + 1]) - double(values[i]));
            ++pairs;
        }
    }
    if (!(deviation > 0) || pairs == 0) {
        return -1;
    }
    return difference / double(pairs) / (deviation / double(values.size()));
}

} // namespace

void decodeValues(const unsigned char* bytes, ScanType type, bool bigEndian, std::size_t count, float* out) {
    switch (type) {
    case ScanType::UInt8:
        return decode<std::uint8_t>(bytes, bigEndian, count, out);
    case ScanType::Int8:
        return decode<std::int8_t>(bytes, bigEndian, count, out);
    case ScanType::UInt16:
        return decode<std::uint16_t>(bytes, bigEndian, count, out);
    case ScanType::Int16:
        return decode<std::int16_t>(bytes, bigEndian, count, out);
    case ScanType::UInt32:
        return decode<std::uint32_t>(bytes, bigEndian, count, out);
    case ScanType::Int32:
        return decode<std::int32_t>(bytes, bigEndian, count, out);
    case ScanType::Float32:
        return decode<float>(bytes, bigEndian, count, out);
    case ScanType::Float64:
        return decode<double>(bytes, bigEndian, count, out);
    }
}

bool looksByteSwapped(const unsigned char* bytes, ScanType type, bool bigEndian, std::size_t rowLength,
                      std::size_t rows) {
    const std::size_t count = rowLength * rows;
    if (bytesOf(type) == 1 || count < 64) {
        return false;
    }
    std::vector<float> asRead(count), swapped(count);
    decodeValues(bytes, type, bigEndian, count, asRead.data());
    decodeValues(bytes, type, !bigEndian, count, swapped.data());
    if (type == ScanType::Float32 || type == ScanType::Float64) {
        return absurdShare(asRead) > 0.1 && absurdShare(swapped) < 0.01;
    }
    const double rough = roughness(asRead, rowLength), smooth = roughness(swapped, rowLength);
    return rough > 0.4 && smooth >= 0 && smooth < rough / 3;
}

} // namespace stf
