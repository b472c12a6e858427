#include <fresco/declared_ports.h>
#include <fresco/error.h>

#include <type_traits>

namespace fresco
{
namespace
{
namespace fs = std::filesystem;

fs::path path_of(const ExchangeForm& form, const fs::path& folder)
{
    return form.is_folder ? folder : folder / form.files.front();
}

template <class Port>
OptionDeclaration declared(std::string name, std::string help)
{
    const bool is_input = std::is_same_v<Port, DeclaredInput>;
    OptionDeclaration option{.name = std::move(name),
                             .kind = is_input ? OptionKind::input_ports : OptionKind::output_ports,
                             .required = !is_input,
                             .help = std::move(help)};
    if (is_input)
        option.default_value = Value::Map{};
    return option;
}

}  // namespace

DeclaredInput::DeclaredInput(Configurable* owner, const std::string& name, const ArtifactType& type, const ExchangeForm& form)
    : InputPort(owner, name, type, false, ""), form_(form)
{
}

fs::path DeclaredInput::hand_over(const fs::path& folder, const ImageIo* images, RunContext& run) const
{
    if (form_.taken_in_place && value_ == nullptr)
        return stored_.path;
    const auto value = value_ != nullptr ? value_ : type().load(stored_);
    value->write_exchange({form_.as, {folder, {}}, images, run});
    return path_of(form_, folder);
}

DeclaredOutput::DeclaredOutput(Configurable* owner, const std::string& name, const ArtifactType& type, const ExchangeForm& form)
    : OutputPort(owner, name, type, false, ""), form_(form)
{
}

fs::path DeclaredOutput::place(const fs::path& scratch) const
{
    return path_of(form_, form_.made_in_place ? folder_.path : scratch);
}

void DeclaredOutput::take_back(const fs::path& scratch, const ImageIo* images, RunContext& run) const
{
    const ArtifactFolder made = form_.made_in_place ? folder_ : ArtifactFolder{scratch, {}};
    type().from_exchange({form_.as, made, images, run})->save(folder_);
}

template <class Port>
DeclaredPorts<Port>::DeclaredPorts(Configurable* owner, std::string name, std::string help)
    : Parameter(owner, declared<Port>(std::move(name), std::move(help))), owner_(owner)
{
    for (const ArtifactType* type : artifact_types())
        declaration_.artifacts[type->name] = {type->version, type->form_names()};
}

template <class Port>
void DeclaredPorts<Port>::set(const Value& value, ComponentFactory&)
{
    for (const auto& [name, port] : value.as_map())
    {
        const ArtifactType* type = find_artifact_type(port.at("artifact").as_string());
        ports_.push_back(std::make_unique<Port>(owner_, name, *type, *type->form(port.at("as").as_string())));
    }
}

template class DeclaredPorts<DeclaredInput>;
template class DeclaredPorts<DeclaredOutput>;

}  // namespace fresco
