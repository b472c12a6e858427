#include "worker/command_forms.h"
#include "worker/command_words.h"

#include <fresco/error.h>
#include <fresco/host/pipeline_commands.h>
#include <fresco/host/pipeline_document.h>
#include <fresco/host/process.h>
#include <fresco/wording.h>

#include <algorithm>
#include <optional>
#include <set>
#include <unistd.h>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

std::string owner_of(const OptionDeclaration& option, const std::string& user)
{
    return user + ": option '" + option.name + "'";
}

/// Where a list is wanted.
bool is_list(const OptionDeclaration& option, const YamlNode& node, const std::string& user, ProblemList& problems)
{
    if (!node.is_list() && node.is_valid())
        problems.add(node.position(), owner_of(option, user) + ": expected " + option.accepted() + ", got " + node.summary());
    return node.is_list();
}

/// A word of a list: a scalar as it is written.
bool is_word(const OptionDeclaration& option, const YamlNode& item, const std::string& user, ProblemList& problems)
{
    if (item.is_scalar())
        return true;
    if (item.is_valid())
        problems.add(item.position(), owner_of(option, user) + ": each entry is a word, got " + item.summary() +
                                          (item.is_map() ? " (a word with braces is written in quotes)" : ""));
    return false;
}

struct KnownArtifact
{
    int version = 1;
    std::vector<std::string> as;
};

/// Every artifact that a program can make, and for an input those of the plugins' ports, too.
std::map<std::string, KnownArtifact> known_artifacts(bool inputs, TypeTable& types)
{
    std::map<std::string, KnownArtifact> known;
    if (inputs)
        for (const TypeDescription* type : types.of_kind("stage"))
            if (const KnownType stage = types.find(type->type, "stage"))
                for (const PortDeclaration& port : stage.declaration->outputs)
                    known[port.artifact].version = port.version;
    for (const ExchangeForm& form : exchange_forms())
        known[std::string(form.artifact)] = {form.version, {form.as.begin(), form.as.end()}};
    return known;
}

std::vector<std::string> names_of(const std::map<std::string, KnownArtifact>& known)
{
    std::vector<std::string> names;
    names.reserve(known.size());
    for (const auto& [name, artifact] : known)
        names.push_back(name);
    return names;
}

class PortChecker
{
  public:
    PortChecker(const OptionDeclaration& option, const std::string& user, TypeTable& types, ProblemList& problems)
        : owner_(owner_of(option, user)), known_(known_artifacts(option.name == "inputs", types)), problems_(problems)
    {
    }

    Value check(const YamlNode::Entry& entry)
    {
        const std::string where = owner_ + ": port '" + entry.key + "'";
        const YamlNode& node = entry.value;
        if (!is_name(entry.key))
            return refuse(entry.position(), where + ": a name is made of letters, digits, '_' and '-'");
        const YamlNode::Entry* artifact = node.is_map() ? node.find("artifact") : nullptr;
        const YamlNode& named = artifact ? artifact->value : node;
        if (!named.is_valid())
            return {};
        if (!named.is_scalar() || named.text.empty())
            return refuse(node.is_null() ? entry.position() : node.position(),
                          where + ": expected an artifact such as mesh, or {artifact: …, as: …}, got " + node.summary());
        const auto known = known_.find(named.text);
        if (known == known_.end())
            return refuse(named.position(), where + ": '" + named.text + "' is no artifact that a program can " +
                                                (owner_.ends_with("'outputs'") ? "make" : "take") +
                                                suggestion(named.text, names_of(known_)));
        std::string as = known->second.as.empty() ? "" : known->second.as.front();
        for (const YamlNode::Entry& key : node.entries)
        {
            if (key.key == "artifact")
                continue;
            if (key.key != "as")
                return refuse(key.position(), where + " has no '" + key.key + "'" + suggestion(key.key, {"artifact", "as"}));
            const auto& forms = known->second.as;
            if (forms.empty())
                return refuse(key.position(), where + ": " + named.text + " has one form alone; leave 'as' out");
            if (!key.value.is_scalar() || std::find(forms.begin(), forms.end(), key.value.text) == forms.end())
                return refuse(key.position(),
                              where + ": as: expected one of " + join(forms, ", ") + ", got " + key.value.summary());
            as = key.value.text;
        }
        return Value::Map{{"artifact", named.text}, {"version", known->second.version}, {"as", as}};
    }

  private:
    Value refuse(const Position& at, const std::string& text)
    {
        problems_.add(at, text);
        return {};
    }

