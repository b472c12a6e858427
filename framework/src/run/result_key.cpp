#include "run/result_key.h"
#include "base/common.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <vector>

namespace fresco::host
{
namespace
{

constexpr int key_format = 1;

Value file_identity(const std::filesystem::path& file, FileHashes& hashes)
{
    return Value::Map{{"contents", hashes.hash(file)}, {"extension", file.extension().string()}};
}

Value sorted_map(Value::Map map)
{
    std::ranges::sort(map, {}, &Value::Entry::first);
    return map;
}

class KeyMaker
{
  public:
    KeyMaker(const PipelineStage& stage, FileHashes& hashes) : stage_(stage), hashes_(hashes) {}

    Value options(const Value& options, const Value& declaration)
    {
        Value::Map map;
        for (const char* list : {"options", "components"})
            if (const Value* all = declaration.find(list))
                for (const Value& declared : all->as_list())
                {
                    const Value* in_key = declared.find("in_key");
                    const std::string& name = declared.at("name").as_string();
                    const Value* value = options.find(name);
                    if ((in_key == nullptr || in_key->as_bool()) && value != nullptr && !value->is_null())
                        map.emplace_back(name, option(*value, declared.at("kind").as_string()));
                }
        return sorted_map(std::move(map));
    }

    Value component(const Value& config)
    {
        const std::string& type = config.at("type").as_string();
        const auto found = std::ranges::find(stage_.components, type, &TypeDescription::type);
        if (found == stage_.components.end())
            throw Error("the stage " + stage_.name + " does not list its component " + type);
        return Value::Map{{"type", type}, {"options", options(config, (*found)->declaration)}};
    }

  private:
    Value option(const Value& value, const std::string& kind)
    {
        if (kind == "input_file")
            return value.as_string().empty() ? value : file_identity(value.as_string(), hashes_);
        const auto of_each = [&](const auto& make)
        {
            const auto made = [&](const Value::Entry& entry) { return Value::Entry{entry.first, make(entry.second)}; };
            return sorted_map(each<Value::Entry>(value.as_map(), made));
        };
        if (kind == "input_files")
            return of_each([&](const Value& file) { return file_identity(file.as_string(), hashes_); });
        if (kind == "number")
            return value.as_double();
        if (kind == "numbers")
            return each<Value>(value.as_list(), &Value::as_double);
        if (kind == "component")
            return component(value);
        if (kind == "components")
            return of_each([&](const Value& config) { return component(config); });
        return value;
    }

    const PipelineStage& stage_;
    FileHashes& hashes_;
};

Value library_identity(const TypeDescription& type)
{
    return Value::Map{{"hash", type.bytes->hash()}, {"versions", type.library_versions}};
}

std::string shown(const Value* value)
{
    const std::string text = value == nullptr ? "not set" : to_json(*value);
    constexpr std::size_t longest = 60;
    return text.size() <= longest ? text : text.substr(0, longest) + "…";
}

/// Names of entries that differ between two maps, in the order of `now`, then those that are gone.
std::vector<std::string> differing_entries(const Value& before, const Value& now)
{
    std::vector<std::string> names;
    for (const auto& [name, value] : now.as_map())
        if (const Value* old = before.find(name); old == nullptr || !(*old == value))
            names.push_back(name);
    for (const auto& [name, value] : before.as_map())
        if (now.find(name) == nullptr)
            names.push_back(name);
    return names;
}

std::string explain_option(const std::string& name, const Value& before, const Value& now)
{
    const Value* old = before.find(name);
    const Value* current = now.find(name);
    const auto is_file = [](const Value* value) { return value != nullptr && value->find("contents") != nullptr; };
    const auto lists_files = [&](const Value* value)
    { return value != nullptr && value->is_map() && !value->as_map().empty() && is_file(&value->as_map().front().second); };
    if (lists_files(old) && lists_files(current))
        return "among the " + name + ", " + differing_entries(*old, *current).front() + " changed";
    if (is_file(old) && is_file(current))
        return "the file of option " + name + " changed";
    if (is_file(old) || is_file(current))
        return "option " + name + " names another file";
    return "option " + name + " was " + shown(old) + ", is " + shown(current);
}

std::string explain_library(const std::string& type, const Value* before, const Value* now)
{
    if (before == nullptr || now == nullptr)
        return now == nullptr ? "component " + type + " is no longer used" : "component " + type + " is new";
    if (!(before->at("hash") == now->at("hash")))
        return "the plugin of " + type + " was rebuilt";
    const auto names = differing_entries(before->at("versions"), now->at("versions"));
    const std::string& name = names.empty() ? type : names.front();
    return "the library " + name + " was " + shown(before->at("versions").find(name)) + ", is " +
           shown(now->at("versions").find(name));
}

}  // namespace

Value key_document(const PipelineStage& stage, const std::map<std::string, std::string>& objects, FileHashes& hashes)
{
    KeyMaker maker(stage, hashes);
    Value::Map inputs;
    for (const auto& wire : stage.wires)
    {
        Value input;
        if (wire.from_stage.empty())
        {
            input = file_identity(wire.file, hashes);
            input.set("reader", maker.component(wire.reader));
        }
        else
            input = Value::Map{{"result", objects.at(wire.from_stage)}, {"output", wire.from_port}};
        inputs.emplace_back(wire.port, std::move(input));
    }
    Value::Map libraries{{stage.type->type, library_identity(*stage.type)}};
    for (const TypeDescription* component : stage.components)
        libraries.emplace_back(component->type, library_identity(*component));
    return Value::Map{{"format", key_format},
                      {"type", stage.type->type},
                      {"options", maker.options(*stage.options, stage.type->declaration)},
                      {"inputs", sorted_map(std::move(inputs))},
                      {"libraries", sorted_map(std::move(libraries))}};
}

std::string key_of(const Value& key_document)
{
    return content_hash(to_json(key_document));
}

std::string explain_difference(const Value& before, const Value& now, const PipelineStage& stage)
{
    if (!(before.at("type") == now.at("type")))
        return "the type was " + before.at("type").as_string();
    std::vector<std::string> reasons;
    for (const auto& name : differing_entries(before.at("options"), now.at("options")))
        reasons.push_back(explain_option(name, before.at("options"), now.at("options")));
    for (const auto& port : differing_entries(before.at("inputs"), now.at("inputs")))
    {
        const auto wire = std::ranges::find(stage.wires, port, &Wire::port);
        reasons.push_back("the input " + port +
                          (wire == stage.wires.end()  ? ""
                           : wire->from_stage.empty() ? " (" + wire->file.string() + ")"
                                                      : " (from " + wire->from_stage + ")") +
                          " changed");
    }
    for (const auto& type : differing_entries(before.at("libraries"), now.at("libraries")))
        reasons.push_back(explain_library(type, before.at("libraries").find(type), now.at("libraries").find(type)));
    if (reasons.empty())
        return "";
    const std::string more = reasons.size() > 2 ? "; and " + std::to_string(reasons.size() - 2) + " more changes" : "";
    return reasons[0] + (reasons.size() > 1 ? "; " + reasons[1] : "") + more;
}

}  // namespace fresco::host
