#include <fresco/configurable.h>
#include <fresco/error.h>
#include <fresco/port.h>

#include <algorithm>

namespace fresco
{

ComponentFactory::~ComponentFactory() = default;

Parameter::Parameter(Configurable* owner, std::string name, std::string help) : name_(std::move(name)), help_(std::move(help))
{
    owner->parameters_.push_back(this);
}
Parameter::~Parameter() = default;

Configurable::Configurable() = default;
Configurable::~Configurable() = default;

void Configurable::configure(const Value& options, ComponentFactory& factory)
{
    for (const auto& [name, value] : options.as_map())
    {
        const auto parameter = std::ranges::find_if(parameters_, [&](const Parameter* p) { return p->name() == name; });
        if (parameter == parameters_.end())
            throw Error("unknown option \"" + name + "\"");
        (*parameter)->assign(value, factory);
    }
}

Value Configurable::describe() const
{
    const auto list = [](const auto& members)
    {
        Value::List descriptions;
        for (const auto* member : members)
            descriptions.push_back(member->describe());
        return Value(std::move(descriptions));
    };
    return Value::Map{{"options", list(parameters_)}, {"inputs", list(inputs_)}, {"outputs", list(outputs_)}};
}

}  // namespace fresco
