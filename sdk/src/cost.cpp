#include <fresco/error.h>
#include <fresco/plugin_library.h>
#include <fresco/stage.h>
#include <fresco/wording.h>

#include <algorithm>
#include <initializer_list>
#include <limits>

namespace fresco
{
namespace
{

/// Holds a cost to the options that its stage has, and gathers what it counts by.
class CostDescriber
{
  public:
    CostDescriber(const std::string& type, const Value& options) : type_(type), options_(options) {}

    Value operator()(const CostRates& rates)
    {
        Value::Map per;
        for (const CostRate& rate : rates.per)
        {
            add(rate.of);
            per.push_back(number(std::string(rate.of.name), rate.each));
        }
        return Value::Map{number("fixed", rates.fixed),
                          number("per_core", rates.per_core),
                          {"per", std::move(per)},
                          number("per_step", rates.per_step)};
    }

    Value operator()(const CostSize& size)
    {
        if (size == CostSize{})
            return {};
        check("a size", size.squares_of, {"int", "number", "ints", "numbers"});
        for (const auto& options : {std::vector{size.option, size.at_most}, size.times, size.divided_by})
            for (const std::string& option : options)
                check("a size", option, {"int", "number"});
        check("a size", size.files, {"input_folder", "input_file"});
        if (size.brought)
            add(*size.brought);
        return Value::Map{number("number", size.number),
                          {"option", size.option},
                          {"squares_of", size.squares_of},
                          {"files", size.files},
                          {"pattern", size.pattern},
                          number("bytes_each", size.bytes_each),
                          {"brought", size.brought ? size.brought->name : ""},
                          {"times", Value::List(size.times.begin(), size.times.end())},
                          {"divided_by", Value::List(size.divided_by.begin(), size.divided_by.end())},
                          {"at_most", size.at_most}};
    }

    Value operator()(const std::vector<MadeSize>& makes)
    {
        Value::Map described;
        for (const MadeSize& made : makes)
        {
            add(made.of);
            described.emplace_back(std::string(made.of.name), (*this)(made.size));
        }
        return described;
    }

    Value device(const std::string& option) const
    {
        check("the device", option, {"bool", "text"});
        return option;
    }

    Value::Entry number(const std::string& name, double number, double most = std::numeric_limits<double>::max()) const
    {
        if (!(number >= 0 && number <= most))
            fail(name + " is " + number_text(number) + "; expected a number from 0 to " + number_text(most));
        return {name, number};
    }

    Value steps(const Cost& cost)
    {
        const CostSize& steps = cost.steps;
        const bool is_counted = steps.number > 0 || steps.brought || !(steps.option + steps.squares_of + steps.files).empty();
        const bool is_needed = cost.seconds.per_step + cost.memory_mb.per_step + cost.disk_mb.per_step > 0;
        if (!is_counted && (is_needed || steps != CostSize{}))
            fail("nothing says how many steps there are: set .number, .option, .squares_of, .files or .brought of steps");
        return (*this)(steps);
    }

    Value counts() const { return counts_; }

  private:
    [[noreturn]] void fail(const std::string& why) const { throw Error(type_ + ": cost(): " + why); }

    void add(const Counted& counted)
    {
        if (counted.each_of != nullptr)
            add(*counted.each_of);
        counts_.set(counted.name, Value::Map{number("assumed", counted.assumed),
                                             {"carried_by", counted.carried_by},
                                             {"also_carried_by", counted.also_carried_by},
                                             {"each_of", counted.each_of != nullptr ? counted.each_of->name : ""},
                                             number("in_square", counted.in_square)});
    }

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
    Value counts_ = Value::Map{};
};

}  // namespace

Value describe_cost(const std::string& type, const Cost& cost, const Value& options)
{
    CostDescriber described(type, options);
    Value description =
        Value::Map{{"seconds", described(cost.seconds)},     described.number("parallel_share", cost.parallel_share, 1),
                   {"memory_mb", described(cost.memory_mb)}, {"disk_mb", described(cost.disk_mb)},
                   {"makes", described(cost.makes)},         {"steps", described.steps(cost)},
                   {"device", described.device(cost.device)}};
    description.set("counts", described.counts());
    return description;
}

}  // namespace fresco
