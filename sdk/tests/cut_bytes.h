#pragma once

#include "catch.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

/// CHECKs that `parse` refuses the bytes cut anywhere, and names `source`: after each of the first and last 600 bytes, and after
/// every 200th part between.
template <class Parse>
void check_cuts_are_refused(std::span<const std::byte> whole, const std::string& source, const Parse& parse)
{
    constexpr std::size_t near = 600;
    const std::size_t step = std::max<std::size_t>(whole.size() / 200, 1);
    for (std::size_t size = 0; size < whole.size(); size += size < near || size + step + near > whole.size() ? 1 : step)
    {
        INFO("the first " << size << " of " << whole.size() << " bytes");
        // A copy of exactly this size, so that a sanitizer sees a read beyond it.
        const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
        CHECK_THROWS_WITH(parse(cut), Contains(source));
    }
}
