// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/synthesis/quality.h"

#include <string>

namespace stf {

/// The report of `stf synthesize`: one line of JSON, with the names of the contract and more.
std::string synthesisJson(const Synthesis& synthesis, const SynthesisQuality& quality);
/// The same for people: a line for each measure.
std::string synthesisText(const Synthesis& synthesis, const SynthesisQuality& quality);

} // namespace stf
