#pragma once

#include <fresco/option.h>

#include <string>
#include <utility>
#include <vector>

/// \file Options that are one of a few words, as C++ enumerations: so that no stage compares words.

namespace fresco
{

/// A text option whose words stand for the values of an enumeration: `*option` is that value.
template <class Enum>
class Choice final
{
  public:
    using Words = std::vector<std::pair<std::string, Enum>>;
    Choice(Configurable* owner, std::string name, Enum value, const Words& words, std::string help)
        : words_(words), option_(owner, std::move(name), word(value), accepted(), std::move(help))
    {
    }

    Enum operator*() const
    {
        for (const auto& [word, value] : words_)
            if (word == *option_)
                return value;
        return words_.front().second;
    }

  private:
    std::string word(Enum value) const
    {
        for (const auto& [word, of_word] : words_)
            if (of_word == value)
                return word;
        return {};
    }
    OneOf accepted() const
    {
        OneOf result;
        for (const auto& [word, value] : words_)
            result.words.push_back(word);
        return result;
    }

    Words words_;
    Option<std::string> option_;
};

}  // namespace fresco
