#pragma once

#include <fresco/value.h>

#include <string>
#include <string_view>

/// One HTML file that shows a room and fetches nothing. `data`: {room, cameras, up} as showRoom of plugins/shared/page takes
/// them; cameras and up may be null. `title`: of the window.
std::string room_page(const fresco::Value& data, std::string_view title);
