// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace stf {

/// A value that is there, or that is made (read from a file) at its first use. Copies share it. Thread-safe; what the
/// maker throws reaches every caller that asks before it succeeds. The maker runs under a lock: it must not wait for
/// tasks of others (tbb::this_task_arena::isolate), who may ask for the same value.
template<class T>
class Lazy {
public:
    Lazy() : Lazy(T()) {}
    Lazy(T value) : state_(std::make_shared<State>()) {
        state_->value = std::move(value);
        state_->made = true;
    }
    explicit Lazy(std::function<T()> make) : state_(std::make_shared<State>()) { state_->make = std::move(make); }

    const T& get() const {
        State& s = *state_;
        if (!s.made.load(std::memory_order_acquire)) {
            const std::lock_guard<std::mutex> lock(s.mutex);
            if (!s.made.load(std::memory_order_relaxed)) {
                s.value = s.make();
                s.make = nullptr;
                s.made.store(true, std::memory_order_release);
            }
        }
        return s.value;
    }
    const T& operator*() const { return get(); }
    const T* operator->() const { return &get(); }
    /// Whether it is in memory.
    bool made() const { return state_->made; }

private:
    struct State {
        std::mutex mutex;
        std::function<T()> make;
        T value{};
        std::atomic<bool> made{false};
    };
    std::shared_ptr<State> state_;
};

} // namespace stf
