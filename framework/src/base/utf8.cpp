#include "base/utf8.h"

namespace fresco::host
{

std::size_t utf8_length(std::string_view text, std::size_t at)
{
    const auto byte = static_cast<unsigned char>(text[at]);
    if (byte < 0x80)
        return 1;
    const std::size_t length = byte >= 0xF0 ? 4 : byte >= 0xE0 ? 3 : 2;
    if (byte < 0xC2 || byte > 0xF4 || at + length > text.size())
        return 0;
    unsigned code = byte & (0x7FU >> length);
    for (std::size_t k = 1; k < length; ++k)
    {
        const auto follow = static_cast<unsigned char>(text[at + k]);
        if ((follow & 0xC0U) != 0x80U)
            return 0;
        code = (code << 6U) | (follow & 0x3FU);
    }
    const bool too_long = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
    return too_long || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF) ? 0 : length;
}

bool is_utf8(std::string_view text)
{
    for (std::size_t at = 0; at < text.size();)
    {
        const std::size_t length = utf8_length(text, at);
        if (length == 0)
            return false;
        at += length;
    }
    return true;
}

}  // namespace fresco::host
