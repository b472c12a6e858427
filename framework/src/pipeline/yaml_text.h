#pragma once

#include <yaml-cpp/mark.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace fresco::host
{

/// The text with the byte offsets of its lines.
class Text
{
  public:
    explicit Text(std::string_view text) : text_(text)
    {
        starts_.push_back(0);
        for (std::size_t i = 0; i < text.size(); ++i)
            if (text[i] == '\n')
                starts_.push_back(i + 1);
    }

    std::size_t offset(const YAML::Mark& mark) const
    {
        const auto line = static_cast<std::size_t>(std::max(mark.line, 0));
        if (line >= starts_.size())
            return text_.size();
        return std::min(starts_[line] + static_cast<std::size_t>(std::max(mark.column, 0)), text_.size());
    }

    std::string_view from(const YAML::Mark& mark) const { return text_.substr(offset(mark)); }

    std::string_view line(const YAML::Mark& mark) const
    {
        YAML::Mark first = mark;
        first.column = 0;
        const std::size_t start = offset(first);
        return text_.substr(start, text_.find('\n', start) - start);
    }

    /// Offset of the first such line.
    std::optional<std::size_t> first_longer_than(std::size_t limit) const
    {
        for (std::size_t i = 0; i < starts_.size(); ++i)
            if ((i + 1 < starts_.size() ? starts_[i + 1] - 1 : text_.size()) - starts_[i] > limit)
                return starts_[i];
        return std::nullopt;
    }

    /// Line and column from 1, in characters.
    std::pair<int, int> place(std::size_t offset) const
    {
        const auto next = std::upper_bound(starts_.begin(), starts_.end(), std::min(offset, text_.size()));
        const auto line = static_cast<std::size_t>(next - starts_.begin());
        const std::string_view before = text_.substr(starts_[line - 1], std::min(offset, text_.size()) - starts_[line - 1]);
        const auto characters =
            std::count_if(before.begin(), before.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; });
        return {static_cast<int>(line), static_cast<int>(characters) + 1};
    }

  private:
    std::string_view text_;
    std::vector<std::size_t> starts_;
};

/// Offset of the first control character or invalid UTF-8, if any.
std::optional<std::size_t> first_bad_byte(std::string_view text);

/// Whether a quoted scalar that begins `quoted` ends in it: yaml-cpp takes the end of the file for the closing quote.
bool quote_is_closed(std::string_view quoted);

}  // namespace fresco::host
