// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/atomicFile.h"

#include <filesystem>
#include <stdexcept>
#include <unistd.h>

namespace stfrecord {

void writeAtomically(const std::string& path, const std::function<void(const std::string&)>& write) {
    namespace fs = std::filesystem;
    const fs::path target(path);
    fs::path temporary = target;
    temporary.replace_filename("." + target.stem().string() + "." + std::to_string(::getpid()) +
                               target.extension().string());
    std::error_code error;
    try {
        write(temporary.string());
    } catch (...) {
        fs::remove(temporary, error);
        throw;
    }
    fs::rename(temporary, target, error);
    if (error) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw std::runtime_error("cannot write " + path + ": " + error.message());
    }
}

} // namespace stfrecord
