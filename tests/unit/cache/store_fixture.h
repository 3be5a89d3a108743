// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/cache/content_store.h"
#include "tests/unit/support/files.h"

#include <chrono>
#include <iterator>
#include <mutex>
#include <vector>

namespace stf::test {

namespace fs = std::filesystem;

/// The bytes of a file.
inline std::string contentOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// A store in a folder of its own, and texts to keep in it.
class StoreTest : public testing::Test {
protected:
    static constexpr std::uint64_t kNoLimit = std::uint64_t(1) << 40;

    struct Result {
        std::string text;
        bool made = false;
        std::vector<std::string> messages;
    };

    /// Fetches the text that `key` stands for: itself, `length` times.
    static Result get(ContentStore& store, const std::string& key, int length = 100) {
        Result r;
        Progress progress;
        StoreRecipe recipe;
        recipe.read = [&](const std::shared_ptr<const StoreEntry>& entry) { r.text = contentOf(entry->path()); };
        recipe.make = [&] {
            r.made = true;
            r.text = textOf(key, length);
        };
        recipe.write = [&](const std::string& path) { std::ofstream(path) << r.text; };
        store.fetch(key, recipe, progress, [&](Severity severity, const std::string& text) {
            r.messages.push_back((severity == Severity::Warning ? "warning: " : "info: ") + text);
        });
        return r;
    }
    static std::string textOf(const std::string& key, int length = 100) {
        std::string text;
        for (int i = 0; i < length; ++i) {
            text += key;
        }
        return text;
    }
    static bool has(const ContentStore& store, const std::string& key) { return fs::exists(store.pathOf(key)); }
    /// Another file of a key.
    static std::string beside(const ContentStore& store, const std::string& key, const char* extension) {
        return fs::path(store.pathOf(key)).replace_extension(extension).string();
    }
    static void setAge(const std::string& path, std::chrono::hours age) {
        fs::last_write_time(path, fs::file_time_type::clock::now() - age);
    }
    std::vector<std::string> names() const {
        std::vector<std::string> all;
        for (const auto& e : fs::directory_iterator(folder())) {
            all.push_back(e.path().filename().string());
        }
        return all;
    }
    std::string folder() const { return folder_.path().string(); }

    const TemporaryFolder folder_;
};

} // namespace stf::test
