#include "pipeline/schema.h"

#include <algorithm>
#include <map>
#include <string>

namespace fresco::host
{
namespace
{
constexpr const char* name_pattern = "^[A-Za-z_][A-Za-z0-9_-]*$";

using Map = Value::Map;
using List = Value::List;

Value reference(const std::string& definition)
{
    return Map{{"$ref", "#/$defs/" + definition}};
}

Value any_of(List ways)
{
    return Map{{"anyOf", std::move(ways)}};
}

Value of_type(const char* type)
{
    return Map{{"type", type}};
}

/// A map that has no other entries.
Value closed_map(Value properties, List required = {})
{
    Value schema = of_type("object");
    schema.set("properties", std::move(properties));
    if (!required.empty())
        schema.set("required", std::move(required));
    schema.set("additionalProperties", false);
    return schema;
}

/// The value itself, or a var in its place.
Value or_var(Value schema)
{
    return any_of({std::move(schema), reference("var")});
}

Value array_of(Value items)
{
    return Map{{"type", "array"}, {"items", std::move(items)}};
}

Value map_of(Value values)
{
    return Map{{"type", "object"}, {"additionalProperties", std::move(values)}};
}

/// A map whose keys are names. `values`: what it may hold; null: anything.
Value map_by_name(const char* help, Value values = {})
{
    Value schema = of_type("object");
    schema.set("description", help);
    schema.set("propertyNames", Map{{"pattern", name_pattern}});
    if (!values.is_null())
        schema.set("additionalProperties", std::move(values));
    return schema;
}

/// A number in the option's range.
Value number_schema(const OptionDeclaration& option)
{
    const bool whole = option.kind == OptionKind::integer || option.kind == OptionKind::integers;
    Value schema = of_type(whole ? "integer" : "number");
    if (option.min)
        schema.set("minimum", *option.min);
    if (option.max)
        schema.set("maximum", *option.max);
    return or_var(std::move(schema));
}

/// Schema of an option's accepted values, without its help and default.
Value accepted_schema(const OptionDeclaration& option)
{
    switch (option.kind)
    {
    case OptionKind::boolean:
        return or_var(of_type("boolean"));
    case OptionKind::integer:
    case OptionKind::number:
        return number_schema(option);
    case OptionKind::integers:
    case OptionKind::numbers:
        return or_var(array_of(number_schema(option)));
    case OptionKind::text:
        return option.choices.empty() ? of_type("string")
                                      : or_var(Map{{"enum", List(option.choices.begin(), option.choices.end())}});
    case OptionKind::input_file:
    case OptionKind::input_folder:
    case OptionKind::input_path:
    case OptionKind::output_name:
        return of_type("string");
    case OptionKind::command_line:
        return or_var(Map{{"type", "array"}, {"items", Map{{"type", List{"string", "number", "boolean"}}}}, {"minItems", 1}});
    case OptionKind::input_files:
        return or_var(array_of(of_type("string")));
    case OptionKind::input_ports:
    case OptionKind::output_ports:
        return map_of(any_of(
            {of_type("string"), closed_map(Map{{"artifact", of_type("string")}, {"as", of_type("string")}}, {"artifact"})}));
    case OptionKind::rules:
    {
        const Value number = or_var(Map{{"type", "number"}, {"minimum", 0}, {"maximum", 1}});
        const Value rule =
            any_of({of_type("string"), closed_map(Map{{option.rule->input, of_type("string")}, {option.rule->number, number}},
                                                  {option.rule->input})});
        return or_var(Map{{"type", "object"}, {"additionalProperties", rule}, {"minProperties", 1}});
    }
    case OptionKind::component:
    case OptionKind::components:
    {
        const Value component = reference("kind." + option.component_kind);
        List ways{option.kind == OptionKind::component ? component : map_of(component), reference("var")};
        if (option.optional || !option.chosen_by.empty())
            ways.push_back(Map{{"const", option.optional ? "none" : "auto"}});
        return any_of(std::move(ways));
    }
    }
    return Map{};
}

std::string description(const OptionDeclaration& option)
{
    return option.help + (option.help.empty() ? "" : " ") + "(" + option.accepted() + ")";
}

class SchemaWriter
{
  public:
    explicit SchemaWriter(const Catalog& catalog)
    {
        for (const TypeDescription* type : catalog.types())
            kinds_[type->kind].emplace_back(type, read_declaration(*type));
        // A kind that some option asks for and no plugin provides still has its place.
        std::vector<std::string> wanted{"stage", "reader"};
        for (const auto& [kind, types] : kinds_)
            for (const auto& [type, declaration] : types)
            {
                for (const OptionDeclaration& option : declaration.options)
                    if (option.is_slot())
                        wanted.push_back(option.component_kind);
                for (const OptionDeclaration& component : declaration.components)
                    if (const std::string& shared = component.component_kind; components_.find(shared) == nullptr)
                    {
                        components_.set(shared, any_of({reference("kind." + shared), reference("var"), Map{{"const", "none"}},
                                                        of_type("null")}));
                        wanted.push_back(shared);
                    }
            }
        for (const std::string& kind : wanted)
            kinds_[kind];
    }

