// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace stf {

/// Watches rounds of a fixed point x = M x + b. Their changes shrink by a ratio that tends to M's largest eigenvalue,
/// so that what further rounds would add is a geometric series; once the ratio is steady, a round can leap over that
/// (Lyusternik's acceleration, the scalar Aitken process on the dominant mode).
class RoundSeries {
public:
    /// `enough`: relative, of what all further rounds would add.
    explicit RoundSeries(double enough) : enough_(enough) {}

    /// One more round, which changed the values by `change` of their sum.
    void add(double change);
    /// Whether further rounds would change less than is wanted.
    bool settled() const;
    /// By how much of the last round's change the values are to be moved on; 0: not this time. Says that it was done.
    double leap();

    int rounds() const { return rounds_; }
    double lastChange() const { return change_; }

private:
    double enough_;
    double change_ = 0, ratio_ = 0.5;
    double leapRatio_ = 0;       ///< of the last leap: what is left of that mode still shrinks by it
    int rounds_ = 0, plain_ = 0; ///< plain: since the last leap
    bool steady_ = false;
};

} // namespace stf
