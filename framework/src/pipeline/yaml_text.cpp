#include "pipeline/yaml_text.h"

namespace fresco::host
{

std::optional<std::size_t> first_bad_byte(std::string_view text)
{
    for (std::size_t i = 0; i < text.size();)
    {
        const auto byte = static_cast<unsigned char>(text[i]);
        if (byte < 0x80)
        {
            if ((byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r') || byte == 0x7F)
                return i;
            ++i;
            continue;
        }
        const std::size_t length = byte >= 0xF0 ? 4 : byte >= 0xE0 ? 3 : 2;
        if (byte < 0xC2 || byte > 0xF4 || i + length > text.size())
            return i;
        unsigned code = byte & (0x7FU >> length);
        for (std::size_t k = 1; k < length; ++k)
        {
            const auto follow = static_cast<unsigned char>(text[i + k]);
            if ((follow & 0xC0U) != 0x80U)
                return i;
            code = (code << 6U) | (follow & 0x3FU);
        }
        if ((length == 3 && code < 0x800) || (length == 4 && (code < 0x10000 || code > 0x10FFFF)) ||
            (code >= 0xD800 && code <= 0xDFFF))
            return i;
        i += length;
    }
    return std::nullopt;
}

bool quote_is_closed(std::string_view quoted)
{
    const char quote = quoted.front();
    for (std::size_t i = 1; i < quoted.size(); ++i)
    {
        if (quote == '"' && quoted[i] == '\\')
            ++i;
        else if (quoted[i] == quote)
        {
            if (quote == '\'' && i + 1 < quoted.size() && quoted[i + 1] == '\'')
                ++i;
            else
                return true;
        }
    }
    return false;
}

}  // namespace fresco::host
