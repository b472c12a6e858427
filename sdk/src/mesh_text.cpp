#include "mesh_text.h"

namespace fresco::detail
{

std::string in_quotes(std::string_view word)
{
    std::string text = "'";
    for (const char c : word.substr(0, 40))
        text += (c >= ' ' && c <= '~') ? c : '?';
    return text + (word.size() > 40 ? "...'" : "'");
}

}  // namespace fresco::detail
