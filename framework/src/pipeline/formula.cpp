#include "pipeline/formula.h"
#include <fresco/error.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

namespace fresco::host
{
namespace
{
constexpr std::size_t longest_formula = 1000;
constexpr int deepest_nesting = 32;

bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/// Recursive descent: sum → product → factor.
class Parser
{
  public:
    Parser(std::string_view text, FormulaNames& names) : text_(text), names_(names) {}

    double parse()
    {
        if (text_.size() > longest_formula)
            throw Error("a formula of " + std::to_string(text_.size()) + " characters is too long");
        const double result = sum();
        if (peek() != '\0')
            fail("an operator is expected before '" + std::string(1, peek()) + "'");
        return result;
    }

  private:
    [[noreturn]] void fail(const std::string& why) const
    {
        throw Error("formula '" + std::string(text_.substr(0, longest_formula)) + "', character " + std::to_string(at_ + 1) +
                    ": " + why);
    }

    /// The next character that is no space; 0 at the end.
    char peek()
    {
        while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n'))
            ++at_;
        return at_ < text_.size() ? text_[at_] : '\0';
    }

    bool take(char c)
    {
        if (peek() != c)
            return false;
        ++at_;
        return true;
    }

    void expect(char c)
    {
        if (!take(c))
            fail(std::string("'") + c + "' is expected");
    }

    double finite(double value) const
    {
        if (!std::isfinite(value))
            fail("the result is larger than any number");
        return value;
    }

    double sum()
    {
        double value = product();
        while (true)
        {
            if (take('+'))
                value = finite(value + product());
            else if (take('-'))
                value = finite(value - product());
            else
                return value;
        }
    }

    double product()
    {
        double value = factor();
        while (true)
        {
            if (take('*'))
                value = finite(value * factor());
            else if (take('/'))
            {
                const std::size_t start = at_;
                const double divisor = factor();
                if (divisor == 0)
                {
                    at_ = start;
                    fail("division by zero");
                }
                value = finite(value / divisor);
            }
            else
                return value;
        }
    }

    double factor()
    {
        if (++depth_ > deepest_nesting)
            fail("nested too deep");
        double value = 0;
        if (take('-'))
            value = -factor();
        else if (take('('))
        {
            value = sum();
            expect(')');
        }
        else if (is_letter(peek()))
            value = name_or_call();
        else
            value = number();
        --depth_;
        return value;
    }

    double number()
    {
        if (!is_digit(peek()) && peek() != '.')
            fail(peek() == '\0' ? "a number or name is expected at the end" : "a number or name is expected");
        double value = 0;
        const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
        if (error != std::errc())
            fail("this is no number");
        at_ = static_cast<std::size_t>(end - text_.data());
        return value;
    }

    std::string_view word()
    {
        peek();
        const std::size_t start = at_;
        while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_])))
            ++at_;
        return text_.substr(start, at_ - start);
    }

    double name_or_call()
    {
        const std::size_t start = at_;
        const std::string_view name = word();
        if (peek() == '(')
            return call(name, start);
        const std::optional<double> value = names_.value(name);
        if (!value)
        {
            at_ = start;
            fail("'" + std::string(name) + "' is no name that has a number");
        }
        return finite(*value);
    }

    double call(std::string_view function, std::size_t start)
    {
        expect('(');
        if (function == "count" || function == "bytes")
            return measure(function, start);
        if (function != "min" && function != "max")
        {
            at_ = start;
            fail("there is no function '" + std::string(function) + "' (there are: min, max, count, bytes)");
        }
        double value = sum();
        while (take(','))
            value = function == "min" ? std::min(value, sum()) : std::max(value, sum());
        expect(')');
        return value;
    }

    double measure(std::string_view function, std::size_t start)
    {
        peek();
        const std::string_view option = word();
        if (option.empty())
            fail("the name of an option is expected");
        std::string_view glob;
        if (take(','))
        {
            expect('"');
            const std::size_t end = text_.find('"', at_);
            if (end == std::string_view::npos)
                fail("this quote is never closed");
            glob = text_.substr(at_, end - at_);
            at_ = end + 1;
        }
        expect(')');
        const std::optional<double> value = function == "count" ? names_.count(option, glob) : names_.bytes(option, glob);
        if (!value)
        {
            at_ = start;
            fail("'" + std::string(option) + "' is no option that holds a file or folder");
        }
        return finite(*value);
    }

    std::string_view text_;
    FormulaNames& names_;
    std::size_t at_ = 0;
    int depth_ = 0;
};
}  // namespace

double evaluate_formula(std::string_view formula, FormulaNames& names)
{
    return Parser(formula, names).parse();
}

}  // namespace fresco::host
