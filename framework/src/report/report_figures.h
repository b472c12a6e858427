#pragma once

#include <fresco/value.h>

#include <string>
#include <string_view>
#include <vector>

namespace fresco::host
{

/// One figure of a stage's report, in words.
struct ReportFigure
{
    std::string label;
    std::string value;
    std::string before;  ///< Empty where the stage reports no figure of what it was given.
    std::string change;  ///< "−38.5 %", where there is one before and the change is a number.
};

/// The numbers, texts and truth values of a report, maps of them included; lists and the "table" are passed over. `X_before` and
/// `X_after` become one figure. The unit is read off the name: _share, _m, _m2, _cm, _px, _deg, _mb, _s, bytes, seconds.
std::vector<ReportFigure> report_figures(const Value& report);

/// What a stage reports as "table" — {columns: [name, …], rows: [[text or number, …], …]} — as an HTML table; nothing without
/// rows.
std::string report_table(const Value& report);

/// With thin spaces between thousands, or four significant digits.
std::string figure_text(const Value& number);

/// "412 bytes", "3.1 kB", "12.3 MB", of 1000 each.
std::string bytes_text(double bytes);

}  // namespace fresco::host
