#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

/// The class of an NYU40 id, 1 to 40, as ScanNet's `.labels.ply` has them; nothing for others.
std::optional<std::string_view> nyu40_name(std::int64_t id);
