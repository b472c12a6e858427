#pragma once

#include "catch.h"

#include <fresco/files_io.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

/// \file For tests that run programs.

namespace fs = std::filesystem;

struct Finished
{
    int code = -1;  ///< Exit code, or minus the signal.
    std::string out;
    std::string err;
};

/// Exit code of a child of this process, or minus the signal, when it has ended.
inline int code_of(pid_t child)
{
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

/// Becomes a program: its path, and its arguments.
[[noreturn]] inline void become(std::vector<std::string> words, const std::map<std::string, std::string>& environment,
                                const fs::path& folder)
{
    std::vector<char*> argv;
    for (auto& word : words)
        argv.push_back(word.data());
    argv.push_back(nullptr);
    for (const auto& [name, value] : environment)
        setenv(name.c_str(), value.c_str(), 1);
    if (chdir(folder.c_str()) == 0)
        execv(argv[0], argv.data());
    _exit(127);
}

/// A program that runs beside the test, at most as long as this object lives.
class Background
{
  public:
    /// `words`: its path, and its arguments. Its streams go to the files `out` and `err`.
    Background(const std::vector<std::string>& words, const std::map<std::string, std::string>& environment,
               const fs::path& folder, fs::path out, fs::path err)
        : out_(std::move(out)), err_(std::move(err))
    {
        std::fflush(nullptr);
        pid_ = fork();
        REQUIRE(pid_ >= 0);
        if (pid_ > 0)
            return;
        if (freopen(out_.c_str(), "w", stdout) == nullptr || freopen(err_.c_str(), "w", stderr) == nullptr)
            _exit(126);
        become(words, environment, folder);
    }
    Background(const Background&) = delete;
    Background& operator=(const Background&) = delete;
    ~Background()
    {
        if (pid_ <= 0)
            return;
        kill(pid_, SIGKILL);
        waitpid(pid_, nullptr, 0);
    }
    void signal(int number) const { kill(pid_, number); }
    /// Output so far.
    std::string out() const { return fs::exists(out_) ? fresco::read_text_file(out_) : ""; }
    std::string err() const { return fs::exists(err_) ? fresco::read_text_file(err_) : ""; }
    bool says(const std::string& text) const { return (out() + err()).find(text) != std::string::npos; }
    /// One of the processes that the program has started. Fails the test if none is running.
    pid_t a_child() const
    {
        const std::string id = std::to_string(pid_);
        std::ifstream children("/proc/" + id + "/task/" + id + "/children");
        pid_t child = 0;
        REQUIRE(children >> child);
        return child;
    }
    Finished wait()
    {
        const int code = code_of(std::exchange(pid_, -1));
        return {code, out(), err()};
    }

  private:
    pid_t pid_;
    fs::path out_;
    fs::path err_;
};

/// Waits until something holds; fails the test after a minute.
template <class Condition>
void wait_until(Condition condition)
{
    for (int i = 0; i < 6000; ++i)
    {
        if (condition())
            return;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    FAIL("waited for a minute");
}

inline bool contains(const std::string& text, const std::string& part)
{
    const bool found = text.find(part) != std::string::npos;
    if (!found)
        UNSCOPED_INFO("\"" << part << "\" is not in:\n" << text);
    return found;
}
