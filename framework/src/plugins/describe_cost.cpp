#include "plugins/describe_cost.h"
#include "plugins/declaration.h"
#include <fresco/error.h>

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <string_view>

namespace fresco::host
{
namespace
{

/// Holds a cost to the options that its stage has.
class CostDescriber
{
  public:
    CostDescriber(const std::string& type, const Value& options) : type_(type), options_(options) {}

    Value operator()(const CostRates& rates) const
    {
        return Value::Map{number("fixed", rates.fixed),         number("per_core", rates.per_core),
                          number("per_frame", rates.per_frame), number("per_face", rates.per_face),
                          number("per_texel", rates.per_texel), number("per_pixel", rates.per_pixel),
                          number("per_step", rates.per_step)};
    }

    Value operator()(const CostSize& size) const
    {
        if (size == CostSize{})
            return {};
        check("a size", size.squares_of, {"int", "number", "ints", "numbers"});
        for (const auto& options : {std::vector{size.option, size.at_most}, size.times, size.divided_by})
            for (const std::string& option : options)
                check("a size", option, {"int", "number"});
        check("a size", size.files, {"input_folder", "input_file"});
        return Value::Map{number("number", size.number),
                          {"option", size.option},
                          {"squares_of", size.squares_of},
                          {"files", size.files},
                          {"pattern", size.pattern},
                          number("bytes_each", size.bytes_each),
                          {"times", Value::List(size.times.begin(), size.times.end())},
                          {"divided_by", Value::List(size.divided_by.begin(), size.divided_by.end())},
                          {"at_most", size.at_most}};
    }

    Value device(const std::string& option) const
    {
        check("the device", option, {"bool", "text"});
        return option;
    }

    Value::Entry number(const char* name, double number, double most = std::numeric_limits<double>::max()) const
    {
        if (!(number >= 0 && number <= most))
            fail(std::string(name) + " is " + number_text(number) + "; expected a number from 0 to " + number_text(most));
        return {name, number};
    }

  private:
    [[noreturn]] void fail(const std::string& why) const { throw Error(type_ + ": cost(): " + why); }

    void check(const char* what, const std::string& name, std::initializer_list<std::string_view> kinds) const
    {
        if (name.empty())
            return;
        const auto& all = options_.as_list();
        const auto option =
            std::ranges::find_if(all, [&](const Value& candidate) { return candidate.at("name").as_string() == name; });
        if (option == all.end())
            fail("the stage has no option \"" + name + "\"");
        const std::string& kind = option->at("kind").as_string();
        if (std::ranges::find(kinds, kind) == kinds.end())
            fail(std::string(what) + " cannot be read from the option \"" + name + "\", whose kind is " + kind);
    }

    const std::string& type_;
    const Value& options_;
};

}  // namespace

Value describe_cost(const std::string& type, const Cost& cost, const Value& options)
{
    const CostDescriber described(type, options);
    return Value::Map{{"seconds", described(cost.seconds)},     described.number("parallel_share", cost.parallel_share, 1),
                      {"memory_mb", described(cost.memory_mb)}, {"disk_mb", described(cost.disk_mb)},
                      {"frames", described(cost.frames)},       {"faces", described(cost.faces)},
                      {"texels", described(cost.texels)},       {"pixels", described(cost.pixels)},
                      {"steps", described(cost.steps)},         {"device", described.device(cost.device)}};
}

}  // namespace fresco::host
