#pragma once

#include "shared_data.h"

#include <clocale>
#include <locale>

/// As long as it lives, C and C++ write and read numbers with a decimal comma.
class CommaLocale
{
  public:
    /// `test`: what is skipped where the machine has no such locale for C.
    explicit CommaLocale(const std::string& test)
    {
        if (std::setlocale(LC_ALL, "de_DE.UTF-8") == nullptr && std::setlocale(LC_ALL, "fr_FR.UTF-8") == nullptr)
            skipped(test + " where a comma is the decimal point: there is no locale de_DE.UTF-8");
    }
    CommaLocale(const CommaLocale&) = delete;
    CommaLocale& operator=(const CommaLocale&) = delete;
    ~CommaLocale()
    {
        std::locale::global(before_);
        std::setlocale(LC_ALL, before_of_c_.c_str());
    }

  private:
    struct Comma : std::numpunct<char>
    {
        char do_decimal_point() const override { return ','; }
        char do_thousands_sep() const override { return '.'; }
        std::string do_grouping() const override { return "\3"; }
    };

    std::string before_of_c_ = std::setlocale(LC_ALL, nullptr);
    std::locale before_ = std::locale::global(std::locale(std::locale::classic(), new Comma));
};
