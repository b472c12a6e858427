#include <fresco/configurable.h>
#include <fresco/error.h>
#include <fresco/port.h>

#include <algorithm>

namespace fresco
{

ComponentFactory::~ComponentFactory() = default;

Parameter::Parameter(Configurable* owner, OptionDeclaration declaration) : declaration_(std::move(declaration))
{
    owner->parameters_.push_back(this);
}
Parameter::~Parameter() = default;

void Parameter::assign(const Value& value, ComponentFactory& factory)
{
    const CheckedValue checked = check_value(declaration_, value);
    if (!checked.problems.empty())
    {
        const ValueProblem& problem = checked.problems.front();
        throw Error("option \"" + name() +
                    "\": " + (problem.wrong.empty() ? to_json(value) + " is not accepted" : problem.wrong) +
                    (problem.expected.empty() ? "" : "; expected " + problem.expected));
    }
    set(checked.value, factory);
}

Configurable::Configurable() = default;
Configurable::~Configurable() = default;

void Configurable::configure(const Value& options, ComponentFactory& factory)
{
    for (const auto& [name, value] : options.as_map())
    {
        const auto parameter =
            std::ranges::find_if(parameters_, [&wanted = name](const Parameter* p) { return p->name() == wanted; });
        if (parameter == parameters_.end())
            throw Error("unknown option \"" + name + "\"");
        (*parameter)->assign(value, factory);
    }
}

Value Configurable::describe() const
{
    Value::List options;
    for (const Parameter* parameter : parameters_)
        options.push_back(parameter->declaration().describe());
    const auto list = [](const auto& ports)
    {
        Value::List descriptions;
        for (const auto* port : ports)
            descriptions.push_back(port->describe());
        return Value(std::move(descriptions));
    };
    return Value::Map{{"options", std::move(options)}, {"inputs", list(inputs_)}, {"outputs", list(outputs_)}};
}

}  // namespace fresco
