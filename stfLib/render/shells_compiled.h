// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace stf {

/// Whether paths know of shells. False in the copy that bench/plain.py measures scenes without shells against: the
/// compiler leaves out of it what a path does for them, and shells are drawn as plain surfaces.
#ifdef STF_WITHOUT_SHELLS
constexpr bool kShellsCompiled = false;
#else
constexpr bool kShellsCompiled = true;
#endif

} // namespace stf
