// SPDX-License-Identifier: Apache-2.0
// Noise and bias of the tables' lateral filter on the sample volumes: tables of few photons, filtered and not, against an
// unfiltered one of many. The error of a filtered table stops falling where its bias is reached.

#include "stfLib/transport/precompute.h"
#include "stfLib/volume/make_samples.h"

#include <cmath>
#include <cstdio>

using namespace stf;

namespace {

StfTable make(const BaseVolume& volume, std::uint64_t photons, bool filter, std::uint64_t seed) {
    TransportOptions o;
    o.quality = 1e-6f; // never met: the limit decides
    o.maxPhotons = photons;
    o.polars = 1;
    o.azimuths = 1;
    o.filter = filter;
    o.seed = seed;
    Progress progress;
    return precompute(volume, o, progress, {});
}

double rms(const StfTable& a, const StfTable& b) {
    double error = 0, sum = 0;
    for (std::size_t i = 0; i < a.multiple.size(); ++i) {
        const double d = double(a.multiple[i]) - double(b.multiple[i]);
        error += d * d;
        sum += double(b.multiple[i]) * double(b.multiple[i]);
    }
    return 100 * std::sqrt(error / sum);
}

} // namespace

int main() {
    for (const char* name : {"marble", "wax"}) {
        SampleOptions o;
        o.size = {48, 48, 16};
        const BaseVolume volume = makeSample(name, o);
        const StfTable reference = make(volume, 4'000'000, false, 1);
        std::printf("%s, 48 x 48 x 16 voxels; reference noise %.2f %%\n", name, 100 * reference.relativeError);
        std::printf("%10s %16s %16s\n", "photons", "filtered rms %", "unfiltered rms %");
        for (std::uint64_t n : {20'000, 80'000, 320'000, 1'280'000}) {
            std::printf("%10llu %16.2f %16.2f\n", static_cast<unsigned long long>(n),
                        rms(make(volume, n, true, 2), reference), rms(make(volume, n, false, 2), reference));
            std::fflush(stdout);
        }
    }
    return 0;
}
