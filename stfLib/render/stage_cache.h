// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace stf {

/// Part of a key: of the bytes of plain values.
template<class T>
std::string hashOf(const std::vector<T>& values) {
    return contentHashOf({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

/// Results of one stage by a key that names all they were made from. Whoever holds a result keeps it here; others go
/// with `dropUnused`. One thread at a time.
template<class T>
class StageCache {
public:
    /// Null where there is none.
    std::shared_ptr<const T> find(const std::string& key) const {
        const auto it = kept_.find(key);
        return it == kept_.end() ? nullptr : it->second;
    }
    std::shared_ptr<const T> keep(const std::string& key, std::shared_ptr<const T> value) {
        return kept_[key] = std::move(value);
    }
    std::shared_ptr<const T> keep(const std::string& key, T value) {
        return keep(key, std::make_shared<const T>(std::move(value)));
    }
    void erase(const std::string& key) { kept_.erase(key); }
    void dropUnused() {
        for (auto it = kept_.begin(); it != kept_.end();) {
            it = it->second.use_count() <= 1 ? kept_.erase(it) : std::next(it);
        }
    }

private:
    std::map<std::string, std::shared_ptr<const T>> kept_;
};

} // namespace stf
