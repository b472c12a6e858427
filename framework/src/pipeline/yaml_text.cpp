#include "pipeline/yaml_text.h"
#include "base/utf8.h"

namespace fresco::host
{

std::optional<std::size_t> first_bad_byte(std::string_view text)
{
    for (std::size_t i = 0; i < text.size();)
    {
        const auto byte = static_cast<unsigned char>(text[i]);
        const std::size_t length = utf8_length(text, i);
        if (length == 0 || byte == 0x7F || (byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r'))
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
