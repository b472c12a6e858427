#pragma once

/// \file Catch2, version 2 or 3, under the names of version 2. Included behind libtorch's headers, which have a CHECK of their
/// own.

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>

#include <string>

using Catch::Approx;

namespace Catch
{
using Matchers::EndsWith;
using Matchers::StartsWith;

inline Matchers::StringContainsMatcher Contains(const std::string& part)
{
    return Matchers::ContainsSubstring(part);
}
}  // namespace Catch
#else
#include <catch2/catch.hpp>
#endif

using Catch::Contains;
using Catch::EndsWith;
using Catch::StartsWith;
