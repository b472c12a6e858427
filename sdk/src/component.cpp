#include <fresco/component.h>
#include <fresco/error.h>
#include <fresco/hole_closer.h>
#include <fresco/image_io.h>
#include <fresco/port.h>
#include <fresco/reader.h>
#include <fresco/stage.h>
#include <fresco/viewer.h>

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
        const auto parameter = std::ranges::find(parameters_, name, &Parameter::name);
        if (parameter == parameters_.end())
            throw Error("unknown option \"" + name + "\"");
        (*parameter)->assign(value, factory);
    }
}

Value Configurable::describe() const
{
    Value::List options, components;
    for (const Parameter* parameter : parameters_)
        (parameter->declaration().of_pipeline ? components : options).push_back(parameter->declaration().describe());
    const auto list = [](const auto& ports)
    {
        Value::List descriptions;
        for (const auto* port : ports)
            descriptions.push_back(port->describe());
        return Value(std::move(descriptions));
    };
    Value description = Value::Map{{"options", std::move(options)},
                                   {"components", std::move(components)},
                                   {"inputs", list(inputs_)},
                                   {"outputs", list(outputs_)}};
    if (const auto* component = dynamic_cast<const Component*>(this))
        if (const Marks marks = component->marks(); !marks.contains.empty() || !marks.formats.empty())
            description.set("marks", marks.describe());
    return description;
}

Component::~Component() = default;
HoleCloser::~HoleCloser() = default;
ImageIo::~ImageIo() = default;

ImageHeader ImageIo::check(const std::filesystem::path& file) const
{
    return header(file);
}

Raster8 ImageIo::read_with_alpha(const std::filesystem::path& file) const
{
    return read_rgb(file);
}

Raster8 read_picture(const ImageIo& images, const std::filesystem::path& file)
{
    Raster8 picture = images.read_with_alpha(file);
    if (picture.channels != 4)
        return picture;
    for (std::size_t i = 3; i < picture.values.size(); i += 4)
        if (picture.values[i] < least_opaque_alpha)
            return picture;
    return images.read_rgb(file);
}

FileReader::~FileReader() = default;
FileOrigin::~FileOrigin() = default;
Viewer::~Viewer() = default;

void PageEntry::append(std::string_view list, Value entry)
{
    if (value.find(list) == nullptr)
        value.set(list, Value::List{});
    value.find(list)->as_list().push_back(std::move(entry));
}

std::string script_json(const Value& value)
{
    std::string text = to_json(value);
    for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at))
        text.replace(at, 1, "\\u003c");
    return text;
}

std::vector<std::string> FileReader::extensions() const
{
    return all_extensions(formats());
}
Stage::~Stage() = default;

double Stage::memory_mb() const
{
    return 0;
}

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

InputPort::~InputPort() = default;

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

OutputPort::~OutputPort() = default;

void OutputPort::set_folder(ArtifactFolder folder)
{
    folder_ = std::move(folder);
    folder_.references = &references_;
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

namespace detail
{
namespace
{

/// "loss.gram" is short for {"type": "loss.gram"}.
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

SlotBase::SlotBase(Configurable* owner, std::string name, OptionKind kind, std::string_view component_kind,
                   const std::string& default_config, std::string help, std::string chosen_by)
    : Parameter(owner, {.name = std::move(name),
                        .kind = kind,
                        .default_value = parsed_default(default_config),
                        .required = kind == OptionKind::components && default_config.empty(),
                        .component_kind = std::string(component_kind),
                        .optional = kind == OptionKind::component && default_config.empty(),
                        .chosen_by = std::move(chosen_by),
                        .help = std::move(help)})
{
}

SlotBase::SlotBase(Configurable* owner, std::string_view component_kind, std::string_view default_type, bool is_optional,
                   std::string for_form, std::string help)
    : Parameter(owner, {.name = std::string(component_kind),
                        .kind = OptionKind::component,
                        .default_value = Value::Map{{"type", std::string(default_type)}},
                        .component_kind = std::string(component_kind),
                        .optional = is_optional,
                        .of_pipeline = true,
                        .for_form = std::move(for_form),
                        .help = std::move(help)})
{
}

SlotBase::~SlotBase() = default;

std::shared_ptr<Component> SlotBase::make(const Value& config, ComponentFactory& factory) const
{
    return factory.create(declaration_.component_kind, config);
}

void SlotBase::wrong_contract(const Value& config) const
{
    throw Error("option \"" + name() + "\": " + to_json(config) + " does not make a component of kind " +
                declaration_.component_kind);
}

void SlotBase::not_assigned() const
{
    throw Error("option \"" + name() + "\": no component of kind " + declaration_.component_kind + "; set one by its type");
}

}  // namespace detail
}  // namespace fresco
