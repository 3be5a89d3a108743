// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace stf {

/// What a denoiser looks at: three floats a pixel, rows in any order that all share.
struct DenoiserInput {
    int width = 0, height = 0;
    std::vector<float> color;  ///< linear, of any range
    std::vector<float> albedo; ///< 0..1; empty: none
    std::vector<float> normal; ///< -1..1; empty: none; only together with albedo
};

/// Intel Open Image Denoise (2.x or 1.x), asked for when it is needed: a machine without it renders all the same. It is
/// loaded by its C interface, which both versions share, from the loader's usual places or from the path in
/// HDSTF_OIDN_LIBRARY. Thread-safe.
class Denoiser {
public:
    /// Whether the library is there; else `why` says what is missing, in a sentence without its end.
    static bool available(std::string* why = nullptr);
    /// The colour without its noise, three floats a pixel. Throws Error where the library is missing or fails, or where
    /// an image has another size.
    static std::vector<float> denoise(const DenoiserInput& input);
};

} // namespace stf
