#include "progress_rate.h"

#include <fresco/host/progress_display.h>

#include <cmath>
#include <fmt/format.h>

namespace fresco::host
{

std::string duration_text(double seconds)
{
    if (seconds < 10)
        return fmt::format("{:.1f} s", seconds);
    const auto whole = static_cast<long>(std::lround(seconds));
    if (whole < 60)
        return fmt::format("{} s", whole);
    if (whole < 3600)
        return fmt::format("{}:{:02} min", whole / 60, whole % 60);
    return fmt::format("{}:{:02}:{:02} h", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string size_text(double megabytes)
{
    if (megabytes >= 10'240)
        return fmt::format("{:.1f} GB", megabytes / 1024);
    return megabytes >= 10 ? fmt::format("{:.0f} MB", megabytes) : fmt::format("{:.1f} MB", megabytes);
}

void ProgressRate::update(double done, double total, const std::string& unit)
{
    const auto now = Clock::now();
    if (!any_ || unit != unit_ || total < total_ || total > total_ || done < done_)
    {
        first_ = done;
        first_time_ = now;
    }
    any_ = true;
    done_ = done;
    total_ = total;
    unit_ = unit;
    last_time_ = now;
}

double ProgressRate::rate() const
{
    const double seconds = std::chrono::duration<double>(last_time_ - first_time_).count();
    return seconds < 0.5 || done_ <= first_ ? 0 : (done_ - first_) / seconds;
}

std::string ProgressRate::text() const
{
    const double running = std::chrono::duration<double>(Clock::now() - begin_).count();
    if (!any_)
        return duration_text(running);
    std::string text = fmt::format("{:.0f}", done_);
    if (total_ > 0)
        text += fmt::format(" of {:.0f}", total_);
    text += " " + unit_;
    const double rate = this->rate();
    if (rate <= 0)
        return text;
    text += rate >= 10 ? fmt::format(", {:.0f} {}/s", rate, unit_) : fmt::format(", {:.2g} {}/s", rate, unit_);
    if (total_ > done_)
        text += ", " + duration_text((total_ - done_) / rate) + " left";
    return text;
}

}  // namespace fresco::host