    std::string owner_;
    std::map<std::string, KnownArtifact> known_;
    ProblemList& problems_;
};

Value::Map ports_of(const Value& options, const char* option)
{
    const Value* ports = options.find(option);
    return ports != nullptr && ports->is_map() ? ports->as_map() : Value::Map{};
}

Value declared_ports(const Value::Map& ports)
{
    Value::List list;
    for (const auto& [name, port] : ports)
        list.push_back(
            Value::Map{{"name", name}, {"artifact", port.at("artifact")}, {"version", port.at("version")}, {"help", ""}});
    return list;
}

/// What the words of `run` hold, against the files and ports of the stage.
class WordsChecker
{
  public:
    WordsChecker(const StageDraft& draft, ProblemList& problems)
        : draft_(draft), problems_(problems), inputs_(ports_of(draft.options, "inputs")),
          outputs_(ports_of(draft.options, "outputs")), files_(ports_of(draft.options, "files"))
    {
    }

    void check()
    {
        const YamlNode& run = draft_.config.find("run")->value;
        if (run.items.empty())
            problems_.add(run.position(), draft_.title() + ": option 'run' is empty: name a program");
        for (std::size_t i = 0; i < run.items.size(); ++i)
            check_word(run.items[i], i == 0);
        for (const auto& [name, port] : inputs_)
            if (find(outputs_, name) != nullptr)
                report_twice(name);
        for (const auto& [name, port] : outputs_)
            if (!used_.contains(name))
                report_unused(name);
        if (outputs_.empty())
            problems_.add(place("outputs"), draft_.title() + ": there is no output, so nothing that could be kept");
    }

  private:
    void report_twice(const std::string& name)
    {
        problems_.add(place("outputs"), draft_.title() + ": '" + name + "' is an input and an output; one needs another name");
    }

    void report_unused(const std::string& name)
    {
        problems_.add(place("run"), draft_.title() + ": no word of 'run' says where the output '" + name + "' goes: write \"{" +
                                        name + "}\" where the program takes the path");
    }

    static const Value* find(const Value::Map& map, const std::string& name)
    {
        for (const auto& [key, value] : map)
            if (key == name)
                return &value;
        return nullptr;
    }

    Position place(const char* option) const
    {
        const YamlNode::Entry* entry = draft_.config.find(option);
        return entry ? entry->position() : draft_.position;
    }

    void check_word(const YamlNode& word, bool program)
    {
        const bool file = find(files_, word.text) != nullptr;
        bool has_names = false;
        try
        {
            if (!file)
                for (const auto& name : names_in(word.text))
                {
                    has_names = true;
                    check_name(word, name);
                }
        }
        catch (const Error& error)
        {
            problems_.add(word.position(), draft_.title() + ": " + error.what());
            return;
        }
        if (program)
            check_program(word, file, has_names);
        else if (!file && !has_names && is_file_beside(word))
            problems_.add(word.position(),
                          draft_.title() + ": '" + word.text +
                              "' is a file here, but not among 'files': add it there, so that the program finds it "
                              "and runs again when it changes");
    }

    void check_name(const YamlNode& word, const std::string& name)
    {
        if (find(outputs_, name) != nullptr)
            used_.insert(name);
        else if (find(inputs_, name) == nullptr && find(files_, name) == nullptr)
        {
            std::vector<std::string> names;
            for (const auto* map : {&inputs_, &outputs_, &files_})
                for (const auto& [known, value] : *map)
                    names.push_back(known);
            problems_.add(word.position(), draft_.title() + ": {" + name + "} in 'run' is neither a port nor among 'files'" +
                                               suggestion(name, names));
        }
    }

    void check_program(const YamlNode& word, bool file, bool has_names)
    {
        const auto report = [&](const std::string& text, ProblemKind kind)
        { problems_.add(word.position(), draft_.title() + ": " + text, kind); };
        if (has_names)
            return report("the program cannot be a {name}: name it, or put its file among 'files'", ProblemKind::invalid);
        const std::string path = file ? find(files_, word.text)->as_string() : word.text;
        const bool relative = !file && path.find('/') != std::string::npos && fs::path(path).is_relative();
        if (relative)
            return report("'" + path + "' is a relative path that is not among 'files': add it there", ProblemKind::invalid);
        if (!find_program(path).empty())
            return;
        if (file || fs::exists(path))
            report("'" + path + "' may not be executed: chmod +x, or put the program that runs it before it",
                   ProblemKind::missing_input);
        else
            report("there is no program '" + path + "'" + (path.find('/') == std::string::npos ? " in PATH" : "") +
                       ": install it, or write its absolute path",
                   ProblemKind::missing_input);
    }

