#pragma once

#include "report/report.h"

#include <string>

namespace fresco::host
{

/// Of a matrix that has run: writes sweep.json and its page beside the results; prints a line per combination if `print`.
/// `thumbnails`: the stage whose pictures the page shows, see SweepSummaryRequest.
void tell_combinations(const ReportRequest& run, const std::string& thumbnails, bool print);

}  // namespace fresco::host
