#include "pipeline/pipeline_types.h"
#include "base/common.h"
#include <fresco/artifact.h>
#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>

namespace fresco::host
{
namespace
{

/// Plugins are called after what they hold: mesh_decimate.so has mesh.decimate. One that failed when it made a type says so.
const Refusal* probable_refusal(const Catalog& catalog, const std::string& type)
{
    std::string name = type;
    std::ranges::replace(name, '.', '_');
    for (const Refusal& refusal : catalog.refusals())
        if (refusal.library.stem() == name || (" " + refusal.reason + " ").find(" " + type + " ") != std::string::npos)
            return &refusal;
    return nullptr;
}

}  // namespace

const TypeDeclaration& TypeTable::declaration(const TypeDescription& type)
{
    const auto known = declarations_.find(&type);
    if (known != declarations_.end())
        return known->second;
    TypeDeclaration& declaration = declarations_.emplace(&type, read_declaration(type)).first->second;
    for (OptionDeclaration& option : declaration.options)
        if (option.is_ports())
            for (const auto& [name, artifact] : artifacts())
                option.artifacts[name] = artifact.port;
    return declaration;
}

const std::map<std::string, TypeTable::KnownArtifact, std::less<>>& TypeTable::artifacts()
{
    if (!artifacts_.empty())
        return artifacts_;
    for (const ArtifactType* type : artifact_types())
        artifacts_[type->name] = {{type->version, type->form_names()}, nullptr};
    for (const TypeDescription* type : catalog_.types("stage"))
        for (const char* side : {"outputs", "inputs"})
            for (const Value& port : type->declaration.at(side).as_list())
            {
                KnownArtifact artifact{{static_cast<int>(port.at("version").as_int()), {}}, type};
                if (const Value* forms = port.find("as"))
                    for (const Value& form : forms->as_list())
                        artifact.port.as.push_back(form.as_string());
                artifacts_.emplace(port.at("artifact").as_string(), std::move(artifact));
            }
    return artifacts_;
}

const std::map<std::string, Value, std::less<>>& TypeTable::pipeline_components()
{
    if (pipeline_components_)
        return *pipeline_components_;
    pipeline_components_.emplace();
    for (const TypeDescription* type : catalog_.types())
        if (const KnownType known = find(type->type, type->kind))
            for (const OptionDeclaration& component : known.declaration->components)
                pipeline_components_->emplace(component.component_kind, component.default_value);
    return *pipeline_components_;
}

const TypeDescription* TypeTable::owner_of(std::string_view artifact)
{
    const auto known = artifacts().find(artifact);
    return known == artifacts().end() ? nullptr : known->second.owner;
}

KnownType TypeTable::find(std::string_view type, std::string_view kind)
{
    const TypeDescription* description = catalog_.find(type);
    if (!description || description->kind != kind)
        return {};
    return attempt([&] { return KnownType{description, &declaration(*description)}; }).value_or(KnownType{});
}

KnownType TypeTable::require(const std::string& type, std::string_view kind, const std::string& user, const Position& at,
                             ProblemList& problems)
{
    const auto refuse = [&](const std::string& text, ProblemKind problem_kind = ProblemKind::plugin)
    {
        problems.add(at, user + ": " + text, problem_kind);
        return KnownType{};
    };
    if (const TypeDescription* description = catalog_.find(type))
    {
        if (!kind.empty() && description->kind != kind)
            return refuse("'" + type + "' is of kind '" + description->kind + "'; expected kind '" + std::string(kind) + "'" +
                              suggestion(type, names_of_kind(kind)),
                          ProblemKind::invalid);
        try
        {
            return {description, &declaration(*description)};
        }
        catch (const Error& error)
        {
            return refuse(error.what());
        }
    }
    if (const auto libraries = catalog_.libraries_of(type); !libraries.empty())
        return refuse("several plugins have the type '" + type + "', so none is used: " + join(libraries) +
                      "; remove all but one");
    if (const Refusal* refusal = probable_refusal(catalog_, type))
        return refuse("'" + type + "' is probably in " + refusal->library.string() +
                      ", which cannot be used: " + refusal->reason);
    if (const UnbuiltPlugin* unbuilt = catalog_.find_unbuilt(type))
        return refuse("the plugin of '" + type + "' is not built" +
                      (unbuilt->reason.empty() ? "" : " (" + unbuilt->reason + ")") + ": run ./bootstrap build");
    return refuse("unknown type '" + type + "'" + suggestion(type, names_of_kind(kind)), ProblemKind::invalid);
}

std::vector<std::string> TypeTable::names_of_kind(std::string_view kind) const
{
    return each(catalog_.types(kind), &TypeDescription::type);
}

std::shared_ptr<const TypeDescription> TypeTable::adopt(TypeDescription type)
{
    auto& known =
        adopted_[type.type + " " + to_json(type.declaration.at("inputs")) + " " + to_json(type.declaration.at("outputs"))];
    if (!known)
        known = std::make_shared<const TypeDescription>(std::move(type));
    return known;
}

std::optional<std::string> type_named_by(const YamlNode& config, const std::string& user, ProblemList* problems)
{
    const auto report = [&](const YamlNode& at, const std::string& text)
    {
        if (problems)
            problems->add(at, user + ": " + text);
    };
    const YamlNode::Entry* entry = config.is_map() ? config.find("type") : nullptr;
    if (config.is_map() && !entry)
    {
        report(config, "missing 'type'");
        return std::nullopt;
    }
    const YamlNode& named = entry ? entry->value : config;
    if (!named.is_valid())
        return std::nullopt;
    const ResolvedScalar resolved = named.is_scalar() ? resolve_scalar(named) : ResolvedScalar{};
    if (!resolved.value.is_string() || resolved.value.as_string().empty())
    {
        report(named, "expected a type such as 'mesh.decimate', got " + named.summary());
        return std::nullopt;
    }
    return resolved.value.as_string();
}

}  // namespace fresco::host
