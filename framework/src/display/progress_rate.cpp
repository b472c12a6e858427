#include "display/progress_rate.h"
#include "base/unit_text.h"

#include <cmath>
#include <fmt/format.h>

namespace fresco::host
{

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
