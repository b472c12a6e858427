#pragma once

#include <fresco/value.h>

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

/// \file For stages and the host where they write pages that need nothing else.

namespace fresco
{

/// RFC 4648, section 4, padded, in one line.
std::string base64(std::span<const std::byte> bytes);

/// "data:image/jpeg;base64,…"
std::string data_uri(std::string_view media_type, std::span<const std::byte> bytes);

/// JSON that may stand in a script element: no "<" in it could end that.
std::string script_json(const Value& value);

}  // namespace fresco
