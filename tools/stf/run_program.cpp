// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/run_program.h"

#include "stfLib/base/error.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

extern char** environ;

namespace stf {

namespace {

/// Which files a program's output goes to.
class Redirection {
public:
    Redirection() { posix_spawn_file_actions_init(&actions_); }
    ~Redirection() { posix_spawn_file_actions_destroy(&actions_); }
    Redirection(const Redirection&) = delete;
    Redirection& operator=(const Redirection&) = delete;
    void send(int descriptor, const std::string& path) {
        if (!path.empty()) {
            posix_spawn_file_actions_addopen(&actions_, descriptor, path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
        }
    }
    const posix_spawn_file_actions_t* get() const { return &actions_; }

private:
    posix_spawn_file_actions_t actions_;
};

} // namespace

ProgramEnd runProgram(const std::vector<std::string>& words, const ProgramRun& how) {
    std::vector<char*> argv;
    for (const std::string& w : words) {
        argv.push_back(const_cast<char*>(w.c_str()));
    }
    argv.push_back(nullptr);
    Redirection output;
    output.send(STDOUT_FILENO, how.standardOutput);
    output.send(STDERR_FILENO, how.standardError);
    pid_t child = 0;
    if (const int error = posix_spawnp(&child, argv[0], output.get(), nullptr, argv.data(), environ); error != 0) {
        throw Error("cannot start " + words[0] + " (" + std::strerror(error) + ")");
    }
    ProgramEnd end;
    int status = 0;
    const auto start = std::chrono::steady_clock::now();
    const int flags = how.mostSeconds > 0 ? WNOHANG : 0;
    for (pid_t ended = 0; ended != child;) {
        ended = waitpid(child, &status, end.timedOut ? 0 : flags);
        if (ended < 0 && errno != EINTR) {
            throw Error("lost sight of " + words[0] + " (" + std::strerror(errno) + ")");
        }
        if (ended == 0) {
            const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - start;
            if (gone.count() > how.mostSeconds) {
                end.timedOut = true;
                ::kill(child, SIGKILL);
            } else {
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
            }
        }
    }
    end.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
    end.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    return end;
}

} // namespace stf
