// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/map_io.h"

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>

namespace stf {

namespace {

const char kTitle[24] = "hdStf exemplar map 1\n";
constexpr std::uint32_t kByteOrder = 0x01020304;

struct Header {
    char title[24];
    std::uint32_t byteOrder, descriptionBytes;
    std::uint64_t corners;
    double tileMm[2];
};

template<class T>
std::streamsize bytesOf(const std::vector<T>& values) {
    return std::streamsize(values.size() * sizeof(T));
}

} // namespace

void writeExemplarMap(const ExemplarMap& map, const std::string& path) {
    Header h{};
    std::memcpy(h.title, kTitle, sizeof kTitle);
    h.byteOrder = kByteOrder;
    h.descriptionBytes = std::uint32_t(map.description.size());
    h.corners = map.cornerCoords.size();
    h.tileMm[0] = map.tileMm.x;
    h.tileMm[1] = map.tileMm.y;
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(&h), sizeof h);
    out.write(map.description.data(), std::streamsize(map.description.size()));
    out.write(reinterpret_cast<const char*>(map.cornerCoords.data()), bytesOf(map.cornerCoords));
    out.write(reinterpret_cast<const char*>(map.gradientX.data()), bytesOf(map.gradientX));
    out.write(reinterpret_cast<const char*>(map.gradientY.data()), bytesOf(map.gradientY));
    out.close();
    if (!out) {
        throw Error(path + ": cannot be written (" + std::strerror(errno) + ")");
    }
}

ExemplarMap readExemplarMap(const std::string& path) {
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in) {
        throw Error(path + ": cannot be opened (" + std::strerror(errno) + ")");
    }
    const std::uint64_t size = std::uint64_t(in.tellg());
    in.seekg(0);
    Header h{};
    in.read(reinterpret_cast<char*>(&h), sizeof h);
    constexpr std::uint64_t perCorner = sizeof(Vec2f) + 2 * sizeof(Vec3f);
    if (!in || std::memcmp(h.title, kTitle, sizeof kTitle) != 0 || h.byteOrder != kByteOrder) {
        throw Error(path + ": is no exemplar map of this version");
    }
    // The length of the file bounds what its numbers may ask for.
    const std::uint64_t rest = size - sizeof h;
    if (h.descriptionBytes > rest || h.corners != (rest - h.descriptionBytes) / perCorner ||
        (rest - h.descriptionBytes) % perCorner != 0) {
        throw Error(path + ": has another length than its header says");
    }
    ExemplarMap map;
    map.tileMm = {h.tileMm[0], h.tileMm[1]};
    if (!(map.tileMm.x > 0 && map.tileMm.y > 0) || !std::isfinite(map.tileMm.x) || !std::isfinite(map.tileMm.y)) {
        throw Error(path + ": the size of its tile is not positive");
    }
    map.description.resize(h.descriptionBytes);
    map.cornerCoords.resize(std::size_t(h.corners));
    map.gradientX.resize(std::size_t(h.corners));
    map.gradientY.resize(std::size_t(h.corners));
    in.read(map.description.data(), std::streamsize(map.description.size()));
    in.read(reinterpret_cast<char*>(map.cornerCoords.data()), bytesOf(map.cornerCoords));
    in.read(reinterpret_cast<char*>(map.gradientX.data()), bytesOf(map.gradientX));
    in.read(reinterpret_cast<char*>(map.gradientY.data()), bytesOf(map.gradientY));
    if (!in) {
        throw Error(path + ": cannot be read to its end");
    }
    return map;
}

} // namespace stf
