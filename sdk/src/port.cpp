#include <fresco/error.h>
#include <fresco/port.h>

namespace fresco
{

Artifact::~Artifact() = default;

namespace
{
Value described(const std::string& name, const ArtifactType& type, bool is_optional, const std::string& help)
{
    Value description = Value::Map{{"name", name}, {"artifact", type.name}, {"version", type.version}};
    if (const auto forms = type.form_names(); !forms.empty())
        description.set("as", Value::List(forms.begin(), forms.end()));
    if (!type.parts_file.empty())
        description.set("parts_file", type.parts_file);
    if (is_optional)
        description.set("optional", true);
    description.set("help", help);
    return description;
}
}  // namespace

InputPort::InputPort(Configurable* owner, std::string name, const ArtifactType& type, bool is_optional, std::string help)
    : name_(std::move(name)), type_(type), optional_(is_optional), help_(std::move(help))
{
    owner->inputs_.push_back(this);
}
InputPort::~InputPort() = default;

Value InputPort::describe() const
{
    return described(name_, type_, optional_, help_);
}

void InputPort::not_wired() const
{
    throw Error("input \"" + name_ + "\" is not wired");
}

void InputPort::wrong_type() const
{
    throw Error("input \"" + name_ + "\" takes " + type_.name + ", got another type");
}

OutputPort::OutputPort(Configurable* owner, std::string name, const ArtifactType& type, bool is_optional, std::string help,
                       std::vector<std::string> parts)
    : name_(std::move(name)), type_(type), optional_(is_optional), help_(std::move(help)), parts_(std::move(parts))
{
    owner->outputs_.push_back(this);
}
OutputPort::~OutputPort() = default;

Value OutputPort::describe() const
{
    Value description = described(name_, type_, optional_, help_);
    if (!parts_.empty())
        description.set("parts", Value::List(parts_.begin(), parts_.end()));
    return description;
}

void OutputPort::no_value() const
{
    throw Error("the stage ended without giving its output \"" + name_ + "\"");
}

}  // namespace fresco
