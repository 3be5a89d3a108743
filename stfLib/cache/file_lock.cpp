// SPDX-License-Identifier: Apache-2.0
#include "stfLib/cache/file_lock.h"

#include <cerrno>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

namespace stf {

LockState tryFlock(int fd, int operation) {
    int result = 0;
    do {
        result = ::flock(fd, operation | LOCK_NB);
    } while (result != 0 && errno == EINTR);
    return result == 0 ? LockState::Held : errno == EWOULDBLOCK ? LockState::Busy : LockState::Unavailable;
}

FileLock FileLock::tryTake(const std::string& path) {
    for (;;) {
        // Close-on-exec: a program that this process starts must not go on holding the lock.
        FileDescriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
        if (!file) {
            return {LockState::Unavailable, {}, {}};
        }
        const LockState state = tryFlock(file.get(), LOCK_EX);
        if (state != LockState::Held) {
            if (state == LockState::Unavailable) {
                ::unlink(path.c_str());
            }
            return {state, {}, {}};
        }
        // The last holder may have removed the file between the two calls: then this lock excludes nobody.
        struct stat mine, named;
        if (::fstat(file.get(), &mine) == 0 && ::stat(path.c_str(), &named) == 0 && mine.st_ino == named.st_ino &&
            mine.st_dev == named.st_dev) {
            return {LockState::Held, std::move(file), path};
        }
    }
}

FileLock::~FileLock() {
    if (file_) {
        // The lock goes with the name: who asks next locks another file, even where a forked child keeps this one open.
        ::unlink(path_.c_str());
    }
}

} // namespace stf
