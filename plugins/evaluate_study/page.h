#pragma once

#include "study.h"

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace study
{

/// "data:image/jpeg;base64,…"
std::string data_uri(std::string_view media_type, std::span<const std::byte> bytes);

/// The page that shows the study: one HTML file that needs nothing else and names no method. `pictures`: their data URIs, by
/// number.
std::string page(const Study& study, const std::vector<std::string>& pictures);

}  // namespace study
