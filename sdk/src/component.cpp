#include <fresco/component.h>
#include <fresco/image_io.h>
#include <fresco/reader.h>
#include <fresco/stage.h>

namespace fresco
{

Component::~Component() = default;
ImageIo::~ImageIo() = default;

ImageHeader ImageIo::check(const std::filesystem::path& file) const
{
    return header(file);
}

Raster8 ImageIo::read_with_alpha(const std::filesystem::path& file) const
{
    return read_rgb(file);
}
FileReader::~FileReader() = default;
Stage::~Stage() = default;

Cost Stage::cost() const
{
    return {};
}

namespace detail
{
namespace
{

/// "image.opencv" is short for {"type": "image.opencv"}.
Value parsed_default(const std::string& text)
{
    if (text.empty())
        return {};
    if (text.front() == '{')
        return parse_json(text, "default of a slot");
    if (text == "auto")
        return text;
    return Value::Map{{"type", text}};
}

}  // namespace

SlotBase::SlotBase(Configurable* owner, std::string name, std::string kind, std::string default_config, bool many,
                   bool is_optional, std::string help)
    : Parameter(owner, std::move(name), std::move(help)), kind_(std::move(kind)), default_(parsed_default(default_config)),
      many_(many), optional_(is_optional)
{
}

SlotBase::~SlotBase() = default;

Value SlotBase::describe() const
{
    Value description = Value::Map{{"name", name()}, {"kind", many_ ? "components" : "component"}, {"component_kind", kind_}};
    if (!default_.is_null())
        description.set("default", default_);
    if (optional_ || (!many_ && default_.is_null()))
        description.set("optional", true);
    if (!auto_option_.empty())
        description.set("auto", Value::Map{{"option", auto_option_}, {"if_empty", auto_if_empty_}, {"if_set", auto_if_set_}});
    description.set("help", help());
    return description;
}

std::shared_ptr<Component> SlotBase::make(const Value& config, ComponentFactory& factory) const
{
    return factory.create(kind_, config);
}

void SlotBase::wrong_contract(const Value& config) const
{
    throw Error("option \"" + name() + "\": " + to_json(config) + " does not make a component of kind " + kind_);
}

void SlotBase::not_assigned() const
{
    throw Error("option \"" + name() + "\": no component of kind " + kind_ + "; set one by its type");
}

}  // namespace detail
}  // namespace fresco
