// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"

#include <atomic>
#include <functional>
#include <string>

namespace stf {

/// How a long stage tells where it is and learns that it should stop. `update` and `cancelled` may be called from
/// any thread; `onUpdate` must bear that.
class Progress {
public:
    using Callback = std::function<void(const std::string& stage, double fraction)>;

    Progress() = default;
    explicit Progress(Callback onUpdate) : onUpdate_(std::move(onUpdate)) {}
    virtual ~Progress() = default;

    void cancel() { cancel_.store(true, std::memory_order_relaxed); }
    virtual bool cancelled() const { return cancel_.load(std::memory_order_relaxed); }

    /// `fraction` is 0 to 1 of this stage. Throws Cancelled after a cancel.
    void update(const std::string& stage, double fraction) {
        if (onUpdate_) {
            onUpdate_(stage, fraction);
        }
        if (cancelled()) {
            throw Cancelled();
        }
    }

private:
    Callback onUpdate_;
    std::atomic<bool> cancel_{false};
};

} // namespace stf
