// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to stfLib's sources. OpenVDB's templates must keep default visibility also where a target hides its symbols:
// libopenvdb shares their static members (type names, once-flags) with this code, and initialize() crashes when it sees
// another copy.
#include "stfLib/base/tbb_guard.h"

#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif
#include <openvdb/io/File.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tree/ValueAccessor.h>
#if defined(__GNUC__)
#pragma GCC visibility pop
#endif
