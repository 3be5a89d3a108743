// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/content_store.h"

#include "stfLib/cache/seal.h"
#include "stfLib/volume/base_volume.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
#include <sys/stat.h>
#include <thread>
#include <vector>

namespace stf {

namespace {

namespace fs = std::filesystem;

const char* const kSeal = ".seal";
const char* const kLock = ".lock";
const char* const kTemporary = ".tmp";
constexpr std::size_t kHashLength = 32;

// The hash that names a file of a store; empty for other files.
std::string hashOf(const fs::path& path) {
    const std::string name = path.filename().string();
    const bool ours = name.size() > kHashLength && name[kHashLength] == '.' &&
                      name.find_first_not_of("0123456789abcdef") == kHashLength;
    return ours ? name.substr(0, kHashLength) : std::string();
}

// Files of a store with this ending. They may be gone when the caller looks at them.
std::vector<fs::path> filesOf(const std::string& folder, const char* extension) {
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::directory_iterator i(folder, error), end; !error && i != end; i.increment(error)) {
        if (i->path().extension() == extension && !hashOf(i->path()).empty()) {
            files.push_back(i->path());
        }
    }
    return files;
}

struct Item {
    std::string hash;
    std::uint64_t bytes = 0;
    fs::file_time_type used;
};

std::vector<Item> itemsOf(const std::string& folder, const char* extension) {
    std::vector<Item> items;
    for (const fs::path& path : filesOf(folder, extension)) {
        std::error_code gone, noSeal;
        const std::uintmax_t size = fs::file_size(path, gone);
        const auto used = gone ? fs::file_time_type() : fs::last_write_time(path, gone);
        const std::uintmax_t seal = fs::file_size(fs::path(path).replace_extension(kSeal), noSeal);
        if (!gone) {
            items.push_back({hashOf(path), size + (noSeal ? 0 : seal), used});
        }
    }
    return items;
}

FileDescriptor openFile(const std::string& path, int flags) {
    return FileDescriptor(::open(path.c_str(), flags | O_CLOEXEC));
}

} // namespace

ContentStore::ContentStore(const std::string& folder, std::uint64_t limit, const StoreKind& kind)
    : folder_(fs::absolute(folder).string()), limit_(limit), kind_(kind) {}

std::string ContentStore::file(const std::string& hash, const char* extension) const {
    return (fs::path(folder_) / (hash + extension)).string();
}

std::string ContentStore::pathOf(const std::string& key) const {
    return file(contentHashOf(key), kind_.extension);
}

void ContentStore::fetch(const std::string& key, const StoreRecipe& recipe, Progress& progress,
                         const MessageSink& messages) {
    if (limit_ == 0) {
        recipe.make();
        return;
    }
    std::string fault;
    if (readEntry(key, recipe, fault)) {
        return;
    }
    const std::string hash = contentHashOf(key);
    const FileLock lock = wait(hash, progress, messages);
    // Another may have made it meanwhile. What looked damaged may have been on its way in or out: this look decides.
    fault.clear();
    if (readEntry(key, recipe, fault)) {
        return;
    }
    if (!fault.empty()) {
        report(messages, Severity::Info, std::string("a cached ") + kind_.one + " is made again: " + fault);
        // At once: it would be found again if what is made now cannot be kept.
        ::unlink(file(hash, kind_.extension).c_str());
        ::unlink(file(hash, kSeal).c_str());
    }
    recipe.make();
    try {
        keep(key, recipe);
    } catch (const std::exception& e) {
        if (!warned_.exchange(true)) {
            report(messages, Severity::Warning, std::string(kind_.many) + " are not kept: " + e.what());
        }
    }
}

bool ContentStore::readEntry(const std::string& key, const StoreRecipe& recipe, std::string& fault) const {
    const auto entry = find(key, &fault);
    if (!entry) {
        return false;
    }
    try {
        recipe.read(entry);
        return true;
    } catch (const Cancelled&) {
        throw;
    } catch (const std::exception& e) {
        fault = e.what();
        return false;
    }
}

FileLock ContentStore::wait(const std::string& hash, Progress& progress, const MessageSink& messages) const {
    std::error_code ignored; // keep() will tell
    fs::create_directories(folder_, ignored);
    auto pause = std::chrono::milliseconds(5);
    for (int attempt = 0;; ++attempt) {
        FileLock lock = FileLock::tryTake(file(hash, kLock));
        if (lock.state() != LockState::Busy) {
            return lock;
        }
        // Whoever evicts or tidies takes the lock too, for an instant that is not worth a word.
        if (attempt == 2) {
            report(messages, Severity::Info,
                   "waiting for another process or thread to make " + file(hash, kind_.extension));
        }
        progress.update("waiting", 0);
        std::this_thread::sleep_for(pause);
        pause = std::min(2 * pause, std::chrono::milliseconds(100));
    }
}

