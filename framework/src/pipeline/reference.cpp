#include "pipeline/reference.h"
#include "base/common.h"
#include "pipeline/path_marks.h"
#include "pipeline/pipeline_types.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/wording.h>

#include <boost/algorithm/string/replace.hpp>
#include <map>
#include <set>
#include <system_error>

namespace fresco::host
{
namespace
{

/// The first line of every page: how a page is told from other files.
constexpr std::string_view written_by = "<!-- Written by 'fresco reference' -->\n";

/// Text in a cell of a table.
std::string cell(const std::string& text)
{
    std::string result;
    for (const char c : text)
    {
        if (c == '|' || c == '<' || c == '*' || c == '_')
            result += '\\';
        result += c == '\n' ? ' ' : c;
    }
    return result;
}

std::string code(const std::string& text)
{
    const std::string quoted = boost::replace_all_copy(text, "|", "\\|");
    return quoted.find('`') == std::string::npos ? "`" + quoted + "`" : "`` " + quoted + " ``";
}

std::string link(const std::string& type)
{
    return "[`" + type + "`](" + type + ".md)";
}

std::string row(const std::vector<std::string>& cells)
{
    std::string text = "|";
    for (const std::string& each : cells)
        text += " " + each + (each.empty() ? "|" : " |");
    return text + "\n";
}

std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows)
{
    std::string text = row(head) + "|";
    for (std::size_t i = 0; i < head.size(); ++i)
        text += "---|";
    text += "\n";
    for (const auto& cells : rows)
        text += row(cells);
    return text;
}

std::string ports(const char* title, const std::vector<PortDeclaration>& ports)
{
    if (ports.empty())
        return "";
    std::vector<std::vector<std::string>> rows;
    for (const PortDeclaration& port : ports)
        rows.push_back({code(port.name), cell(port.artifact_text()) + (port.is_optional ? ", optional" : ""), cell(port.help)});
    return std::string("\n## ") + title + "\n\n" + table({"port", "artifact", ""}, rows);
}

std::string components(const OptionDeclaration& option, const TypeTable& types)
{
    std::string text = "\nFor " + code(option.name) + ": ";
    const auto names = types.names_of_kind(option.component_kind);
    text += names.empty() ? "no plugin is there.\n" : join(each(names, link), ", ") + ".\n";
    return text;
}

std::string options(const TypeDeclaration& declaration, const TypeTable& types)
{
    if (declaration.options.empty())
        return "";
    std::vector<std::vector<std::string>> rows;
    std::string slots;
    bool some_free = false;
    for (const OptionDeclaration& option : declaration.options)
    {
        const std::string value = option.default_text();
        rows.push_back({code(option.name) + (option.in_key ? "" : "°"),
                        option.required || option.default_value.is_null() ? value : code(value), cell(option.accepted()),
                        cell(option.help)});
        some_free = some_free || !option.in_key;
        if (option.is_slot())
            slots += components(option, types);
    }
    return "\n## Options\n\n" + table({"option", "default", "accepted", ""}, rows) +
           (some_free ? "\n° does not affect the result: changing it reruns nothing.\n" : "") + slots;
}

std::string pipeline_components(const TypeDeclaration& declaration)
{
    std::vector<std::vector<std::string>> rows;
    for (const OptionDeclaration& component : declaration.components)
        rows.push_back({code(component.name), link(component.default_value.at("type").as_string()),
                        component.optional ? "may be none" : "", cell(component.help)});
    return rows.empty()
               ? ""
               : "\n## Components\n\nThe pipeline [chooses them](../pipelines.md#shared-components) for all its stages.\n\n" +
                     table({"kind", "default", "", ""}, rows);
}

std::string page_text(const TypeDescription& type, const TypeDeclaration& declaration, const TypeTable& types)
{
    std::string text = std::string(written_by) + "# " + type.type + "\n\n" + cell(type.help) + ".\n\n" +
                       (type.kind == "stage" ? "A stage" : "A component of kind " + code(type.kind)) + ", in the plugin " +
                       code(type.library.stem().string()) + ".\n";
    if (!declaration.artifact.empty() && !declaration.extensions.empty())
    {
        text += "It reads " + code(declaration.artifact) + " from files that end in " +
                join(each(declaration.extensions, code), ", ") + ".\n";
    }
    if (const std::string marks = marks_text(declaration.marks); !marks.empty())
        text += "It is known by " + cell(marks) + ".\n";
    return text + ports("Inputs", declaration.inputs) + ports("Outputs", declaration.outputs) + options(declaration, types) +
           pipeline_components(declaration);
}

struct Users
{
    std::set<std::string> makers;
    std::set<std::string> takers;
};

std::string contents_text(const Catalog& catalog, const std::map<std::string, Users>& artifacts)
{
    std::string text =
        std::string(written_by) + "# Reference\n\nEvery stage and component. `fresco describe TYPE` prints the same.\n";
    // Stages come first.
    std::map<std::pair<bool, std::string>, std::vector<std::vector<std::string>>> kinds;
    for (const TypeDescription* type : catalog.types())
        kinds[{type->kind != "stage", type->kind}].push_back({link(type->type), cell(type->help)});
    for (const auto& [kind, rows] : kinds)
        text += "\n## " + (kind.first ? "Components of kind " + kind.second : "Stages") + "\n\n" + table({"type", ""}, rows);
    std::vector<std::vector<std::string>> rows;
    for (const auto& [artifact, users] : artifacts)
        rows.push_back({code(artifact), join(each(users.makers, link), ", "), join(each(users.takers, link), ", ")});
    return rows.empty() ? text : text + "\n## Artifacts\n\n" + table({"artifact", "made or read by", "taken by"}, rows);
}

bool is_page(const fs::path& file)
{
    return file.extension() == ".md" && fs::is_regular_file(file) && read_text_file(file).starts_with(written_by);
}

}  // namespace

ReferencePages reference_pages(const Catalog& catalog)
{
    ReferencePages pages;
    const TypeTable types(catalog);
    std::map<std::string, Users> artifacts;
    for (const TypeDescription* type : catalog.types())
    {
        const TypeDeclaration declaration = read_declaration(*type);
        for (const PortDeclaration& port : declaration.inputs)
            artifacts[port.artifact].takers.insert(type->type);
        for (const PortDeclaration& port : declaration.outputs)
            artifacts[port.artifact].makers.insert(type->type);
        if (!declaration.artifact.empty())
            artifacts[declaration.artifact].makers.insert(type->type);
        pages[type->type + ".md"] = page_text(*type, declaration, types);
    }
    pages["README.md"] = contents_text(catalog, artifacts);
    return pages;
}

std::vector<std::string> write_reference(const ReferencePages& pages, const fs::path& folder)
{
    fs::create_directories(folder);
    std::vector<std::string> changed;
    for (const auto& entry : fs::directory_iterator(folder))
        if (const std::string name = entry.path().filename(); !pages.contains(name) && is_page(entry.path()))
        {
            fs::remove(entry);
            changed.push_back(name);
        }
    for (const auto& [name, text] : pages)
    {
        const fs::path file = folder / name;
        if (fs::exists(file) && !is_page(file))
            throw Error(file.string() + ": exists and is not a page of the reference; move it away");
        if (fs::exists(file) && read_text_file(file) == text)
            continue;
        write_file(file, text);
        changed.push_back(name);
    }
    return changed;
}

}  // namespace fresco::host
