// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Random123/philox.h>

#include <cmath>
#include <cstdint>

namespace stf {

/// Counter-based random numbers: Philox4x32-10 (Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3").
/// The stream is a pure function of (key, stream, index): photon or pixel number, never thread or time, so that any
/// number of threads gives the same result and a restart the same image.
class CounterRng {
public:
    CounterRng(std::uint64_t key, std::uint64_t stream)
        : key_{{std::uint32_t(key), std::uint32_t(key >> 32)}}, counter_{{0, 0, std::uint32_t(stream),
                                                                          std::uint32_t(stream >> 32)}} {}

    std::uint32_t bits() {
        if (used_ == 4) {
            // One block ahead: its ten dependent multiplications run beside what is done with this one.
            block_ = counter_[0] == 0 ? next() : ahead_;
            ahead_ = next();
            used_ = 0;
        }
        return block_[used_++];
    }
    /// Uniform in [0, 1), 24 bits: exact in float, never 1.
    float uniform() { return float(bits() >> 8) * 0x1p-24f; }
    /// Uniform in (0, 1], for logarithms.
    float uniformPositive() { return float((bits() >> 8) + 1) * 0x1p-24f; }
    /// Exponential with mean 1, from 1e-10 to 23: small values as well as large ones keep their digits, which
    /// -log(uniform()) would not.
    float exponential() {
        const std::uint32_t b = bits();
        return b < 0x80000000u ? -std::log1p(-(float(b) + 0.5f) * 0x1p-32f) : -std::log((float(~b) + 0.5f) * 0x1p-32f);
    }

private:
    r123::Philox4x32::ctr_type next() {
        const r123::Philox4x32::ctr_type block = r123::Philox4x32()(counter_, key_);
        ++counter_[0];
        return block;
    }

    r123::Philox4x32::key_type key_;
    r123::Philox4x32::ctr_type counter_;
    r123::Philox4x32::ctr_type block_{}, ahead_{};
    int used_ = 4;
};

/// A well-mixed 32-bit hash of two numbers (one Philox block), to derive scrambling seeds.
inline std::uint32_t hash32(std::uint64_t key, std::uint64_t value) {
    return CounterRng(key, value).bits();
}

} // namespace stf
