#include "report/page_process.h"

#include "base/text.h"

#include <array>
#include <csignal>
#include <fmt/format.h>
#include <poll.h>

namespace fresco::host
{
namespace
{

using Clock = std::chrono::steady_clock;

class PageProcess
{
  public:
    PageProcess(const Child& child, std::chrono::milliseconds limit) : child_(child), limit_(limit) {}

    std::string wait()
    {
        while (!take_group_end(child_.pid, end_))
        {
            read();
            if (Clock::now() - begin_ > limit_ && !std::exchange(timed_out_, true))
                kill(child_.pid, SIGKILL);
            std::array<pollfd, 2> descriptors{pollfd{open_ ? child_.output.get() : -1, POLLIN, 0},
                                              pollfd{heard_ ? child_.channel.get() : -1, POLLIN, 0}};
            poll(descriptors.data(), descriptors.size(), 20);
        }
        read();
        return problem();
    }

  private:
    void read()
    {
        std::string line;
        open_ = open_ && printed_.read_from(child_.output.get());
        while (printed_.next(line))
            last_ = line;
        heard_ = heard_ && shown_.read_from(child_.channel.get());
        while (shown_.next(line))
        {
            when_ = " when it showed " + line;
            begin_ = Clock::now();
        }
    }

    std::string problem() const
    {
        const std::string process = "the process that makes them ";
        if (timed_out_)
            return fmt::format("{}did not return within {}{}", process,
                               duration_text(std::chrono::duration<double>(limit_).count()), when_);
        if (end_.signal != 0)
            return process + "ended by " + signal_text(end_.signal) + when_;
        if (end_.exit_code != 0 && last_.empty())
            return fmt::format("{}ended with code {}{}", process, end_.exit_code, when_);
        return end_.exit_code == 0 ? "" : last_;
    }

    const Child& child_;
    std::chrono::milliseconds limit_;
    Clock::time_point begin_ = Clock::now();
    LineBuffer printed_;
    LineBuffer shown_;
    bool open_ = true;
    bool heard_ = true;
    bool timed_out_ = false;
    std::string last_;
    std::string when_;
    ProcessEnd end_;
};

}  // namespace

void tell_shown(const std::string& artifact)
{
    send_all(child_channel, artifact + "\n");
}

std::string wait_for_page(const Child& child, std::chrono::milliseconds limit)
{
    return PageProcess(child, limit).wait();
}

}  // namespace fresco::host
