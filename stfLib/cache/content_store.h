// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"
#include "stfLib/base/progress.h"
#include "stfLib/cache/file_descriptor.h"
#include "stfLib/cache/file_lock.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace stf {

/// How much a store holds, in bytes of its files.
struct StoreSummary {
    std::size_t entries = 0;
    std::uint64_t bytes = 0, limit = 0;
};

/// A whole entry, in use: while this lives, no process evicts it. Keep it as long as the file may be opened again; what
/// is open can be read to its end anyway.
class StoreEntry {
public:
    StoreEntry(std::string path, FileDescriptor pin) : path_(std::move(path)), pin_(std::move(pin)) {}
    const std::string& path() const { return path_; }

private:
    std::string path_;
    FileDescriptor pin_; // under a shared flock
};

/// How the content of a key is had.
struct StoreRecipe {
    /// Takes the content from a whole file; may keep the entry. Throws Error where it does not understand it, and may
    /// then be called again.
    std::function<void(const std::shared_ptr<const StoreEntry>& entry)> read;
    /// Makes the content. What it throws ends the fetch.
    std::function<void()> make;
    /// Writes what `make` made to a new file. Throws Error.
    std::function<void(const std::string& path)> write;
};

/// What a store holds: its word for messages, and how its files end.
struct StoreKind {
    const char* one = "table";
    const char* many = "tables";
    const char* extension = ".vdb";
};

/// A folder of files named by the hash of the text they were made from, their key: `<hash>.vdb` (or as its kind says),
/// each with its checksum in `<hash>.seal`. Threads and processes may share the folder:
/// - A file appears whole or not at all; one that was damaged later is found out before use and made again.
/// - Of several who want the same missing content at once, one makes it and the others wait (`<hash>.lock`). Where the
///   file system has no locks, each makes it.
/// - Above `limit` bytes the least recently used files go; a use is noted as the file's time of modification. The
///   newest file stays whatever its size, and so do files in use.
/// A limit of 0 turns the store off: nothing is read or written. A folder that can only be read serves what it has.
/// Files are not flushed to the disk one by one: after a loss of power the checksums tell which are whole.
class ContentStore {
public:
    ContentStore(const std::string& folder, std::uint64_t limit, const StoreKind& kind = {});

    /// Takes the content of a key from the store, or makes and keeps it. Messages: Info where a damaged file is made
    /// again and where another maker is waited for; one Warning per store where content cannot be kept. Throws
    /// Cancelled, also while it waits, and what `recipe.make` throws. Not to be called from within a parallelFor: a
    /// thread that waits there could wait for itself.
    void fetch(const std::string& key, const StoreRecipe& recipe, Progress& progress, const MessageSink& messages);

    /// The entry of a key, checked and marked as used; null where there is none. Where it is damaged, `fault` (if
    /// given) says how, in a sentence that starts with the file.
    std::shared_ptr<const StoreEntry> find(const std::string& key, std::string* fault = nullptr) const;

    StoreSummary summary() const;
    /// Removes all but what is in use or being made right now. Returns what was removed.
    StoreSummary clear() const;

    const std::string& folder() const { return folder_; }
    const StoreKind& kind() const { return kind_; }
    /// Where the entry of a key is, if there is one.
    std::string pathOf(const std::string& key) const;

private:
    bool readEntry(const std::string& key, const StoreRecipe& recipe, std::string& fault) const;
    FileLock wait(const std::string& hash, Progress& progress, const MessageSink& messages) const;
    void keep(const std::string& key, const StoreRecipe& recipe) const;
    void evict(const std::string& newest) const;
    bool removeUnlessBusy(const std::string& hash) const;
    void tidy(bool all) const;
    std::string file(const std::string& hash, const char* extension) const;

    std::string folder_;
    std::uint64_t limit_;
    StoreKind kind_;
    std::atomic<bool> warned_{false};
};

} // namespace stf
