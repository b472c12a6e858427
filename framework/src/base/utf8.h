#pragma once

#include <cstddef>
#include <string_view>

namespace fresco::host
{

/// Bytes of the UTF-8 character that begins at `at`; 0 if none does.
std::size_t utf8_length(std::string_view text, std::size_t at);
bool is_utf8(std::string_view text);

}  // namespace fresco::host
