// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/temporary_folder.h"

#include <string>
#include <vector>

namespace fuzz {

/// Volumes and images that a stage names, in a folder of their own: tiny, so that their tables take moments.
class Files {
public:
    Files();

    std::string volume(int i) const { return folder_.file("volume" + std::to_string(i) + ".vdb"); }
    static constexpr int volumes = 3;
    std::string image(int i) const { return folder_.file("image" + std::to_string(i) + ".ppm"); }
    static constexpr int images = 2;

    /// Puts what is no volume in its place, or nothing at all.
    void breakVolume(int i, bool remove) const;
    void mendVolume(int i) const;

private:
    stf::TemporaryFolder folder_;
};

} // namespace fuzz
