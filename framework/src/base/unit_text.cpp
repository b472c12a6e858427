#include "base/unit_text.h"
#include "base/terminal_line.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
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

std::string path_text(const std::filesystem::path& path)
{
    std::error_code error;
    const std::filesystem::path here = path.lexically_relative(std::filesystem::current_path(error));
    return here.empty() || *here.begin() == ".." ? path.string() : here.string();
}

std::string shell_word(const std::string& text)
{
    const auto is_plain = [](char c)
    { return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("_./+-,@=", c) != nullptr; };
    if (!text.empty() && std::ranges::all_of(text, is_plain))
        return text;
    std::string result = "'";
    for (const char c : text)
        result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

std::string script_problem(const std::string& name, const std::string& text)
{
    const std::string shown = harmless(text, LineEnds::none);
    return shown == text ? "" : name + ": '" + shown + "' goes into a script, and must be UTF-8 text without control characters";
}

}  // namespace fresco::host
