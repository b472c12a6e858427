#pragma once

#include "program.h"

#include <fcntl.h>
#include <pty.h>
#include <sys/ioctl.h>

/// \file For tests of what the program shows on a terminal.

/// Lines of a terminal of this width after all that was written to it.
inline Words shown(const std::string& written, std::size_t width)
{
    Words rows{""};
    std::size_t y = 0;
    std::size_t x = 0;
    for (std::size_t i = 0; i < written.size(); ++i)
    {
        const char c = written[i];
        rows.resize(std::max(rows.size(), y + 1));
        std::string& row = rows[y];
        if (c == '\r')
            x = 0;
        else if (c == '\n')
            ++y;
        else if (c != '\x1b')
        {
            if (x == width)
            {
                rows.resize(std::max(rows.size(), ++y + 1));
                x = 0;
            }
            std::string& place = rows[y];
            place.resize(std::max(place.size(), x + 1), ' ');
            place[x++] = c;
        }
        else
        {
            const std::size_t end = written.find_first_not_of("0123456789", i + 2);
            const std::size_t number = end > i + 2 ? std::stoul(written.substr(i + 2, end - i - 2)) : 1;
            const char what = written.at(end);
            REQUIRE(std::string("AKJm").find(what) != std::string::npos);
            if (what == 'A')
                y -= std::min(y, number);
            if (what == 'K' || what == 'J')
                row.resize(std::min(row.size(), x));
            if (what == 'J')
                rows.resize(y + 1);
            i = end;
        }
    }
    rows.resize(std::max(rows.size(), y + 1));
    return rows;
}

/// The program on a terminal of its own, or in the background of one.
class Terminal
{
  public:
    Terminal(Workplace& place, const Words& arguments, unsigned short width, unsigned short height, bool background = false)
        : width_(width)
    {
        winsize size{height, width, 0, 0};
        Words texts{(place.root() / "bin" / "fresco").string()};
        texts.insert(texts.end(), arguments.begin(), arguments.end());
        std::vector<char*> argv;
        for (auto& text : texts)
            argv.push_back(text.data());
        argv.push_back(nullptr);
        pid_ = forkpty(&fd_, nullptr, nullptr, &size);
        REQUIRE(pid_ >= 0);
        if (pid_ != 0)
            return;
        for (const auto& [name, value] : place.environment)
            setenv(name.c_str(), value.c_str(), 1);
        setenv("TERM", "xterm", 1);
        setenv("LC_ALL", "C", 1);
        if (background)
            run_in_background();
        if (chdir(place.work().c_str()) == 0)
            execv(argv[0], argv.data());
        _exit(127);
    }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;
    ~Terminal()
    {
        close(fd_);
        if (!ended_)
        {
            kill(pid_, SIGKILL);
            waitpid(pid_, nullptr, 0);
        }
    }
    void resize(unsigned short width, unsigned short height)
    {
        winsize size{height, width, 0, 0};
        ioctl(fd_, TIOCSWINSZ, &size);
        width_ = width;
    }
    void type(const std::string& keys) const { REQUIRE(write(fd_, keys.data(), keys.size()) > 0); }
    /// Reads until something is shown; false at the program's end.
    bool shows(const std::string& text)
    {
        while (read_some())
            if (this->text().find(text) != std::string::npos)
                return true;
        return false;
    }
    int finish()
    {
        while (read_some())
            continue;
        int status = 0;
        waitpid(pid_, &status, 0);
        ended_ = true;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }
    Words screen() const { return shown(written_, width_); }
    std::string text() const
    {
        std::string all;
        for (const std::string& row : screen())
            all += row + "\n";
        return all;
    }
    const std::string& written() const { return written_; }

  private:
    /// Returns in a process of another group, whose exit code becomes this process's.
    static void run_in_background()
    {
        const pid_t job = fork();
        int status = 0;
        if (job == 0)
            setpgid(0, 0);
        else
            _exit(waitpid(job, &status, 0) == job ? WEXITSTATUS(status) : 126);
    }
    bool read_some()
    {
        char buffer[4096];
        const ssize_t count = read(fd_, buffer, sizeof buffer);
        if (count <= 0)
            return false;
        written_.append(buffer, static_cast<std::size_t>(count));
        return true;
    }

    int fd_ = -1;
    pid_t pid_ = -1;
    bool ended_ = false;
    unsigned short width_;
    std::string written_;
};
