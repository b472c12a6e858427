#pragma once

#include "study.h"

#include <string>
#include <vector>

namespace study
{

/// The page that shows the study: one HTML file that needs nothing else and names no method. `pictures`: their data URIs, by
/// number.
std::string page(const Study& study, const std::vector<std::string>& pictures);

}  // namespace study
