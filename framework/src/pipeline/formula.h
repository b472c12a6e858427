#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace fresco::host
{

/// What a formula may ask for.
class FormulaNames
{
  public:
    virtual ~FormulaNames() = default;
    /// The value of a name, or nothing where there is none.
    virtual std::optional<double> value(std::string_view name) = 0;
    /// Files that match `glob` below the folder that the option holds: how many, and their sizes in bytes. Nothing where the
    /// option is unknown or no path.
    virtual std::optional<double> count(std::string_view option, std::string_view glob) = 0;
    virtual std::optional<double> bytes(std::string_view option, std::string_view glob) = 0;
};

/// The value of a formula with numbers, names, + - * / ( ), min(a, b, …), max(a, b, …), count(option, "glob") and
/// bytes(option, "glob"). Throws Error naming the formula and what is wrong in it: a name that is not known, a division by zero,
/// a result that is no finite number, bad grammar, more than 1 000 characters or 32 nested parentheses.
double evaluate_formula(std::string_view formula, FormulaNames& names);

}  // namespace fresco::host
