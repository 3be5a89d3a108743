// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_raw.h"

#include "stfLib/acquire/gz_file.h"
#include "stfLib/acquire/scan_byte_order.h"

#include <filesystem>

namespace stf {

namespace {

std::uint64_t blockBytes(const RawLayout& l) {
    return std::uint64_t(l.size.x) * std::uint64_t(l.size.y) * std::uint64_t(l.size.z) * bytesOf(l.type);
}

bool compressed(const std::string& path) {
    return std::filesystem::path(path).extension() == ".gz";
}

class VoxelBlock : public ScanReader {
public:
    VoxelBlock(const std::string& path, const RawLayout& layout, const ScanHeader& header)
        : path_(path), layout_(layout) {
        header_ = header;
        header_.size = layout.size;
        header_.type = layout.type;
    }

    std::uint64_t bufferBytes(const VoxelBox& box) const override {
        return std::uint64_t(box.size().y) * std::uint64_t(layout_.size.x) * bytesOf(layout_.type);
    }

    std::vector<float> read(const VoxelBox& box, Progress& progress) const override {
        const Vec3i size = box.size();
        const std::size_t bytes = bytesOf(layout_.type), row = std::size_t(layout_.size.x) * bytes;
        std::vector<unsigned char> layer(std::size_t(size.y) * row);
        std::vector<float> values(std::size_t(box.voxelCount()));
        GzFile file(path_);
        for (int z = box.lo.z; z < box.hi.z; ++z) {
            const std::uint64_t offset =
                layout_.headerBytes +
                (std::uint64_t(z) * std::uint64_t(layout_.size.y) + std::uint64_t(box.lo.y)) * row;
            const std::uint64_t got = file.read(offset, layer.data(), layer.size());
            if (got < layer.size()) {
                throw Error(path_ + ": ends at byte " + std::to_string(offset + got) + ", in layer " +
                            std::to_string(z) + " of " + std::to_string(layout_.size.z) + "; " +
                            sizeText(layout_.size) + " voxels of " + nameOf(layout_.type) + " need " +
                            std::to_string(layout_.headerBytes + blockBytes(layout_)));
            }
            if (z == (box.lo.z + box.hi.z) / 2) {
                checkByteOrder(layer, std::size_t(size.y));
            }
            for (int y = 0; y < size.y; ++y) {
                const std::size_t to =
                    (std::size_t(z - box.lo.z) * std::size_t(size.y) + std::size_t(y)) * std::size_t(size.x);
                decodeValues(layer.data() + std::size_t(y) * row + std::size_t(box.lo.x) * bytes, layout_.type,
                             layout_.bigEndian, std::size_t(size.x), values.data() + to);
            }
            progress.update("read", double(z + 1 - box.lo.z) / size.z);
        }
        return values;
    }

private:
    void checkByteOrder(const std::vector<unsigned char>& layer, std::size_t rows) const {
        if (looksByteSwapped(layer.data(), layout_.type, layout_.bigEndian, std::size_t(layout_.size.x), rows)) {
            const char *now = layout_.bigEndian ? "big" : "little", *other = layout_.bigEndian ? "little" : "big";
            throw Error(path_ + ": voxels look like " + nameOf(layout_.type) + " in " + other +
                        "-endian order, but are read as " + now + "-endian" +
                        (header_.format == "raw" ? std::string(" (--endian ") + other + ", or another --type)"
                                                 : std::string(", as the header says")));
        }
    }

    std::string path_;
    RawLayout layout_;
};

} // namespace

std::unique_ptr<ScanReader> openVoxelBlock(const std::string& path, const RawLayout& layout, const ScanHeader& header) {
    if (minComponent(layout.size) >= 1 && maxComponent(layout.size) <= (1 << 20) && !compressed(path)) {
        const std::uint64_t needed = layout.headerBytes + blockBytes(layout);
        const std::uint64_t there = std::filesystem::file_size(path);
        if (there < needed) {
            throw Error("ends at byte " + std::to_string(there) + ", but " + sizeText(layout.size) + " voxels of " +
                        nameOf(layout.type) + " behind a header of " + std::to_string(layout.headerBytes) +
                        " bytes need " + std::to_string(needed));
        }
    }
    return std::make_unique<VoxelBlock>(path, layout, header);
}

std::unique_ptr<ScanReader> openRaw(const std::string& path, const RawLayout& layout, const MessageSink& messages) {
    if (std::filesystem::is_directory(path)) {
        throw Error("a folder cannot be read as one raw file");
    }
    ScanHeader header;
    header.format = "raw";
    auto reader = openVoxelBlock(path, layout, header);
    if (!compressed(path) && minComponent(layout.size) >= 1) {
        const std::uint64_t needed = layout.headerBytes + blockBytes(layout);
        const std::uint64_t there = std::filesystem::file_size(path);
        if (there > needed) {
            report(messages, Severity::Warning,
                   std::to_string(there - needed) + " bytes are left over behind " + sizeText(layout.size) +
                       " voxels of " + nameOf(layout.type) + ": are --dims, --type and --header-bytes right?");
        }
    }
    return reader;
}

} // namespace stf
