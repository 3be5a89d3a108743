// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/indexed_vdb.h"

#include "stfLib/base/error.h"
#include "stfLib/volume/base_volume.h"
#include "stfLib/volume/vdb_dense.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <unistd.h>

namespace stf {

namespace {

namespace fs = std::filesystem;

// A stream of OpenVDB: versions (of fixed length), metadata, the number of grids, grids one after the other. Bytes of
// one grid after the versions of its file, no metadata and the number 1 are a stream again.
struct Stream {
    std::string versions, metadata, grids;
};

constexpr std::size_t kCount = sizeof(std::int32_t);

std::string number(std::int32_t n) {
    std::string bytes(kCount, '\0');
    std::memcpy(bytes.data(), &n, kCount);
    return bytes;
}

std::string serialize(const openvdb::GridPtrVec& grids, const openvdb::MetaMap& metadata) {
    std::ostringstream out(std::ios::binary);
    openvdb::io::Stream(out).write(grids, metadata);
    return out.str();
}

// Length of the versions: a stream of nothing holds two more numbers, of metadata and of grids.
std::size_t versionsLength() {
    return serialize({}, {}).size() - 2 * kCount;
}

// Parts of the index that are no grids; the number of grids is counted to the metadata.
constexpr const char* kVersions = "(versions)";
constexpr const char* kMetadata = "(metadata)";

// The last bytes of the file.
struct Footer {
    char mark[8] = {'s', 't', 'f', 'i', 'n', 'd', 'e', 'x'};
    std::uint64_t offset = 0; ///< of the index
    char hash[32] = {};       ///< of the index
};
static_assert(sizeof(Footer) == 48, "it is written as it lies in memory");

constexpr auto kThrowing = std::ios::failbit | std::ios::badbit | std::ios::eofbit;

std::string readRange(const std::string& path, std::uint64_t offset, std::uint64_t length) {
    std::error_code error;
    const std::uint64_t size = fs::file_size(path, error);
    if (error) {
        throw Error(fs::exists(path) ? "it is not a file" : "no such file");
    }
    // Before anything is allocated.
    if (offset > size || length > size - offset) {
        throw Error("it is shorter than it was");
    }
    std::ifstream in(path, std::ios::binary);
    if (!in) {
        throw Error("it cannot be opened");
    }
    in.exceptions(kThrowing);
    std::string bytes(std::size_t(length), '\0');
    in.seekg(std::streamoff(offset));
    in.read(bytes.data(), std::streamsize(length));
    return bytes;
}

// The bytes of a stream as OpenVDB's objects, by way of a stream that throws at its end.
struct Parsed {
    openvdb::GridPtrVecPtr grids;
    openvdb::MetaMap::Ptr metadata;
};
Parsed parse(const std::string& bytes) {
    std::istringstream in(bytes, std::ios::binary);
    in.exceptions(kThrowing);
    openvdb::io::Stream stream(in, false);
    return {stream.getGrids(), stream.getMetadata()};
}

} // namespace

void IndexedVdb::write(const std::string& path, const openvdb::MetaMap& metadata, const std::vector<MakeGrid>& grids) {
    initializeOpenVdb();
    static std::atomic<unsigned> writes{0};
    const fs::path temporary = path + "." + std::to_string(::getpid()) + "." + std::to_string(writes++) + ".tmp";
    try {
        if (fs::path(path).has_parent_path()) {
            fs::create_directories(fs::path(path).parent_path());
        }
        std::ofstream out;
        out.exceptions(std::ios::failbit | std::ios::badbit);
        out.open(temporary, std::ios::binary | std::ios::trunc);
        std::ostringstream index;
        std::uint64_t offset = 0;
        const auto append = [&](const std::string& name, const char* bytes, std::size_t length) {
            const std::string part(bytes, length);
            out.write(part.data(), std::streamsize(length));
            index << name << ' ' << offset << ' ' << length << ' ' << contentHashOf(part) << '\n';
            offset += length;
        };
        const std::size_t versions = versionsLength();
        std::string head = serialize({}, metadata);
        head.replace(head.size() - kCount, kCount, number(std::int32_t(grids.size())));
        append(kVersions, head.data(), versions);
        append(kMetadata, head.data() + versions, head.size() - versions);
        for (const MakeGrid& make : grids) {
            const openvdb::GridBase::Ptr grid = make();
            const std::string bytes = serialize({grid}, {});
            const std::size_t before = versions + 2 * kCount;
            append(grid->getName(), bytes.data() + before, bytes.size() - before);
        }
        const std::string lines = index.str(), hash = contentHashOf(lines);
        Footer footer;
        footer.offset = offset;
        std::memcpy(footer.hash, hash.data(), std::min(hash.size(), sizeof footer.hash));
        out.write(lines.data(), std::streamsize(lines.size()));
        out.write(reinterpret_cast<const char*>(&footer), sizeof footer);
        out.close();
        fs::rename(temporary, path);
    } catch (const std::exception& e) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw Error(path + ": cannot be written (" + e.what() + ")");
    }
}

