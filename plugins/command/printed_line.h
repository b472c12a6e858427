#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace fresco::command
{

/// Message of a program to the host: a line of its own that begins with "fresco: ".
struct SaidToHost
{
    enum class Kind
    {
        progress,
        metric,
        warning,
        message,
        report
    };
    Kind kind = Kind::message;
    double done = 0;   ///< Progress so far; the value of a metric.
    double total = 0;  ///< 0: unknown.
    std::string text;  ///< Unit of progress, name of a metric or report entry, or the text.
    std::string json;  ///< Report entry.
};

/// "fresco: progress 0.35" (a share), "fresco: progress 12/100 frames", "fresco: metric loss 0.5", "fresco: warning TEXT",
/// "fresco: message TEXT", "fresco: report NAME JSON"; nothing for every other line.
std::optional<SaidToHost> said_to_host(std::string_view line);

/// A line of a program as it may be shown: what a terminal would show after the last carriage return, without control characters
/// and escape sequences; bytes that are no UTF-8 become '?'.
std::string printable(std::string_view line);

}  // namespace fresco::command
