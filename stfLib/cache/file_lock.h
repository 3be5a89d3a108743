// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/cache/file_descriptor.h"

#include <string>

namespace stf {

enum class LockState {
    Held,
    Busy,       ///< somebody else holds a lock that excludes this one
    Unavailable ///< cannot be told: the folder cannot be written, or its file system knows no locks
};

/// flock(2) of an open file, without waiting; `operation` is LOCK_SH or LOCK_EX. Released when the file is closed.
LockState tryFlock(int fd, int operation);

/// A lock among threads and processes, by a file that exists while somebody holds it. The operating system releases the
/// lock of a process that died; the file it leaves is taken over, or removed by the next who asks.
class FileLock {
public:
    /// Never waits.
    static FileLock tryTake(const std::string& path);

    FileLock(FileLock&&) = default;
    FileLock& operator=(FileLock&&) = delete;
    /// Releases the lock and removes its file.
    ~FileLock();
    LockState state() const { return state_; }

private:
    FileLock(LockState state, FileDescriptor file, std::string path)
        : state_(state), file_(std::move(file)), path_(std::move(path)) {}

    LockState state_;
    FileDescriptor file_; // only where the lock is held
    std::string path_;
};

} // namespace stf
