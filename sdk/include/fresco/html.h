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

/// What a page embeds to show a room (sdk/viewer): showRoom(element, room, {mixture, cameras, up}), of an element with the id
/// "room" and the entries that Preview makes.
struct RoomViewer
{
    std::string_view css;
    std::string_view
        three_js;         ///< three.js with its OrbitControls and its license; empty: it was not found when the SDK was built.
    std::string_view js;  ///< Strict; comes after three_js.
};
RoomViewer room_viewer();

/// JSON that may stand in a script element: no "<" in it could end that.
std::string script_json(const Value& value);

}  // namespace fresco
