#pragma once

#include "program.h"

#include <fcntl.h>
#include <pty.h>
#include <sys/ioctl.h>

/// \file For tests of what the program shows on a terminal.

/// Text on a terminal of this width after all that was written to it.
inline std::string shown(const std::string& written, std::size_t width)
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
    std::string text;
    for (const std::string& row : rows)
        text += row + "\n";
    return text;
}

/// The program on a terminal of its own, or in the background of one.
class Terminal
{
  public:
    Terminal(Workplace& place, const Words& arguments, unsigned short width, unsigned short height, bool background = false)
        : width_(width)
    {
        winsize size{height, width, 0, 0};
        pid_ = forkpty(&fd_, nullptr, nullptr, &size);
        REQUIRE(pid_ >= 0);
        if (pid_ != 0)
            return;
        if (background)
            run_in_background();
        Words words = arguments;
        words.insert(words.begin(), place.root() / "bin/fresco");
        auto environment = place.environment;
        environment.insert({{"TERM", "xterm"}, {"LC_ALL", "C"}});
        become(words, environment, place.work());
    }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;
    ~Terminal()
    {
        close(fd_);
        if (pid_ > 0)
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
        return code_of(std::exchange(pid_, -1));
    }
    std::string text() const { return shown(written_, width_); }
    const std::string& written() const { return written_; }

  private:
    /// Returns in a process of another group, whose exit code becomes this process's.
    static void run_in_background()
    {
        if (const pid_t job = fork(); job != 0)
            _exit(code_of(job));
        setpgid(0, 0);
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
    unsigned short width_;
    std::string written_;
};
