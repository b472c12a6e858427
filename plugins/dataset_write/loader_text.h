#pragma once

#include <string_view>

/// The module that stands in every dataset: plugins/dataset_write/fresco_dataset.py, as it was when the plugin was built.
inline constexpr const char* loader_name = "fresco_dataset.py";
std::string_view loader_text();
