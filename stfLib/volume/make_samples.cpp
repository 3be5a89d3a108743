// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/make_samples.h"

#include "stfLib/volume/samples.h"

namespace stf {

namespace {

struct Sample {
    SampleInfo info;
    BaseVolume (*make)(const SampleOptions&);
};

const std::vector<Sample>& samples() {
    static const std::vector<Sample> list{
        {{"marble", "white marble with rust-coloured veins, 38 x 38 x 8 mm"}, makeMarble},
        {{"wax", "warm wax with a raised rosette pattern, 10 x 10 x 5 mm"}, makeWax},
        {{"jade", "green jade with pale clouds, rusty stains and dark grains, 24 x 24 x 6 mm"}, makeJade},
        {{"skin", "skin in layers, with grooves, pores and vessels, 7 x 7 x 2.4 mm"}, makeSkin},
        {{"coral", "a coral's skeleton full of round holes, 16 x 16 x 6 mm"}, makeCoral},
        {{"ice", "glacier ice with bands of bubbles and cracks, 240 x 240 x 72 mm"}, makeIce},
        {{"uniform", "homogeneous medium by --extinction, --albedo, --g"}, makeUniform},
        {{"random", "voxels of independent log-uniform extinction by --ratio, --tau, --albedo, --g"}, makeRandom},
    };
    return list;
}

} // namespace

const std::vector<SampleInfo>& sampleNames() {
    static const std::vector<SampleInfo> names = [] {
        std::vector<SampleInfo> list;
        for (const Sample& s : samples()) {
            list.push_back(s.info);
        }
        return list;
    }();
    return names;
}

BaseVolume makeSample(const std::string& name, const SampleOptions& options) {
    std::string known;
    for (const Sample& s : samples()) {
        if (s.info.name == name) {
            BaseVolume v = s.make(options);
            if (options.ior != 0) {
                v.ior.assign(v.voxelCount(), float(options.ior));
            }
            validate(v);
            return v;
        }
        known += (known.empty() ? "" : ", ") + s.info.name;
    }
    throw Error("no sample named '" + name + "' (known: " + known + ")");
}

} // namespace stf
