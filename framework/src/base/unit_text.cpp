#include "base/unit_text.h"

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

}  // namespace fresco::host
