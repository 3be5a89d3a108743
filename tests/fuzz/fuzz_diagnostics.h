// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

namespace fuzz {

/// Collects what OpenUSD and the delegate report while this lives, in place of printing it each time.
class Diagnostics {
public:
    Diagnostics();
    ~Diagnostics();

    /// Prints each error once, with how often it came. False where one comes from the delegate's own code: it has none
    /// to report, whatever a scene is like.
    bool print() const;

private:
    class Collector;
    std::unique_ptr<Collector> collector_;
};

} // namespace fuzz
