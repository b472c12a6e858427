#pragma once

#include "report/report_model.h"

#include <fresco/image_io.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace fresco::host
{

/// `count` numbers below `size`, evenly spread, ascending; all where there are no more.
std::vector<std::size_t> evenly_spread(std::size_t size, std::size_t count);

/// Loads, shrinks and encodes what there is to look at among the results of a run. What cannot be shown is named in the notes.
ReportMedia report_media(const ReportModel& model, const ImageIo& images);

}  // namespace fresco::host
