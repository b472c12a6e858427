#include "worker/origin.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

namespace fresco::host
{
namespace
{

constexpr std::size_t most_stages = 100;
constexpr std::size_t longest_list = 4;
constexpr std::size_t longest_map = 16;
constexpr std::size_t most_entries = 64;

/// An input file as the key has it, under the name that the user gave it.
Value named_file(const Value& identity, const std::string& path)
{
    return Value::Map{{"file", std::filesystem::path(path).filename().string()}, {"xxh128", identity.at("contents")}};
}

bool is_file_identity(const Value& key)
{
    return key.find("contents") != nullptr && key.find("extension") != nullptr;
}

/// An option as the key has it; `given`: the same as the stage gets it, with the names of files. Null: unknown.
Value told_option(const Value& key, const Value* given)
{
    if (is_file_identity(key))
        return named_file(key, given != nullptr && given->is_string() ? given->as_string() : "");
    if (key.is_string())
        return without_folders(key.as_string());
    if ((key.is_list() && key.as_list().size() > most_entries) || (key.is_map() && key.as_map().size() > most_entries))
        return "more than " + std::to_string(most_entries) + " entries";
    if (key.is_list())
    {
        Value::List list;
        for (const Value& entry : key.as_list())
            list.push_back(told_option(entry, nullptr));
        return list;
    }
    if (!key.is_map())
        return key;
    const Value* options = key.find("type") != nullptr ? key.find("options") : nullptr;
    Value::Map map;
    if (options != nullptr)
        map.emplace_back("type", key.at("type"));
    for (const auto& [name, value] : (options != nullptr ? *options : key).as_map())
        map.emplace_back(name, told_option(value, given == nullptr ? nullptr : given->find(name)));
    return map;
}

bool is_time(std::string_view name)
{
    return name.ends_with("_s") || name.find("seconds") != std::string_view::npos;
}

bool is_plain(const Value& value)
{
    return value.is_bool() || value.is_number() || value.is_string();
}

/// Null: nothing to keep.
Value lasting(const Value& value)
{
    if (value.is_string())
        return without_folders(value.as_string());
    if (is_plain(value))
        return value;
    if (value.is_list() && value.as_list().size() <= longest_list && std::ranges::all_of(value.as_list(), is_plain))
        return told_option(value, nullptr);
    if (!value.is_map() || value.as_map().size() > longest_map)
        return {};
    Value::Map kept;
    for (const auto& [name, entry] : value.as_map())
        if (Value figure = is_time(name) ? Value() : lasting(entry); !figure.is_null())
            kept.emplace_back(name, std::move(figure));
    return kept.empty() ? Value() : Value(std::move(kept));
}

/// What an earlier result's manifest keeps, its last entry under the name of the result.
Value::List earlier_stages(const Store& store, const std::string& object)
{
    const Value manifest = store.manifest(object);
    const Value* origin = manifest.find("origin");
    if (origin == nullptr || origin->as_list().empty())
        return {};
    Value::List stages = origin->as_list();
    stages.back().set("result", object);
    return stages;
}

}  // namespace

std::string without_folders(std::string_view text)
{
    constexpr std::string_view before = " \t\n=:,;'\"([{<>|";
    for (std::size_t at = 0; at < text.size(); ++at)
    {
        const bool begins = at == 0 || before.find(text[at - 1]) != std::string_view::npos;
        const bool is_home = text.substr(at).starts_with("~");
        const bool is_address =
            at > 0 && text[at - 1] == ':' && text.substr(at).starts_with("//") && !text.substr(0, at).ends_with("file:");
        if (!begins || is_address || !(is_home || text[at] == '/'))
            continue;
        // A path may contain spaces: nobody knows where one ends before the last slash.
        std::size_t last = text.rfind('/');
        if (last == text.size() - 1 && last > at)
            last = text.rfind('/', last - 1);
        if (last == std::string_view::npos || last < at)
            continue;
        return std::string(text.substr(0, at)) + std::string(text.substr(last + 1));
    }
    return std::string(text);
}

Value origin_of(const WorkerRequest& request, const Store& store, Value versions)
{
    std::vector<const WorkerInput*> inputs;
    for (const WorkerInput& input : request.inputs)
        inputs.push_back(&input);
    std::ranges::sort(inputs, {}, &WorkerInput::port);

    Value::List stages;
    std::set<std::string> known;
    Value::Map from;
    for (const WorkerInput* input : inputs)
    {
        if (input->object.empty())
        {
            from.emplace_back(input->port, named_file(request.key_document.at("inputs").at(input->port), input->file.string()));
            continue;
        }
        from.emplace_back(input->port, Value::Map{{"result", input->object}, {"output", input->output}});
        for (Value& stage : earlier_stages(store, input->object))
            if (known.insert(stage.at("result").as_string()).second)
                stages.push_back(std::move(stage));
    }
    stages.push_back(Value::Map{{"type", request.type},
                                {"options", told_option(request.key_document.at("options"), &request.options)},
                                {"inputs", std::move(from)},
                                {"versions", std::move(versions)}});
    if (stages.size() > most_stages)
        stages.erase(stages.begin(), stages.end() - most_stages);
    return stages;
}

Value with_figures(Value origin, const Value& report)
{
    Value figures = Value::Map{};
    for (const auto& [name, value] : report.as_map())
        if (Value figure = is_time(name) ? Value() : lasting(value); !figure.is_null())
            figures.set(name, std::move(figure));
    if (!figures.as_map().empty())
        origin.as_list().back().set("figures", std::move(figures));
    return origin;
}

Value told_origin(const Value& origin)
{
    std::map<std::string, std::set<std::string>> versions;
    std::map<std::string, int> counts;
    std::map<std::string, std::string> names;  // By the result.
    Value::List stages;
    for (const Value& entry : origin.as_list())
    {
        for (const auto& [library, version] : entry.at("versions").as_map())
            versions[library].insert(version.as_string());
        const std::string& type = entry.at("type").as_string();
        const int count = ++counts[type];
        const std::string name = count == 1 ? type : type + " " + std::to_string(count);
        if (const Value* result = entry.find("result"))
            names[result->as_string()] = name;
        Value::Map inputs;
        for (const auto& [port, input] : entry.at("inputs").as_map())
        {
            const Value* result = input.find("result");
            if (result == nullptr)
                inputs.emplace_back(port, input);
            else if (const auto from = names.find(result->as_string()); from != names.end())
                inputs.emplace_back(port, from->second);
        }
        Value stage = Value::Map{{"stage", name}, {"options", entry.at("options")}, {"inputs", std::move(inputs)}};
        if (const Value* figures = entry.find("figures"))
            stage.set("figures", *figures);
        stages.push_back(std::move(stage));
    }
    Value::Map all;
    for (const auto& [library, several] : versions)
    {
        std::string text;
        for (const std::string& version : several)
            text += (text.empty() ? "" : ", ") + version;
        all.emplace_back(library, std::move(text));
    }
    return Value::Map{{"versions", std::move(all)}, {"stages", std::move(stages)}};
}

}  // namespace fresco::host