    static bool is_file_beside(const YamlNode& word)
    {
        std::error_code error;
        return !word.text.empty() && fs::path(word.text).is_relative() &&
               fs::is_regular_file(word.path_base() / word.text, error);
    }

    const StageDraft& draft_;
    ProblemList& problems_;
    Value::Map inputs_;
    Value::Map outputs_;
    Value::Map files_;
    std::set<std::string> used_;
};

/// Whether each port of the file was understood.
bool has_all_ports(const StageDraft& draft)
{
    for (const char* option : {"inputs", "outputs"})
        if (const YamlNode::Entry* entry = draft.config.find(option))
            if (entry->value.entries.size() != ports_of(draft.options, option).size())
                return false;
    return draft.options.find("run") != nullptr && draft.options.find("outputs") != nullptr &&
           (draft.config.find("files") == nullptr || draft.options.find("files") != nullptr);
}

bool needs_codec(const Value& options)
{
    for (const char* option : {"inputs", "outputs"})
        for (const auto& [name, port] : ports_of(options, option))
            if (port.at("as").as_string() == "png")
                return true;
    return false;
}

}  // namespace

std::string cost_name(const PipelineStage& stage)
{
    std::string name = stage.type->type;
    const Value* run = name == command_type_name ? stage.options.find("run") : nullptr;
    if (run == nullptr)
        return name;
    // Further words are settings, which differ from one value of an axis to the next.
    constexpr std::size_t telling_words = 3;
    const Value::List& words = run->as_list();
    for (std::size_t i = 0; i < std::min(telling_words, words.size()); ++i)
        name += " " + words[i].as_string();
    for (const auto& [file, path] : ports_of(stage.options, "files"))
        name += " " + file;
    return name;
}

Value check_texts(const OptionDeclaration& option, const YamlNode& node, const std::string& user, ProblemList& problems)
{
    if (!is_list(option, node, user, problems))
        return {};
    Value::List words;
    for (const YamlNode& item : node.items)
    {
        if (!is_word(option, item, user, problems))
            return {};
        words.emplace_back(item.text);
    }
    return words;
}

Value check_input_files(const OptionDeclaration& option, const YamlNode& node, const std::string& user, OptionUses& uses,
                        ProblemList& problems)
{
    if (!is_list(option, node, user, problems))
        return {};
    Value files = Value::Map{};
    for (const YamlNode& item : node.items)
    {
        if (!is_word(option, item, user, problems))
            return {};
        const fs::path path = check_input_path(item, false, owner_of(option, user), problems);
        files.set(item.text, path.string());
        uses.input_files.push_back(path);
    }
    return files;
}

Value check_ports(const OptionDeclaration& option, const YamlNode& node, const std::string& user, TypeTable& types,
                  ProblemList& problems)
{
    if (!node.is_map())
    {
        if (node.is_valid())
            problems.add(node.position(), owner_of(option, user) + ": expected " + option.accepted() + ", got " + node.summary());
        return {};
    }
    PortChecker checker(option, user, types, problems);
    Value ports = Value::Map{};
    for (const YamlNode::Entry& entry : node.entries)
        if (Value port = checker.check(entry); !port.is_null())
            ports.set(entry.key, std::move(port));
    return ports;
}

void complete_command(StageDraft& draft, OptionChecker& checker, TypeTable& types, ProblemList& problems)
{
    if (!has_all_ports(draft))
    {
        // Reported already; of ports that are not known nothing can be said.
        draft.type = {};
        return;
    }
    if (draft.options.find("images") == nullptr && needs_codec(draft.options))
    {
        const YamlNode codec = yaml_from_value("image.opencv", draft.config);
        Value images = checker.complete_component("image_io", codec, {}, draft.title() + ": option 'images'", draft.uses);
        if (!images.is_null())
            draft.options.set("images", std::move(images));
    }
    WordsChecker(draft, problems).check();

    auto own = std::make_shared<TypeDescription>(*draft.type.description);
    own->declaration.set("inputs", declared_ports(ports_of(draft.options, "inputs")));
    own->declaration.set("outputs", declared_ports(ports_of(draft.options, "outputs")));
    draft.own_type = own;
    draft.type = types.adopt(std::move(own));
}

}  // namespace fresco::host
