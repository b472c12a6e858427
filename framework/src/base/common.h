#pragma once

#include <fresco/error.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <ranges>
#include <type_traits>
#include <vector>

/// \file What is written everywhere in the host: lists made of lists, and errors that are as good as no answer.

namespace fresco::host
{

namespace fs = std::filesystem;

/// Maps `items` by `make`, a function or a member, in their order: each(stages, &PipelineStage::name), or, as
/// values of another type, each<Value>(stages, stage_value).
template <class As = void, class Items, class Make>
auto each(const Items& items, const Make& make)
{
    using Result = std::remove_cvref_t<std::invoke_result_t<const Make&, std::ranges::range_reference_t<const Items&>>>;
    std::vector<std::conditional_t<std::is_void_v<As>, Result, As>> made;
    if constexpr (std::ranges::sized_range<const Items&>)
        made.reserve(std::ranges::size(items));
    for (const auto& item : items)
        made.push_back(std::invoke(make, item));
    return made;
}

/// Result of `make`, or nothing if it throws Error. For a function without a result: whether it finished.
template <class Make>
auto attempt(const Make& make)
{
    using Result = std::remove_cvref_t<std::invoke_result_t<const Make&>>;
    constexpr bool is_action = std::is_void_v<Result>;
    std::conditional_t<is_action, bool, std::optional<std::conditional_t<is_action, bool, Result>>> made{};
    try
    {
        if constexpr (is_action)
            made = (make(), true);
        else
            made = make();
    }
    catch (const Error&)
    {
        made = {};
    }
    return made;
}

}  // namespace fresco::host
