#include "plugins/catalog.h"
#include "base/common.h"
#include <fresco/error.h>

#include <algorithm>
#include <initializer_list>
#include <limits>

namespace fresco::host
{

void Catalog::add(TypeDescription description)
{
    std::vector<TypeDescription>& same = types_[description.type];
    if (!same.empty() && same.front().place < description.place)
    {
        shadowed_.emplace(description.type, description.library);
        return;
    }
    if (!same.empty() && same.front().place > description.place)
    {
        for (const TypeDescription& later : same)
            shadowed_.emplace(later.type, later.library);
        same.clear();
    }
    same.push_back(std::move(description));
}

const UnbuiltPlugin* Catalog::find_unbuilt(std::string_view type) const
{
    const auto found = std::ranges::find(unbuilt_, type, &UnbuiltPlugin::type);
    return found != unbuilt_.end() ? &*found : nullptr;
}

const TypeDescription* Catalog::find(std::string_view type) const
{
    const auto found = types_.find(type);
    return found != types_.end() && found->second.size() == 1 ? &found->second.front() : nullptr;
}

std::vector<const TypeDescription*> Catalog::types(std::string_view kind) const
{
    std::vector<const TypeDescription*> result;
    for (const auto& [name, descriptions] : types_)
        if (descriptions.size() == 1 && (kind.empty() || descriptions.front().kind == kind))
            result.push_back(&descriptions.front());
    return result;
}

std::vector<std::string> Catalog::ambiguous() const
{
    std::vector<std::string> names;
    for (const auto& [name, descriptions] : types_)
        if (descriptions.size() > 1)
            names.push_back(name);
    return names;
}

std::vector<ShadowedType> Catalog::shadowed() const
{
    std::vector<ShadowedType> all;
    for (const auto& [type, library] : shadowed_)
        all.push_back({type, library, types_.find(type)->second.front().library});
    return all;
}

std::vector<std::filesystem::path> Catalog::libraries_of(std::string_view type) const
{
    const auto found = types_.find(type);
    return found == types_.end() ? std::vector<std::filesystem::path>() : each(found->second, &TypeDescription::library);
}

namespace
{

std::string text_at(const Value& map, std::string_view key)
{
    const Value* entry = map.find(key);
    return entry ? entry->as_string() : std::string();
}

std::vector<std::string> texts_at(const Value& map, std::string_view key)
{
    const Value* list = map.find(key);
    return list ? each(list->as_list(), &Value::as_string) : std::vector<std::string>();
}

std::vector<PortDeclaration> read_ports(const Value& declaration, std::string_view key)
{
    std::vector<PortDeclaration> ports;
    if (const Value* list = declaration.find(key))
        for (const Value& description : list->as_list())
        {
            const Value* version = description.find("version");
            const Value* optional = description.find("optional");
            ports.push_back({description.at("name").as_string(), description.at("artifact").as_string(),
                             version ? static_cast<int>(version->as_int()) : 1, optional && optional->as_bool(),
                             text_at(description, "help"), texts_at(description, "parts")});
        }
    return ports;
}

template <class T>
const T* by_name(const std::vector<T>& list, std::string_view name)
{
    const auto found = std::ranges::find(list, name, &T::name);
    return found == list.end() ? nullptr : &*found;
}

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

std::string PortDeclaration::artifact_text() const
{
    return version == 1 ? artifact : artifact + " (version " + std::to_string(version) + ")";
}

const OptionDeclaration* TypeDeclaration::option(std::string_view name) const
{
    return by_name(options, name);
}

const PortDeclaration* TypeDeclaration::input(std::string_view name) const
{
    return by_name(inputs, name);
}

const PortDeclaration* TypeDeclaration::output(std::string_view name) const
{
    return by_name(outputs, name);
}

std::vector<std::string> TypeDeclaration::option_names() const
{
    return each(options, &OptionDeclaration::name);
}

TypeDeclaration read_declaration(const TypeDescription& type)
{
    try
    {
        TypeDeclaration result;
        if (const Value* options = type.declaration.find("options"))
            result.options = each(options->as_list(), OptionDeclaration::from);
        result.inputs = read_ports(type.declaration, "inputs");
        result.outputs = read_ports(type.declaration, "outputs");
        result.artifact = text_at(type.declaration, "artifact");
        result.extensions = texts_at(type.declaration, "extensions");
        if (const Value* formats = type.declaration.find("formats"))
            result.formats = each(formats->as_list(), FileFormat::from);
        return result;
    }
    catch (const Error& error)
    {
        throw Error(type.library.string() + ": the description of '" + type.type + "' is not as expected: " + error.what());
    }
}

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

}  // namespace fresco::host
