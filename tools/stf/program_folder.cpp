// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/program_folder.h"

namespace stf {

std::filesystem::path programFolder() {
    std::error_code error;
    const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
    return error ? std::filesystem::path() : self.parent_path();
}

std::string programBeside(const std::string& name) {
    std::error_code error;
    const auto beside = programFolder() / name;
    return std::filesystem::exists(beside, error) ? beside.string() : name;
}

} // namespace stf
