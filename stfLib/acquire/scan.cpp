// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan.h"

#include <array>
#include <cstdio>

namespace stf {

namespace {

struct TypeRow {
    ScanType type;
    const char* name;
    std::size_t bytes;
};
constexpr std::array<TypeRow, 8> kTypes{{{ScanType::UInt8, "uint8", 1},
                                         {ScanType::Int8, "int8", 1},
                                         {ScanType::UInt16, "uint16", 2},
                                         {ScanType::Int16, "int16", 2},
                                         {ScanType::UInt32, "uint32", 4},
                                         {ScanType::Int32, "int32", 4},
                                         {ScanType::Float32, "float32", 4},
                                         {ScanType::Float64, "float64", 8}}};

} // namespace

std::size_t bytesOf(ScanType type) {
    return kTypes[std::size_t(type)].bytes;
}

const char* nameOf(ScanType type) {
    return kTypes[std::size_t(type)].name;
}

ScanType scanTypeOf(const std::string& name) {
    std::string known;
    for (const TypeRow& row : kTypes) {
        if (name == row.name) {
            return row.type;
        }
        known += std::string(known.empty() ? "" : ", ") + row.name;
    }
    throw Error("no voxel type '" + name + "' (known: " + known + ")");
}

std::string sizeText(const Vec3i& size) {
    return std::to_string(size.x) + " x " + std::to_string(size.y) + " x " + std::to_string(size.z);
}

std::string bytesText(double bytes) {
    char text[40];
    const bool giga = bytes >= 1e9;
    std::snprintf(text, sizeof text, "%.*f %s", bytes < 1e7 || giga ? 1 : 0, bytes / (giga ? 1e9 : 1e6),
                  giga ? "GB" : "MB");
    return text;
}

} // namespace stf
