#pragma once

#include <cerrno>

namespace fresco
{

/// Makes a system call, again as long as a signal interrupts it. Not for close: Linux has closed the descriptor by then.
template <class Call>
auto uninterrupted(const Call& call)
{
    for (;;)
        if (const auto result = call(); result >= 0 || errno != EINTR)
            return result;
}

}  // namespace fresco
