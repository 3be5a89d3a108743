// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/film.h"

#include <cstdint>
#include <vector>

namespace stf {

/// Which pixels still need samples. Pixels are judged together, after passes that double in number from 16 on: each by
/// the standard error of its luminance, averaged over it and the eight around it (its own scatter alone would let those
/// go whose samples happen to agree, which are too dark as a rule), against `target` times their mean luminance, or
/// times a quarter of the image's where that is more. Of the nine the one of the largest error goes on as well, though it
/// may be good enough among its own neighbours: beside a bright edge dark pixels would wait for it without end. A pixel
/// that was let go comes back if its surroundings change.
/// The same for any number of threads. One thread; `active` from any while nobody decides.
class AdaptiveSampling {
public:
    /// All pixels, from the first pass on.
    void restart(int width, int height);
    /// Before each pass: judges where it is time. `target` 0: all pixels go on.
    void beforePass(const Film& film, std::uint32_t pass, double target);
    bool active(int x, int y) const { return active_[std::size_t(y) * std::size_t(width_) + std::size_t(x)] != 0; }
    std::size_t activeCount() const { return count_; }

private:
    int width_ = 0, height_ = 0;
    std::vector<std::uint8_t> active_;
    std::size_t count_ = 0;
    std::uint32_t judged_ = 0; ///< pass before which it was judged last
};

} // namespace stf
