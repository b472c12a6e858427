#include "run/commands_inspect.h"
#include "base/common.h"
#include "base/process.h"
#include "base/text.h"
#include "pipeline/path_marks.h"
#include "pipeline/pipeline_types.h"
#include "pipeline/schema.h"
#include "plugins/plugin_library.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/reader.h>

#include <algorithm>
#include <ostream>

#include <fmt/ranges.h>

namespace fresco::host
{

namespace
{

using Map = Value::Map;
using List = Value::List;
using Kind = TextTable::Kind;

/// Indented, without titles.
TextTable table_of(const std::vector<Kind>& kinds)
{
    constexpr std::size_t indent = 2;
    return TextTable(each(kinds, [](Kind kind) { return TextTable::Column{"", kind}; }), indent);
}

/// Answer of the process that opens the library.
Value answer_of(const Child& child)
{
    constexpr std::chrono::hours without_limit(10'000);
    std::string answer;
    const HeardEnd end = hear_out(
        child, without_limit, [&](const std::string& line) { answer = answer.empty() ? line : answer; }, [](const auto&) {});
    if (!answer.empty())
        return parse_json(answer, "the answer of the process that reads the file");
    throw Error("the process that reads the file " +
                (end.signal != 0 ? "ended by " + signal_text(end.signal) : "ended with code " + std::to_string(end.exit_code)));
}

/// "waves.jpg (xxh128 0123…)", a stage, a number …
std::string value_text(const Value& value)
{
    if (const Value* hash = value.find("xxh128"))
        return value.at("file").as_string() + " (xxh128 " + hash->as_string() + ")";
    return value.is_string() ? value.as_string() : to_json(value);
}

void write_stage(const Value& stage, std::size_t width, std::ostream& out)
{
    out << '\n' << harmless(stage.at("stage").as_string(), LineEnds::none) << '\n';
    TextTable table = table_of({Kind::figure, Kind::figure, Kind::text});
    for (const auto& [what, all] : {std::pair("input", "inputs"), {"option", "options"}, {"figure", "figures"}})
        if (const Value* entries = stage.find(all))
            for (const auto& [name, entry] : entries->as_map())
                table.add({what, name, value_text(entry)});
    out << table.text(width);
}

const char* kind_name(ProblemKind kind)
{
    return kind == ProblemKind::invalid   ? "invalid"
           : kind == ProblemKind::plugin  ? "plugin"
           : kind == ProblemKind::warning ? "warning"
                                          : "missing_input";
}

Value stages_as_value(const Catalog& catalog, bool all)
{
    const auto told = [&](const TypeDescription* type)
    {
        Map entry{{"type", type->type}, {"kind", type->kind}, {"help", type->help}};
        if (all)
            entry.emplace_back("library", type->library.string());
        return entry;
    };
    Map result{{"types", each<Value>(catalog.types(), told)}};
    if (all)
        std::ranges::move(unusable_types(catalog, "refused"), std::back_inserter(result));
    return result;
}

/// A table of all that a type declares in one list: a name, what it is, and help.
template <class Declaration, class Text>
void write_declared(const char* title, const std::vector<Declaration>& list, const Text& text, std::size_t width,
                    std::ostream& out)
{
    if (list.empty())
        return;
    out << '\n' << title << ":\n";
    TextTable table = table_of({Kind::figure, Kind::figure, Kind::text});
    for (const Declaration& declared : list)
        table.add({declared.name, text(declared), declared.help});
    out << table.text(width);
}

void write_options(const TypeDeclaration& declaration, const TypeTable& types, std::size_t width, std::ostream& out)
{
    if (declaration.options.empty())
        return;
    out << "\noptions (name, default, accepted, what it is):\n";
    TextTable table = table_of({Kind::figure, Kind::figure, Kind::text, Kind::text});
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
        out << (fitting.empty() ? "no plugins" : join(fitting, ", ")) << '\n';
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
    if (const std::string marks = marks_text(declaration.marks); !marks.empty())
        out << "known by " << marks << '\n';
    const auto port_text = [](const PortDeclaration& port)
    { return port.artifact_text() + (port.is_optional ? ", optional" : ""); };
    write_declared("inputs", declaration.inputs, port_text, width, out);
    write_declared("outputs", declaration.outputs, port_text, width, out);
    write_options(declaration, types, width, out);
    write_declared(
        "components that the pipeline chooses (kind, default, what it is)", declaration.components,
        [](const OptionDeclaration& component) { return component.default_value.at("type").as_string(); }, width, out);
}

/// A line per problem; of many that are alike the first few, and how many more there are.
void write_problems(const std::vector<Problem>& problems, std::ostream& out)
{
    for (const std::string& line : told(problems))
        out << harmless(line, LineEnds::continued) << '\n';
}

}  // namespace

const TypeDescription* origin_reader(const Catalog& catalog, const std::string& file)
{
    for (const TypeDescription* type : catalog.types(FileOrigin::component_kind))
        for (const std::string& extension : read_declaration(*type).extensions)
            if (file.ends_with(extension))
                return type;
    return nullptr;
}

void write_file_origin(const TypeDescription& reader, const std::filesystem::path& file, bool json, std::size_t width,
                       std::ostream& out)
{
    const Value answer = answer_of(start_child({"internal-origin", reader.library.string(), reader.type, file.string()}));
    if (const Value* error = answer.find("error"))
    {
        if (answer.at("missing").as_bool())
            throw MissingInput(error->as_string());
        throw Error(error->as_string());
    }
    const Value& origin = answer.at("origin");
    if (json)
    {
        out << to_json(origin, 2) << '\n';
        return;
    }
    const auto versions = each(origin.at("versions").as_map(),
                               [](const Value::Entry& entry) { return entry.first + " " + entry.second.as_string(); });
    out << harmless(file.string() + ": made with " + join(versions, ", "), LineEnds::none) << '\n';
    for (const Value& stage : origin.at("stages").as_list())
        write_stage(stage, width, out);
}

int internal_origin(const std::filesystem::path& library, const std::string& type, const std::filesystem::path& file)
{
    Value answer = Value::Map{};
    try
    {
        const std::unique_ptr<Configurable> object = open_plugin(library).library->make(type);
        const auto* reader = dynamic_cast<const FileOrigin*>(object.get());
        if (reader == nullptr)
            throw Error("the type " + type + " is registered as an origin but does not derive from fresco::FileOrigin");
        answer.set("origin", reader->origin(file));
    }
    catch (const std::exception& error)
    {
        answer.set("error", error.what());
        answer.set("missing", dynamic_cast<const MissingInput*>(&error) != nullptr);
    }
    write_all(child_channel, to_json(answer) + "\n");
    return 0;
}

std::vector<std::string> unusable_lines(const Catalog& catalog)
{
    std::vector<std::string> lines;
    for (const ShadowedType& type : catalog.shadowed())
        lines.push_back("shadowed: " + type.type + " of " + type.library.string() + ", by " + type.by.string());
    for (const std::string& type : catalog.ambiguous())
        lines.push_back("not used, because several plugins have it: " + type + ": " + join(catalog.libraries_of(type), " and "));
    for (const Refusal& refusal : catalog.refusals())
        lines.push_back("refused: " + refusal.library.string() + ": " + refusal.reason);
    for (const UnbuiltPlugin& plugin : catalog.unbuilt())
        lines.push_back("not built: " + plugin.type + (plugin.reason.empty() ? "" : ": " + plugin.reason));
    return lines;
}

Value::Map unusable_types(const Catalog& catalog, const char* refused_name)
{
    const auto ambiguous = [&](const std::string& type)
    {
        const std::vector<std::string> libraries = catalog.libraries_of(type);
        return Map{{"type", type}, {"libraries", List(libraries.begin(), libraries.end())}};
    };
    const auto shadowed = [](const ShadowedType& type) {
        return Map{{"type", type.type}, {"library", type.library.string()}, {"by", type.by.string()}};
    };
    const auto refused = [](const Refusal& refusal) {
        return Map{{"library", refusal.library.string()}, {"reason", refusal.reason}};
    };
    const auto unbuilt = [](const UnbuiltPlugin& plugin) { return Map{{"type", plugin.type}, {"reason", plugin.reason}}; };
    return {{"ambiguous", each<Value>(catalog.ambiguous(), ambiguous)},
            {"shadowed", each<Value>(catalog.shadowed(), shadowed)},
            {refused_name, each<Value>(catalog.refusals(), refused)},
            {"unbuilt", each<Value>(catalog.unbuilt(), unbuilt)}};
}

Value problems_as_value(const std::vector<Problem>& problems)
{
    return each<Value>(problems,
                       [](const Problem& problem)
                       {
                           return Map{{"file", problem.position.file},
                                      {"line", problem.position.line},
                                      {"column", problem.position.column},
                                      {"kind", kind_name(problem.kind)},
                                      {"text", problem.text}};
                       });
}

int write_check(const PipelineResult& result, bool json, std::ostream& out)
{
    if (json)
    {
        const auto told = [](const PipelineStage& stage) {
            return Map{{"name", stage.name}, {"type", stage.type->type}, {"options", *stage.options}};
        };
        out << to_json(Map{{"file", result.pipeline.file.string()},
                           {"ok", result.problems.empty()},
                           {"stages", each<Value>(result.pipeline.stages, told)},
                           {"combinations", each<Value>(result.pipeline.sweep.combinations, &Combination::name)},
                           {"problems", problems_as_value(result.problems)},
                           {"warnings", problems_as_value(result.warnings)}},
                       2)
            << '\n';
    }
    else if (result.problems.empty())
    {
        write_problems(result.warnings, out);
        const std::size_t combinations = result.pipeline.sweep.combinations.size();
        out << result.pipeline.file.string() << ": " << result.pipeline.stages.size()
            << (result.pipeline.stages.size() == 1 ? " stage" : " stages")
            << (combinations > 0 ? " of " + std::to_string(combinations) + " combinations" : "") << ", "
            << (result.warnings.empty() ? "no problems" : counted(result.warnings.size(), "warning")) << "\n";
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
    TextTable table = table_of({Kind::figure, Kind::figure, Kind::text});
    for (const TypeDescription* type : types)
        table.add({type->type, type->kind, type->help + (all ? " [" + type->library.string() + "]" : "")});
    out << table.text(width);
    if (types.empty())
        out << "no stages: no plugin was found that can be used\n";
    std::string unused;
    for (const std::string& line : unusable_lines(catalog))
        unused += "  " + harmless(line, LineEnds::none) + "\n";
    if (all)
        out << (unused.empty() ? "" : "\nnot used:\n" + unused);
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
        const PipelineResult result{{}, problems.sorted()};
        write_problems(result.problems, errors);
        return result.exit_code();
    }
    if (json)
        out << to_json(Map{{"type", type},
                           {"kind", known.description->kind},
                           {"help", known.description->help},
                           {"library", known.description->library.string()},
                           {"library_hash", known.description->bytes->hash()},
                           {"library_versions", known.description->library_versions},
                           {"declaration", known.description->declaration}},
                       2)
            << '\n';
    else
        write_text(*known.description, *known.declaration, types, width, out);
    return 0;
}

}  // namespace fresco::host
