// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to stfLib's sources.
// OpenVDB and Embree are built with oneTBB, older OpenUSD with classic TBB. A translation unit that mixes them
// compiles and links but silently breaks OpenVDB's memory layout; every unit that includes TBB or OpenVDB includes
// this first.
#include <tbb/version.h>
#if !defined(TBB_VERSION_MAJOR) || TBB_VERSION_MAJOR < 2021
#error "stfLib needs oneTBB (2021 or later); a classic TBB is first on the include path"
#endif