    Value write()
    {
        Value definitions = Map{};
        definitions.set("var", Map{{"type", "string"}, {"pattern", "\\$\\{[A-Za-z_][A-Za-z0-9_-]*\\}"}});
        for (const auto& [kind, types] : kinds_)
        {
            for (const auto& [type, declaration] : types)
                definitions.set("type." + type->type, type_schema(*type, declaration));
            definitions.set(kind == "stage" ? "stage" : "kind." + kind, kind_schema(kind, true));
        }
        definitions.set("stage_over_base", any_of({of_type("null"), kind_schema("stage", false)}));
        Value components = closed_map(components_);
        components.set("description", "Components that all stages use: kind -> one of it");
        // Empty where it takes away an axis of the base.
        const Value axis = any_of({Map{{"type", "array"}, {"minItems", 1}, {"uniqueItems", true}},
                                   Map{{"type", "object"}, {"minProperties", 1}}, of_type("null")});
        return Map{
            {"$schema", "https://json-schema.org/draft/2020-12/schema"},
            {"title", "fresco pipeline"},
            {"type", "object"},
            {"required", List{"version"}},
            {"properties",
             Map{{"version", Map{{"const", 1}}},
                 {"base", Map{{"type", "string"}, {"description", "A pipeline file that this one builds on"}}},
                 {"vars", map_by_name("Values for ${name}, changed by --set NAME=VALUE")},
                 {"matrix",
                  map_by_name("Runs every combination: var -> the values that it takes, a list or a map of named ones", axis)},
                 {"components", components},
                 {"stages", Map{{"type", "object"}, {"propertyNames", Map{{"pattern", name_pattern}}}}},
                 {"preview", map_by_name("Options of stages for --preview: stage -> {option: value}",
                                         any_of({of_type("object"), of_type("null")}))}}},
            {"additionalProperties", false},
            {"if", Map{{"required", List{"base"}}}},
            {"then", stages_of("stage_over_base")},
            // A file that only others build on may set no more than previews.
            {"else", Map{{"anyOf", List{Map{{"required", List{"stages"}}}, Map{{"required", List{"preview"}}}}},
                         {"properties", stages_of("stage").at("properties")}}},
            {"$defs", std::move(definitions)}};
    }

  private:
    static Value stages_of(const char* definition)
    {
        return Map{{"properties", Map{{"stages", Map{{"additionalProperties", reference(definition)}}}}}};
    }

    /// `type` decides which options there are. A component may also be its type's bare name.
    Value kind_schema(const std::string& kind, bool needs_type) const
    {
        List branches;
        List names;
        for (const auto& [type, declaration] : kinds_.at(kind))
        {
            names.push_back(type->type);
            branches.push_back(
                Map{{"if", Map{{"properties", Map{{"type", Map{{"const", type->type}}}}}, {"required", List{"type"}}}},
                    {"then", reference("type." + type->type)}});
        }
        const Value name = or_var(Map{{"enum", std::move(names)}});
        Value schema = Map{{"type", "object"}, {"properties", Map{{"type", name}}}};
        if (needs_type)
            schema.set("required", List{"type"});
        schema.set("allOf", std::move(branches));
        return kind == "stage" ? schema : any_of({name, std::move(schema)});
    }

    static void add_options(Value& properties, List& required, const TypeDeclaration& declaration)
    {
        for (const OptionDeclaration& option : declaration.options)
        {
            Value schema = accepted_schema(option);
            schema.set("description", description(option));
            if (!option.default_value.is_null())
                schema.set("default", option.default_value);
            if (option.required)
                required.push_back(option.name);
            properties.set(option.name, std::move(schema));
        }
    }

    Value type_schema(const TypeDescription& type, const TypeDeclaration& declaration) const
    {
        Value properties = Map{{"type", Map{{"const", type.type}}}};
        List required{"type"};
        const bool own_ports = std::ranges::any_of(declaration.options, [](const OptionDeclaration& option)
                                                   { return option.is_ports() || option.kind == OptionKind::rules; });
        if (own_ports)
            properties.set("input", Map{{"type", List{"string", "object"}}});
        else if (type.kind == "stage" && !declaration.inputs.empty())
            properties.set("input", input_schema(declaration.inputs));
        // A file that builds on another need not repeat what is required.
        List needed;
        add_options(properties, type.kind == "stage" ? needed : required, declaration);
        Value schema = closed_map(std::move(properties), std::move(required));
        schema.set("description", type.help);
        return schema;
    }

    Value input_schema(const std::vector<PortDeclaration>& ports) const
    {
        Value named = Map{};
        List ways{Map{{"type", "string"}, {"description", "A stage's name, or stage.output"}}};
        for (const PortDeclaration& port : ports)
        {
            List sources{of_type("string")};
            for (Value& reader : file_schemas(port))
            {
                sources.push_back(reader);
                ways.push_back(std::move(reader));
            }
            named.set(port.name,
                      Map{{"anyOf", std::move(sources)},
                          {"description", port.help + " (" + port.artifact_text() + (port.is_optional ? ", optional)" : ")")}});
        }
        ways.push_back(closed_map(std::move(named)));
        return any_of(std::move(ways));
    }

    /// {file: PATH} by each reader that makes the port's artifact.
    List file_schemas(const PortDeclaration& port) const
    {
        List result;
        for (const auto& [type, declaration] : kinds_.at("reader"))
        {
            if (declaration.artifact != port.artifact)
                continue;
            Value properties = Map{{"file", of_type("string")}, {"type", Map{{"const", type->type}}}};
            List required{"file"};
            add_options(properties, required, declaration);
            result.push_back(closed_map(std::move(properties), std::move(required)));
        }
        return result;
    }

    std::map<std::string, std::vector<std::pair<const TypeDescription*, TypeDeclaration>>> kinds_;
    Value components_{Map{}};  ///< By the kind: the schema of a component that a pipeline chooses.
};
}  // namespace

Value pipeline_schema(const Catalog& catalog)
{
    return SchemaWriter(catalog).write();
}

}  // namespace fresco::host
