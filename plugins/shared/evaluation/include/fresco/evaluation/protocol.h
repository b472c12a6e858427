#pragma once

#include <string_view>

namespace fresco::evaluation
{

/// Which definitions are measured by: the paper's with fresco's completions, or what the authors' released scripts do.
enum class Protocol
{
    paper,
    released
};

/// \pre `word` is "paper" or "released": the accepted words of an option.
constexpr Protocol protocol_of(std::string_view word)
{
    return word == "paper" ? Protocol::paper : Protocol::released;
}

}  // namespace fresco::evaluation
