#include "run/commands_inspect.h"
#include "base/terminal_line.h"
#include "base/text_layout.h"
#include "pipeline/dot.h"
#include "pipeline/pipeline_types.h"
#include "pipeline/schema.h"

#include <algorithm>
#include <ostream>

namespace fresco::host
{
namespace
{
using Map = Value::Map;
using List = Value::List;

const char* kind_name(ProblemKind kind)
{
    switch (kind)
    {
    case ProblemKind::invalid:
        return "invalid";
    case ProblemKind::missing_input:
        return "missing_input";
    case ProblemKind::plugin:
        return "plugin";
    }
    return "";
}

constexpr std::size_t table_indent = 2;

Value libraries_of(const Catalog& catalog, const std::string& type)
{
    List libraries;
    for (const auto& library : catalog.libraries_of(type))
        libraries.push_back(library.string());
    return libraries;
}

Value stages_as_value(const Catalog& catalog, bool all)
{
    List types;
    for (const TypeDescription* type : catalog.types())
    {
        Value entry = Map{{"type", type->type}, {"kind", type->kind}, {"help", type->help}};
        if (all)
            entry.set("library", type->library.string());
        types.push_back(std::move(entry));
    }
    Value result = Map{{"types", std::move(types)}};
    if (!all)
        return result;
    List ambiguous;
    for (const std::string& type : catalog.ambiguous())
        ambiguous.push_back(Map{{"type", type}, {"libraries", libraries_of(catalog, type)}});
    List refused;
    for (const Refusal& refusal : catalog.refusals())
        refused.push_back(Map{{"library", refusal.library.string()}, {"reason", refusal.reason}});
    List unbuilt;
    for (const UnbuiltPlugin& plugin : catalog.unbuilt())
        unbuilt.push_back(Map{{"type", plugin.type}, {"reason", plugin.reason}});
    result.set("ambiguous", std::move(ambiguous));
    result.set("refused", std::move(refused));
    result.set("unbuilt", std::move(unbuilt));
    return result;
}

void write_refused(const Catalog& catalog, std::ostream& out)
{
    for (const std::string& type : catalog.ambiguous())
    {
        out << "\nnot used, because several plugins have it: " << type << '\n';
        for (const auto& library : catalog.libraries_of(type))
            out << "  " << harmless(library.string(), LineEnds::none) << '\n';
    }
    if (!catalog.refusals().empty())
        out << "\ncannot be loaded:\n";
    for (const Refusal& refusal : catalog.refusals())
        out << "  " << harmless(refusal.library.string() + ": " + refusal.reason, LineEnds::none) << '\n';
    if (!catalog.unbuilt().empty())
        out << "\nnot built; ./bootstrap build builds them:\n";
    for (const UnbuiltPlugin& plugin : catalog.unbuilt())
        out << "  " << plugin.type << (plugin.reason.empty() ? "" : ": " + plugin.reason) << '\n';
}

void write_ports(const char* title, const std::vector<PortDeclaration>& ports, std::size_t width, std::ostream& out)
{
    if (ports.empty())
        return;
    out << '\n' << title << ":\n";
    TextTable table({{"", TextTable::Kind::figure}, {"", TextTable::Kind::figure}, {"", TextTable::Kind::text}}, table_indent);
    for (const PortDeclaration& port : ports)
        table.add({port.name, port.artifact_text() + (port.is_optional ? ", optional" : ""), port.help});
    out << table.text(width);
}

void write_options(const TypeDeclaration& declaration, const TypeTable& types, std::size_t width, std::ostream& out)
{
    if (declaration.options.empty())
        return;
    out << "\noptions (name, default, accepted, what it is):\n";
    TextTable table(
        {{"", TextTable::Kind::figure}, {"", TextTable::Kind::figure}, {"", TextTable::Kind::text}, {"", TextTable::Kind::text}},
        table_indent);
    constexpr std::size_t most_columns = 24;
    for (const OptionDeclaration& option : declaration.options)
    {
        const std::string value = option.default_text();
        const bool is_long = columns(value) > most_columns;
        table.add({option.name, is_long ? "…" : value, option.accepted() + (is_long ? "; by default " + value : ""),
                   option.help + (option.in_key ? "" : " (cannot change the result)")});
    }
    out << table.text(width);
    for (const OptionDeclaration& option : declaration.options)
    {
        if (!option.is_slot())
            continue;
        const std::vector<std::string> fitting = types.names_of_kind(option.component_kind);
        out << "\nfor '" << option.name << "' there " << (fitting.size() == 1 ? "is" : "are") << ": ";
        for (std::size_t i = 0; i < fitting.size(); ++i)
            out << (i == 0 ? "" : ", ") << fitting[i];
        out << (fitting.empty() ? "no plugins" : "") << '\n';
        if (option.auto_rule)
            out << "  auto, if '" << option.auto_rule->option << "' is empty: " << to_json(option.auto_rule->if_empty)
                << "\n  auto, otherwise: " << to_json(option.auto_rule->if_set) << '\n';
    }
}

void write_text(const TypeDescription& type, const TypeDeclaration& declaration, const TypeTable& types, std::size_t width,
                std::ostream& out)
{
    out << type.type << " (" << type.kind << "): " << type.help << '\n';
    out << "in " << type.library.string() << '\n';
    if (!declaration.artifact.empty())
    {
        out << "reads " << declaration.artifact << " from";
        for (const std::string& extension : declaration.extensions)
            out << ' ' << extension;
        out << '\n';
    }
    write_ports("inputs", declaration.inputs, width, out);
    write_ports("outputs", declaration.outputs, width, out);
    write_options(declaration, types, width, out);
}
}  // namespace

void write_problems(const std::vector<Problem>& problems, std::ostream& out)
{
    for (const std::string& line : told(problems))
        out << harmless(line, LineEnds::continued) << '\n';
}

Value problems_as_value(const std::vector<Problem>& problems)
{
    List result;
    for (const Problem& problem : problems)
        result.push_back(Map{{"file", problem.position.file},
                             {"line", problem.position.line},
                             {"column", problem.position.column},
                             {"kind", kind_name(problem.kind)},
                             {"text", problem.text}});
    return result;
}

int write_check(const PipelineResult& result, bool json, std::ostream& out)
{
    if (json)
    {
        List stages;
        for (const PipelineStage& stage : result.pipeline.stages)
            stages.push_back(Map{{"name", stage.name}, {"type", stage.type->type}, {"options", *stage.options}});
        List combinations;
        for (const Combination& combination : result.pipeline.sweep.combinations)
            combinations.push_back(combination.name);
        out << to_json(Map{{"file", result.pipeline.file.string()},
                           {"ok", result.problems.empty()},
                           {"stages", std::move(stages)},
                           {"combinations", std::move(combinations)},
                           {"problems", problems_as_value(result.problems)}},
                       2)
            << '\n';
    }
    else if (result.problems.empty())
    {
        const std::size_t combinations = result.pipeline.sweep.combinations.size();
        out << result.pipeline.file.string() << ": " << result.pipeline.stages.size()
            << (result.pipeline.stages.size() == 1 ? " stage" : " stages")
            << (combinations > 0 ? " of " + std::to_string(combinations) + " combinations" : "") << ", no problems\n";
    }
    else
        write_problems(result.problems, out);
    return result.exit_code();
}

int write_stages(const Catalog& catalog, bool all, bool json, std::size_t width, std::ostream& out)
{
    if (json)
    {
        out << to_json(stages_as_value(catalog, all), 2) << '\n';
        return 0;
    }
    // Stages first: they are what a pipeline is made of.
    std::vector<const TypeDescription*> types = catalog.types();
    std::stable_partition(types.begin(), types.end(), [](const TypeDescription* type) { return type->kind == "stage"; });
    TextTable table({{"", TextTable::Kind::figure}, {"", TextTable::Kind::figure}, {"", TextTable::Kind::text}}, table_indent);
    for (const TypeDescription* type : types)
        table.add(all ? std::vector<std::string>{type->type, type->kind, type->help + " [" + type->library.string() + "]"}
                      : std::vector<std::string>{type->type, type->kind, type->help});
    out << table.text(width);
    if (types.empty())
        out << "no stages: no plugin was found that can be used\n";
    if (all)
        write_refused(catalog, out);
    else if (const std::size_t unusable = catalog.refusals().size() + catalog.ambiguous().size(); unusable > 0)
        out << "\n"
            << unusable << (unusable == 1 ? " plugin or type" : " plugins or types")
            << " cannot be used: see 'fresco stages --all'\n";
    return 0;
}

int write_description(const Catalog& catalog, const std::string& type, bool json, std::size_t width, std::ostream& out,
                      std::ostream& errors)
{
    TypeTable types(catalog);
    ProblemList problems;
    const KnownType known = types.require(type, "", "describe", {"fresco", 0, 0}, problems);
    if (!known)
    {
        PipelineResult result;
        result.problems = problems.sorted();
        write_problems(result.problems, errors);
        return result.exit_code();
    }
    if (json)
        out << to_json(Map{{"type", type},
                           {"kind", known.description->kind},
                           {"help", known.description->help},
                           {"library", known.description->library.string()},
                           {"library_hash", known.description->library_hash},
                           {"library_versions", known.description->library_versions},
                           {"declaration", known.description->declaration}},
                       2)
            << '\n';
    else
        write_text(*known.description, *known.declaration, types, width, out);
    return 0;
}

int write_graph(const PipelineResult& result, std::ostream& out, std::ostream& errors)
{
    if (result.problems.empty())
        write_dot(result.pipeline, out);
    else
        write_problems(result.problems, errors);
    return result.exit_code();
}

int write_schema(const Catalog& catalog, std::ostream& out)
{
    out << to_json(pipeline_schema(catalog), 2) << '\n';
    return 0;
}

}  // namespace fresco::host
