// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/synthesis_json.h"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

double secondsOf(const Synthesis& s) {
    double sum = 0;
    for (const auto& [stage, seconds] : s.seconds) {
        sum += seconds;
    }
    return sum;
}

} // namespace

std::string synthesisJson(const Synthesis& s, const SynthesisQuality& q) {
    nlohmann::ordered_json j;
    j["neighbourhoodError"] = q.neighbourhoodError;
    j["exemplarError"] = q.exemplarError;
    j["seamRate"] = q.seamRate;
    j["seamError"] = q.seamError;
    j["reuseMax"] = q.reuseMax;
    j["reuseEntropy"] = q.reuseEntropy;
    j["ks"] = q.ks;
    for (const auto& [name, value] : q.ksOf) {
        j["ksOf"][name] = value;
    }
    j["foldOvers"] = q.foldOvers;
    j["deltaR"] = q.deltaR;
    j["deltaRSeams"] = q.deltaRSeams;
    j["samples"] = q.samples;
    j["seconds"] = secondsOf(s);
    j["texelsPerSample"] = q.texelsPerSample;
    j["stretch"] = q.stretch;
    j["autocorrelation"] = q.autocorrelation;
    j["patches"] = {{"count", q.patches}, {"medianTexels", q.patchMedian}, {"largestTexels", q.patchLargest}};
    j["singularities"] = {{"count", q.singularities}, {"indexSum", q.indexSum}};
    j["charts"] = s.cover.charts.size();
    j["keptVariance"] = s.exemplar.keptVariance;
    for (const auto& [stage, seconds] : s.seconds) {
        j["stageSeconds"][stage] = seconds;
    }
    return j.dump();
}

std::string synthesisText(const Synthesis& s, const SynthesisQuality& q) {
    char text[1600];
    std::snprintf(text, sizeof text,
                  "%zu samples, %.3g texels each, %.1f s\n"
                  "  neighbourhood error   %8.3f   (the sample's own: %.3f)\n"
                  "  seams                 %8.2f %% of links, error %.3f\n"
                  "  patches               %8zu   of %.0f texels (median), %.0f at most\n"
                  "  reuse                 %8.2f   times the fair share at most, entropy %.4f\n"
                  "  parameters (KS)       %8.4f\n"
                  "  reflectance           %+8.2f %%, and %.2f %% (rms) by light across seams\n"
                  "  autocorrelation       %8.3f   off at most\n"
                  "  stretch (rms)         %8.2f %%, %zu triangles folded over\n"
                  "  singularities         %8zu   of the direction field, indices add up to %d\n",
                  q.samples, q.texelsPerSample, secondsOf(s), q.neighbourhoodError, q.exemplarError, 100 * q.seamRate,
                  q.seamError, q.patches, q.patchMedian, q.patchLargest, q.reuseMax, q.reuseEntropy, q.ks,
                  100 * q.deltaR, 100 * q.deltaRSeams, q.autocorrelation, 100 * q.stretch, q.foldOvers, q.singularities, q.indexSum);
    return text;
}

} // namespace stf
