// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to stfLib's sources: names OpenVDB types.
#include "stfLib/base/openvdb_headers.h"

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace stf {

/// A .vdb file whose grids are read one by one when asked for. It is a stream as openvdb::io::Stream writes it, so that
/// any tool reads it as a whole; behind the last grid, where those stop, stands an index: place, length and hash of the
/// metadata and of each grid. OpenVDB trusts the lengths in a file: here it is handed bytes whose hash agrees, and
/// nothing beyond their end.
class IndexedVdb {
public:
    /// Makes a grid; called once, in order, so that one grid at a time is in memory.
    using MakeGrid = std::function<openvdb::GridBase::Ptr()>;

    /// Writes beside the target and renames. Grids have different names, without spaces. Throws Error with a message
    /// that starts with the path.
    static void write(const std::string& path, const openvdb::MetaMap& metadata, const std::vector<MakeGrid>& grids);

    /// Reads index and metadata. Throws Error with a message that starts with the path.
    explicit IndexedVdb(const std::string& path);

    const openvdb::MetaMap& metadata() const { return metadata_; }
    bool has(const std::string& name) const { return index_.count(name) > 0; }
    std::size_t fileBytes() const { return std::size_t(fileBytes_); }
    /// Opens the file again and reads one grid. Throws Error with a message that starts with the path where the file is
    /// gone, damaged or another one by now. Thread-safe. OpenVDB may run parallel loops in it (see Lazy).
    openvdb::GridBase::Ptr grid(const std::string& name) const;

private:
    struct Range {
        std::uint64_t offset = 0, length = 0;
        std::string hash;
    };

    std::string path_;
    std::uint64_t fileBytes_ = 0;
    std::string prefix_; ///< first bytes of the file: versions
    openvdb::MetaMap metadata_;
    std::map<std::string, Range> index_;
};

} // namespace stf
