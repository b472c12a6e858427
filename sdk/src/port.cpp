#include <fresco/error.h>
#include <fresco/port.h>

namespace fresco
{

Artifact::~Artifact() = default;

InputPort::InputPort(Configurable* owner, std::string name, std::string_view artifact, int version, bool is_optional,
                     bool has_preview, std::string help)
    : name_(std::move(name)), artifact_(artifact), version_(version), optional_(is_optional), has_preview_(has_preview),
      help_(std::move(help))
{
    owner->inputs_.push_back(this);
}
InputPort::~InputPort() = default;

Value InputPort::describe() const
{
    Value description = Value::Map{{"name", name_}, {"artifact", artifact_}, {"version", version_}};
    if (optional_)
        description.set("optional", true);
    if (has_preview_)
        description.set("preview", true);
    description.set("help", help_);
    return description;
}

void InputPort::not_wired() const
{
    throw Error("input \"" + name_ + "\" is not wired");
}

void InputPort::wrong_type() const
{
    throw Error("input \"" + name_ + "\" takes " + artifact_ + ", got another type");
}

OutputPort::OutputPort(Configurable* owner, std::string name, std::string_view artifact, int version, bool has_preview,
                       std::string help)
    : name_(std::move(name)), artifact_(artifact), version_(version), has_preview_(has_preview), help_(std::move(help))
{
    owner->outputs_.push_back(this);
}
OutputPort::~OutputPort() = default;

Value OutputPort::describe() const
{
    Value description = Value::Map{{"name", name_}, {"artifact", artifact_}, {"version", version_}};
    if (has_preview_)
        description.set("preview", true);
    description.set("help", help_);
    return description;
}

void OutputPort::no_value() const
{
    throw Error("the stage ended without giving its output \"" + name_ + "\"");
}

}  // namespace fresco