std::shared_ptr<const StoreEntry> ContentStore::find(const std::string& key, std::string* fault) const {
    if (limit_ == 0) {
        return nullptr;
    }
    const std::string hash = contentHashOf(key), path = file(hash, kind_.extension);
    const auto damaged = [&](const std::string& how) {
        if (fault) {
            *fault = path + ": " + how;
        }
        return nullptr;
    };
    FileDescriptor entry = openFile(path, O_RDONLY);
    if (!entry) {
        return errno == ENOENT || errno == ENOTDIR
                   ? nullptr
                   : damaged(std::string("cannot be opened (") + std::strerror(errno) + ")");
    }
    struct stat status;
    if (tryFlock(entry.get(), LOCK_SH) == LockState::Busy || ::fstat(entry.get(), &status) != 0 ||
        status.st_nlink == 0) {
        return nullptr; // it is just being removed
    }
    const std::optional<Seal> seal = readSeal(file(hash, kSeal));
    if (!seal) {
        return damaged("its checksum is missing (" + hash + kSeal + ")");
    }
    if (seal->key != key) {
        return damaged("it was made for something else");
    }
    if (std::uint64_t(status.st_size) != seal->bytes) {
        return damaged("it has " + std::to_string(status.st_size) + " bytes and was written with " +
                       std::to_string(seal->bytes));
    }
    try {
        if (sealOf(entry.get(), key).checksum != seal->checksum) {
            return damaged("its content has changed since it was written");
        }
    } catch (const Error& e) {
        return damaged(e.what());
    }
    ::futimens(entry.get(), nullptr); // the time of this use; fails where the folder can only be read
    return std::make_shared<const StoreEntry>(path, std::move(entry));
}

void ContentStore::keep(const std::string& key, const StoreRecipe& recipe) const {
    static std::atomic<unsigned> counter{0};
    const std::string hash = contentHashOf(key), path = file(hash, kind_.extension), seal = file(hash, kSeal);
    const std::string unique = "." + std::to_string(::getpid()) + "-" + std::to_string(counter++) + kTemporary;
    const std::string newPath = path + unique, newSeal = seal + unique;
    try {
        fs::create_directories(folder_);
        recipe.write(newPath);
        const FileDescriptor written = openFile(newPath, O_RDONLY);
        if (!written) {
            throw Error(newPath + ": cannot be read back (" + std::strerror(errno) + ")");
        }
        writeSeal(sealOf(written.get(), key), newSeal);
        // The old entry goes first and the new one comes last: an entry never stands beside the seal of another.
        fs::remove(path);
        fs::rename(newSeal, seal);
        fs::rename(newPath, path);
    } catch (const std::exception& e) {
        ::unlink(newPath.c_str());
        ::unlink(newSeal.c_str());
        if (const auto* system = dynamic_cast<const fs::filesystem_error*>(&e)) {
            throw Error(system->path1().string() + ": cannot be written (" + system->code().message() + ")");
        }
        throw;
    }
    evict(hash);
    tidy(false);
}

void ContentStore::evict(const std::string& newest) const {
    std::vector<Item> items = itemsOf(folder_, kind_.extension);
    std::uint64_t total = 0;
    for (const Item& item : items) {
        total += item.bytes;
    }
    std::sort(items.begin(), items.end(), [&](const Item& a, const Item& b) {
        const bool aLast = a.hash == newest, bLast = b.hash == newest;
        return aLast != bLast ? bLast : a.used != b.used ? a.used < b.used : a.hash < b.hash;
    });
    for (std::size_t i = 0; i + 1 < items.size() && total > limit_; ++i) {
        if (removeUnlessBusy(items[i].hash)) {
            total -= items[i].bytes;
        }
    }
}

bool ContentStore::removeUnlessBusy(const std::string& hash) const {
    const std::string path = file(hash, kind_.extension);
    const FileLock lock = FileLock::tryTake(file(hash, kLock));
    if (lock.state() == LockState::Busy) {
        return false; // being made
    }
    // Network file systems give an exclusive lock only on a file that is open for writing.
    FileDescriptor entry = openFile(path, O_RDWR);
    if (!entry) {
        entry = openFile(path, O_RDONLY);
    }
    if (entry && tryFlock(entry.get(), LOCK_EX) == LockState::Busy) {
        return false; // being read
    }
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) {
        return false;
    }
    ::unlink(file(hash, kSeal).c_str());
    return true;
}

// Removes what processes that died have left: temporary files, seals without an entry, locks. What belongs to a process
// at work is told by the lock of its key; where there are no locks, by its age.
void ContentStore::tidy(bool all) const {
    std::error_code error;
    const auto yesterday = fs::file_time_type::clock::now() - std::chrono::hours(24);
    for (const char* extension : {kTemporary, kSeal}) {
        for (const fs::path& path : filesOf(folder_, extension)) {
            const std::string hash = hashOf(path);
            const auto written = fs::last_write_time(path, error);
            if (error || (written > yesterday && !all)) {
                continue;
            }
            const FileLock lock = FileLock::tryTake(file(hash, kLock));
            const bool orphan = extension == kTemporary || !fs::exists(file(hash, kind_.extension), error);
            if (orphan && lock.state() != LockState::Busy) {
                fs::remove(path, error);
            }
        }
    }
    for (const fs::path& path : filesOf(folder_, kLock)) {
        FileLock::tryTake(path.string()); // a lock that can be had goes with its release
    }
}

StoreSummary ContentStore::summary() const {
    StoreSummary s;
    s.limit = limit_;
    for (const Item& item : itemsOf(folder_, kind_.extension)) {
        ++s.entries;
        s.bytes += item.bytes;
    }
    return s;
}

StoreSummary ContentStore::clear() const {
    StoreSummary removed;
    removed.limit = limit_;
    for (const Item& item : itemsOf(folder_, kind_.extension)) {
        if (removeUnlessBusy(item.hash)) {
            ++removed.entries;
            removed.bytes += item.bytes;
        }
    }
    tidy(true);
    return removed;
}

} // namespace stf
