#include <fresco/error.h>
#include <fresco/port.h>

namespace fresco
{

Artifact::~Artifact() = default;

Port::Port(std::string name, const ArtifactType& type, bool is_optional, std::string help)
    : name_(std::move(name)), type_(type), optional_(is_optional), help_(std::move(help))
{
}
Port::~Port() = default;

Value Port::describe() const
{
    Value description = Value::Map{{"name", name_}, {"artifact", type_.name}, {"version", type_.version}};
    if (const auto forms = type_.form_names(); !forms.empty())
        description.set("as", Value::List(forms.begin(), forms.end()));
    if (!type_.parts_file.empty())
        description.set("parts_file", type_.parts_file);
    if (optional_)
        description.set("optional", true);
    description.set("help", help_);
    return description;
}

InputPort::InputPort(Configurable* owner, std::string name, const ArtifactType& type, bool is_optional, std::string help)
    : Port(std::move(name), type, is_optional, std::move(help))
{
    owner->inputs_.push_back(this);
}

void InputPort::not_wired() const
{
    throw Error("input \"" + name() + "\" is not wired");
}

void InputPort::wrong_type() const
{
    throw Error("input \"" + name() + "\" takes " + type().name + ", got another type");
}

OutputPort::OutputPort(Configurable* owner, std::string name, const ArtifactType& type, bool is_optional, std::string help,
                       std::vector<std::string> parts)
    : Port(std::move(name), type, is_optional, std::move(help)), parts_(std::move(parts))
{
    owner->outputs_.push_back(this);
}

Value OutputPort::describe() const
{
    Value description = Port::describe();
    if (!parts_.empty())
        description.set("parts", Value::List(parts_.begin(), parts_.end()));
    return description;
}

void OutputPort::no_value() const
{
    throw Error("the stage ended without giving its output \"" + name() + "\"");
}

}  // namespace fresco
