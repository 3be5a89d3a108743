// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/nifti_length.h"

#include "stfLib/acquire/gz_file.h"

#include <cstring>
#include <filesystem>

namespace stf {

namespace {

template<class T>
T fieldAt(const unsigned char* header, std::size_t offset, bool swapped) {
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, header + offset, sizeof(T));
    if (swapped) {
        std::reverse(bytes, bytes + sizeof(T));
    }
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
}

// Of a pair of files the one with the voxels.
std::string voxelFile(const std::string& path) {
    for (const char* ending : {".hdr", ".hdr.gz"}) {
        const std::size_t length = std::strlen(ending);
        if (path.size() > length && path.compare(path.size() - length, length, ending) == 0) {
            const std::string stem = path.substr(0, path.size() - length);
            return std::filesystem::exists(stem + ".img") ? stem + ".img" : stem + ".img.gz";
        }
    }
    return path;
}

} // namespace

void checkNiftiLength(const std::string& path) {
    constexpr std::size_t kHeader = 348;
    unsigned char header[kHeader];
    GzFile file(path);
    if (file.read(0, header, kHeader) < kHeader) {
        throw Error("ends within its header of " + std::to_string(kHeader) + " bytes");
    }
    // The first field is the header's length; another length is NIfTI-2, or no header at all.
    const bool swapped = fieldAt<std::int32_t>(header, 0, true) == std::int32_t(kHeader);
    if (!swapped && fieldAt<std::int32_t>(header, 0, false) != std::int32_t(kHeader)) {
        return;
    }
    double bytes = fieldAt<std::int16_t>(header, 72, swapped) / 8.0;
    const int dimensions = fieldAt<std::int16_t>(header, 40, swapped);
    for (int a = 1; a <= std::min(7, dimensions); ++a) {
        bytes *= std::max<int>(1, fieldAt<std::int16_t>(header, std::size_t(40 + 2 * a), swapped));
    }
    const std::string voxels = voxelFile(path);
    const double offset = double(fieldAt<float>(header, 108, swapped));
    const double end = bytes + (voxels == path ? std::max(352.0, offset) : std::max(0.0, offset));
    GzFile data(voxels);
    unsigned char last;
    if (bytes > 0 && end < 1e18 && data.read(std::uint64_t(end) - 1, &last, 1) < 1) {
        throw Error("ends before byte " + std::to_string(std::uint64_t(end)) + ", where its header has the last voxel" +
                    (voxels == path ? "" : " (" + std::filesystem::path(voxels).filename().string() + ")"));
    }
}

} // namespace stf
