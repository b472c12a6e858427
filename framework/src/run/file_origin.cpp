#include "run/file_origin.h"

#include "base/process.h"
#include "base/text_layout.h"
#include "plugins/declaration.h"
#include "plugins/plugin_library.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/reader.h>

#include <array>
#include <ostream>
#include <poll.h>

namespace fresco::host
{
namespace
{

/// What the process that opens the library says of the file.
Value answer_of(const Child& child)
{
    LineBuffer lines;
    LineBuffer printed;
    ProcessEnd end;
    while (!take_group_end(child.pid, end))
    {
        std::array<pollfd, 2> descriptors{pollfd{child.channel.get(), POLLIN, 0}, pollfd{child.output.get(), POLLIN, 0}};
        poll(descriptors.data(), descriptors.size(), 20);
        lines.read_from(child.channel.get());
        printed.read_from(child.output.get());
    }
    lines.read_from(child.channel.get());
    std::string line;
    if (lines.next(line))
        return parse_json(line, "the answer of the process that reads the file");
    throw Error("the process that reads the file " +
                (end.signal != 0 ? "ended by " + signal_text(end.signal) : "ended with code " + std::to_string(end.exit_code)));
}

std::string value_text(const Value& value)
{
    return value.is_string() ? value.as_string() : to_json(value);
}

/// "waves.jpg (xxh128 0123…)", or the stage.
std::string input_text(const Value& input)
{
    if (const Value* name = input.find("file"))
        return name->as_string() + " (xxh128 " + input.at("xxh128").as_string() + ")";
    return value_text(input);
}

std::string join_words(const Value& words)
{
    std::string text;
    for (const Value& word : words.as_list())
        text += (text.empty() ? "" : " ") + word.as_string();
    return text;
}

void write_stage(const Value& stage, std::size_t width, std::ostream& out)
{
    using Kind = TextTable::Kind;
    constexpr std::size_t indent = 2;
    out << '\n' << stage.at("stage").as_string() << '\n';
    TextTable table({{"", Kind::figure}, {"", Kind::figure}, {"", Kind::text}}, indent);
    for (const auto& [name, input] : stage.at("inputs").as_map())
        table.add({"input", name, input_text(input)});
    for (const auto& [name, option] : stage.at("options").as_map())
        table.add({"option", name, input_text(option)});
    if (const Value* figures = stage.find("figures"))
        for (const auto& [name, figure] : figures->as_map())
            table.add({"figure", name, value_text(figure)});
    out << table.text(width);
}

}  // namespace

const TypeDescription* origin_reader(const Catalog& catalog, const std::string& file)
{
    for (const TypeDescription* type : catalog.types())
        if (type->kind == FileOrigin::component_kind)
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
    out << file.string() << ": made with";
    const char* separator = " ";
    for (const auto& [library, version] : origin.at("versions").as_map())
    {
        out << separator << library << ' ' << version.as_string();
        separator = ", ";
    }
    out << '\n';
    for (const Value& stage : origin.at("stages").as_list())
        write_stage(stage, width, out);
}

int internal_origin(const std::filesystem::path& library, const std::string& type, const std::filesystem::path& file)
{
    Value answer = Value::Map{};
    try
    {
        const std::unique_ptr<Configurable> object = PluginLibrary::open(library).make(type);
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
    send_all(child_channel, to_json(answer) + "\n");
    return 0;
}

void write_run_origin(const std::filesystem::path& file, bool json, std::ostream& out)
{
    const Value run = parse_json(read_text_file(file), file.string());
    const Value* format = run.find("format");
    if (format == nullptr || !format->is_string() || !format->as_string().starts_with("fresco-"))
        throw Error(file.string() + ": is not the report of a run; 'fresco stages' lists the types that can be described");
    if (json)
    {
        out << to_json(run, 2) << '\n';
        return;
    }
    out << file.string() << ": report of a run of " << run.at("pipeline").at("file").as_string() << '\n';
    TextTable table({{"", TextTable::Kind::figure}, {"", TextTable::Kind::text}}, 2);
    table.add({"format", format->as_string() + ", version " + std::to_string(run.at("version").as_int()) +
                             ": pipelines/results.md says what is in it"});
    table.add({"fresco", run.at("fresco").as_string()});
    table.add({"time", run.at("time").as_string()});
    table.add({"command", join_words(run.at("command"))});
    table.add({"exit code", std::to_string(run.at("exit_code").as_int())});
    out << table.text(without_end);
}

}  // namespace fresco::host
