// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"

#include <cstdlib>
#include <filesystem>
#include <string>

namespace stf {

/// A folder of its own for files in between; removed with everything in it.
class TemporaryFolder {
public:
    TemporaryFolder() {
        std::string pattern = (std::filesystem::temp_directory_path() / "stf_XXXXXX").string();
        if (!::mkdtemp(pattern.data())) {
            throw Error("cannot make a temporary folder in " + std::filesystem::temp_directory_path().string());
        }
        path_ = pattern;
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }
    std::string file(const std::string& name) const { return (path_ / name).string(); }

private:
    std::filesystem::path path_;
};

} // namespace stf
