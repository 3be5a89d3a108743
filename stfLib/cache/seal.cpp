// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/seal.h"

#include "stfLib/base/error.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>
#include <unistd.h>
#include <vector>
#include <xxhash.h>

namespace stf {

namespace {
const char* const kTitle = "hdStf seal 1";
}

Seal sealOf(int fd, const std::string& key) {
    const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(), XXH3_freeState);
    XXH3_128bits_reset(state.get());
    std::vector<char> block(std::size_t(1) << 20);
    Seal seal;
    seal.key = key;
    for (;;) {
        const ssize_t count = ::pread(fd, block.data(), block.size(), off_t(seal.bytes));
        if (count < 0 && errno == EINTR) {
            continue;
        }
        if (count < 0) {
            throw Error(std::string("cannot be read (") + std::strerror(errno) + ")");
        }
        if (count == 0) {
            break;
        }
        XXH3_128bits_update(state.get(), block.data(), std::size_t(count));
        seal.bytes += std::uint64_t(count);
    }
    const XXH128_hash_t hash = XXH3_128bits_digest(state.get());
    char text[33];
    std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    seal.checksum = text;
    return seal;
}

std::optional<Seal> readSeal(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    Seal seal;
    std::string title, numbers;
    if (!std::getline(in, title) || title != kTitle || !std::getline(in, numbers)) {
        return {};
    }
    if (!(std::istringstream(numbers) >> seal.checksum >> seal.bytes)) {
        return {};
    }
    seal.key.assign(std::istreambuf_iterator<char>(in), {});
    return seal;
}

void writeSeal(const Seal& seal, const std::string& path) {
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out << kTitle << '\n' << seal.checksum << ' ' << seal.bytes << '\n' << seal.key;
    out.close();
    if (!out) {
        throw Error(path + ": cannot be written (" + std::strerror(errno) + ")");
    }
}

} // namespace stf
