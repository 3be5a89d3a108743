// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace stf {

/// What a file held when it was whole: kept in a small text file beside it, to find out before use whether a disk, a
/// copy or a crash changed a bit.
struct Seal {
    std::string checksum; ///< XXH3, 128 bits, of all bytes, in hexadecimal
    std::uint64_t bytes = 0;
    std::string key; ///< what the file was made from
};

/// The seal of an open file as it is now, from its first byte. Throws Error where it cannot be read.
Seal sealOf(int fd, const std::string& key);

/// Empty where the file is missing or not a seal.
std::optional<Seal> readSeal(const std::string& path);
/// Throws Error.
void writeSeal(const Seal& seal, const std::string& path);

} // namespace stf
