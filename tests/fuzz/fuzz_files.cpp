// SPDX-License-Identifier: Apache-2.0
#include "fuzz_files.h"

#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"

#include <fstream>

namespace fuzz {

Files::Files() {
    for (int i = 0; i < volumes; ++i) {
        mendVolume(i);
    }
    for (int i = 0; i < images; ++i) {
        std::ofstream out(image(i), std::ios::binary);
        out << "P6 4 2 255\n";
        for (int k = 0; k < 4 * 2 * 3; ++k) {
            out.put(char((k * (53 + 40 * i)) % 256));
        }
    }
}

void Files::breakVolume(int i, bool remove) const {
    std::filesystem::remove(volume(i));
    if (!remove) {
        std::ofstream(volume(i)) << "no volume";
    }
}

void Files::mendVolume(int i) const {
    stf::SampleOptions options;
    options.size = {2 + i, 2, 3};
    options.voxelMm = 0.6;
    options.extinction = stf::Rgb(2.0f, 1.5f, 1.0f);
    options.albedo = stf::Rgb(0.9f, 0.8f, 0.5f);
    options.tau = 3;
    options.ratio = 5;
    options.ior = i == 2 ? 1.3 : 1.0;
    stf::BaseVolume volumeMade = stf::makeSample(i == 0 ? "uniform" : "random", options);
    const std::string whole = volume(i) + ".new";
    stf::writeBaseVolume(volumeMade, whole);
    std::filesystem::rename(whole, volume(i));
}

} // namespace fuzz