IndexedVdb::IndexedVdb(const std::string& path) : path_(path) {
    initializeOpenVdb();
    try {
        std::error_code error;
        fileBytes_ = fs::file_size(path, error);
        fileBytes_ = error ? 0 : fileBytes_;
        Footer footer;
        const std::uint64_t tail = std::min<std::uint64_t>(fileBytes_, sizeof footer);
        const std::string last = readRange(path, fileBytes_ - tail, tail);
        const Footer expected;
        if (last.size() < sizeof footer || std::memcmp(last.data(), expected.mark, sizeof footer.mark) != 0) {
            throw Error("it has no index: it was cut off or is something else");
        }
        std::memcpy(&footer, last.data(), sizeof footer);
        const std::uint64_t end = fileBytes_ - sizeof footer;
        const std::string lines = footer.offset <= end ? readRange(path, footer.offset, end - footer.offset) : "";
        if (contentHashOf(lines) != std::string(footer.hash, sizeof footer.hash)) {
            throw Error("its index is damaged");
        }
        std::istringstream in(lines);
        Range range;
        for (std::string name; in >> name >> range.offset >> range.length >> range.hash;) {
            index_[name] = range;
        }
        const auto read = [&](const char* name) {
            const Range& r = index_[name];
            const std::string bytes = readRange(path, r.offset, r.length);
            if (contentHashOf(bytes) != r.hash) {
                throw Error("it is damaged");
            }
            index_.erase(name);
            return bytes;
        };
        prefix_ = read(kVersions);
        std::string head = prefix_ + read(kMetadata);
        if (head.size() < prefix_.size() + kCount) {
            throw Error("it is damaged");
        }
        head.replace(head.size() - kCount, kCount, number(0)); // no grids yet
        metadata_ = *parse(head).metadata;
    } catch (const std::exception& e) {
        throw Error(path + ": cannot be read (" + e.what() + ")");
    }
}

openvdb::GridBase::Ptr IndexedVdb::grid(const std::string& name) const {
    try {
        const auto entry = index_.find(name);
        if (entry == index_.end()) {
            throw Error("grid '" + name + "' is missing");
        }
        const Range& range = entry->second;
        std::string bytes = readRange(path_, range.offset, range.length);
        if (contentHashOf(bytes) != range.hash) {
            throw Error("it is damaged, or another one by now");
        }
        bytes.insert(0, prefix_ + number(0) + number(1));
        const Parsed parsed = parse(bytes);
        if (parsed.grids->size() != 1 || !parsed.grids->front() || parsed.grids->front()->getName() != name) {
            throw Error("grid '" + name + "' is not where it should be");
        }
        return parsed.grids->front();
    } catch (const std::exception& e) {
        throw Error(path_ + ": cannot be read (" + e.what() + ")");
    }
}

} // namespace stf
