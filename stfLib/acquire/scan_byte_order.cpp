// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_byte_order.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace stf {

namespace {

// The machine's order is little on every platform that this builds for.
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "decode() takes little-endian machines for granted");

template<class T, class Out>
void decode(const unsigned char* bytes, bool bigEndian, std::size_t count, Out* out) {
    for (std::size_t i = 0; i < count; ++i, bytes += sizeof(T)) {
        unsigned char swapped[sizeof(T)];
        T value;
        if (bigEndian && sizeof(T) > 1) {
            std::reverse_copy(bytes, bytes + sizeof(T), swapped);
            std::memcpy(&value, swapped, sizeof(T));
        } else {
            std::memcpy(&value, bytes, sizeof(T));
        }
        out[i] = Out(value);
    }
}

bool absurd(double v) {
    return !std::isfinite(v) || std::abs(v) > 1e20 || (v != 0 && std::abs(v) < 1e-20);
}

double absurdShare(const unsigned char* bytes, ScanType type, bool bigEndian, std::size_t count) {
    std::vector<double> values(count);
    if (type == ScanType::Float64) {
        decode<double>(bytes, bigEndian, count, values.data());
    } else {
        decode<float>(bytes, bigEndian, count, values.data());
    }
    return double(std::count_if(values.begin(), values.end(), absurd)) / double(count);
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

// How many different upper bytes numbers of two bytes have.
std::size_t upperBytes(const std::vector<float>& values) {
    bool seen[256] = {};
    for (const float v : values) {
        seen[(int(v) >> 8) & 255] = true;
    }
    return std::size_t(std::count(std::begin(seen), std::end(seen), true));
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
    if (type == ScanType::Float32 || type == ScanType::Float64) {
        return absurdShare(bytes, type, bigEndian, count) > 0.1 && absurdShare(bytes, type, !bigEndian, count) < 0.01;
    }
    std::vector<float> asRead(count), swapped(count);
    decodeValues(bytes, type, bigEndian, count, asRead.data());
    decodeValues(bytes, type, !bigEndian, count, swapped.data());
    // Small numbers in four bytes are multiples of 65536 when they are turned round.
    const auto multiple = [](float v) { return std::abs(v) >= 65536 && std::fmod(v, 65536.0f) == 0; };
    const auto small = [](float v) { return std::abs(v) < 65536; };
    if (bytesOf(type) == 4 && std::any_of(asRead.begin(), asRead.end(), multiple) &&
        std::all_of(asRead.begin(), asRead.end(), [&](float v) { return v == 0 || multiple(v); }) &&
        std::all_of(swapped.begin(), swapped.end(), small)) {
        return true;
    }
    const double rough = roughness(asRead, rowLength), smooth = roughness(swapped, rowLength);
    if (smooth < 0 || rough < 0) {
        return false;
    }
    // Without noise both are smooth; but of two bytes the lower one takes more different values.
    return (rough > 0.4 && smooth < rough / 3) ||
           (bytesOf(type) == 2 && smooth < rough / 1.5 && upperBytes(asRead) > 3 * upperBytes(swapped));
}

} // namespace stf
