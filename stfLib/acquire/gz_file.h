// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <zlib.h>

// Private to the layer acquire: names a type of zlib.

namespace stf {

/// A file that is read at any place, unpacked where it is packed by gzip. Throws Error where it cannot be opened.
class GzFile {
public:
    explicit GzFile(const std::string& path) : file_(::gzopen(path.c_str(), "rb")) {
        if (!file_) {
            throw Error(path + ": cannot be opened");
        }
        ::gzbuffer(file_, 1 << 18);
        // Learns whether the file is packed: only then can it leap in one that is not.
        char first;
        (void)::gzread(file_, &first, 1);
    }
    ~GzFile() { ::gzclose(file_); }
    GzFile(const GzFile&) = delete;
    GzFile& operator=(const GzFile&) = delete;

    /// Reads from an offset of the unpacked file; returns how many bytes there were.
    std::uint64_t read(std::uint64_t offset, void* bytes, std::uint64_t count) {
        if (::gzseek(file_, z_off_t(offset), SEEK_SET) < 0) {
            return 0;
        }
        std::uint64_t done = 0;
        while (done < count) {
            const int n = ::gzread(file_, static_cast<unsigned char*>(bytes) + done,
                                   unsigned(std::min<std::uint64_t>(count - done, 1u << 30)));
            if (n <= 0) {
                break;
            }
            done += std::uint64_t(n);
        }
        return done;
    }

private:
    gzFile file_;
};

} // namespace stf
