#pragma once

#include <string>

namespace fresco::host
{

/// "1:02:03", "2:03", "41 s".
std::string duration_text(double seconds);
/// "12.3 s", "350 MB": for tables.
std::string size_text(double megabytes);

}  // namespace fresco::host
