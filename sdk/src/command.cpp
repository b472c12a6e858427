#include <fresco/command.h>
#include <fresco/error.h>
#include <fresco/process.h>
#include <fresco/wording.h>

#include <set>
#include <type_traits>

namespace fresco
{
namespace fs = std::filesystem;
namespace
{

/// Calls text(piece) and name(piece) in the order of the word.
template <class Text, class Name>
void walk(std::string_view word, const Text& text, const Name& name)
{
    const auto refuse = [&](const char* brace)
    {
        throw Error("'" + std::string(word) + "' has a '" + brace + "' without its other: a {name} stands for a port's path, " +
                    brace + brace + " for a brace");
    };
    for (std::size_t i = 0; i < word.size(); ++i)
    {
        const bool brace = word[i] == '{' || word[i] == '}';
        if (!brace)
            text(word.substr(i, 1));
        else if (i + 1 < word.size() && word[i + 1] == word[i])
            text(word.substr(i++, 1));
        else if (word[i] == '}')
            refuse("}");
        else
        {
            const auto end = word.find_first_of("{}", i + 1);
            if (end == std::string_view::npos || word[end] != '}')
                refuse("{");
            name(std::string(word.substr(i + 1, end - i - 1)));
            i = end;
        }
    }
}

/// The options of one kind together.
struct Named
{
    std::string option;  ///< The last of them, for messages.
    std::map<std::string, Value> values{};
};

class Checker
{
  public:
    Checker(const std::vector<OptionDeclaration>& options, const Value& values) : values_(values)
    {
        for (const OptionDeclaration& option : options)
            for (auto& [kind, named] : named_)
                if (option.kind == kind)
                {
                    named.option = option.name;
                    if (const Value* value = values.find(option.name); value != nullptr && value->is_map())
                        named.values.insert(value->as_map().begin(), value->as_map().end());
                }
    }

    template <class FolderOf>
    void check_words(const OptionDeclaration& option, const FolderOf& folder_of)
    {
        const Value* words = values_.find(option.name);
        if (words == nullptr)
            return;
        option_ = option.name;
        if (words->as_list().empty())
            report(-1, "option '" + option_ + "' is empty: name a program");
        for (std::size_t i = 0; i < words->as_list().size(); ++i)
            check_word(words->as_list()[i].as_string(), i, folder_of(option_, i));
    }

    std::vector<CommandLineProblem> finish()
    {
        for (const auto& [name, port] : inputs_.values)
            if (outputs_.values.contains(name))
                problems_.push_back({outputs_.option, -1, "'" + name + "' is an input and an output; one needs another name"});
        for (const auto& [name, port] : outputs_.values)
            if (!option_.empty() && !used_.contains(name))
                report(-1, "no word of '" + option_ + "' says where the output '" + name + "' goes: write \"{" + name +
                               "}\" where the program takes the path");
        if (!outputs_.option.empty() && outputs_.values.empty())
            problems_.push_back({outputs_.option, -1, "a command needs at least one output"});
        return std::move(problems_);
    }

  private:
    void report(int word, std::string text, bool is_missing = false)
    {
        problems_.push_back({option_, word, std::move(text), is_missing});
    }

    void check_word(const std::string& word, std::size_t number, const fs::path& folder)
    {
        const int place = static_cast<int>(number);
        const bool is_file = files_.values.contains(word);
        std::vector<std::string> names;
        try
        {
            if (!is_file)
                names = names_in(word);
        }
        catch (const Error& error)
        {
            return report(place, error.what());
        }
        for (const std::string& name : names)
            check_name(name, place);
        std::error_code error;
        if (number == 0)
            check_program(word, is_file, !names.empty());
        else if (!is_file && names.empty() && !word.empty() && fs::path(word).is_relative() &&
                 fs::is_regular_file(folder / word, error))
            report(place, "'" + word + "' is a file here, but not among " + files() +
                              ": add it there, so that the program finds it and runs again when it changes");
    }

    void check_name(const std::string& name, int place)
    {
        if (outputs_.values.contains(name))
            used_.insert(name);
        else if (!inputs_.values.contains(name) && !files_.values.contains(name))
        {
            std::vector<std::string> known;
            for (const auto* named : {&inputs_, &outputs_, &files_})
                for (const auto& [each, value] : named->values)
                    known.push_back(each);
            report(place, "{" + name + "} in '" + option_ + "' is neither a port nor among " + files() + suggestion(name, known));
        }
    }

    void check_program(const std::string& word, bool is_file, bool has_names)
    {
        if (has_names)
            return report(0, "the program cannot be a {name}: name it, or put its file among " + files());
        const std::string path = is_file ? files_.values.at(word).as_string() : word;
        const bool has_folder = path.find('/') != std::string::npos;
        if (!is_file && has_folder && fs::path(path).is_relative())
            return report(0, "'" + path + "' is a relative path that is not among " + files() + ": add it there");
        if (!find_program(path).empty())
            return;
        if (is_file || fs::exists(path))
            report(0, "'" + path + "' may not be executed: chmod +x, or put the program that runs it before it", true);
        else
            report(0, "no program '" + path + "'" + (has_folder ? "" : " in PATH") + ": install it, or write its absolute path",
                   true);
    }

    std::string files() const { return "'" + files_.option + "'"; }

    const Value& values_;
    std::map<OptionKind, Named> named_{
        {OptionKind::input_ports, {}}, {OptionKind::output_ports, {}}, {OptionKind::input_files, {}}};
    Named& inputs_ = named_.at(OptionKind::input_ports);
    Named& outputs_ = named_.at(OptionKind::output_ports);
    Named& files_ = named_.at(OptionKind::input_files);
    std::string option_;
    std::set<std::string> used_;
    std::vector<CommandLineProblem> problems_;
};

}  // namespace

std::vector<std::string> names_in(std::string_view word)
{
    std::vector<std::string> names;
    walk(
        word, [](std::string_view) {}, [&](std::string name) { names.push_back(std::move(name)); });
    return names;
}

std::string filled_in(std::string_view word, const std::map<std::string, std::string>& values)
{
    std::string result;
    walk(
        word, [&](std::string_view text) { result += text; },
        [&](const std::string& name)
        {
            const auto value = values.find(name);
            if (value == values.end())
                throw Error("'" + std::string(word) + "': unknown name {" + name + "}");
            result += value->second;
        });
    return result;
}

std::vector<CommandLineProblem>
check_command_line(const std::vector<OptionDeclaration>& options, const Value& values,
                   const std::function<fs::path(const std::string& option, std::size_t word)>& folder_of)
{
    Checker checker(options, values);
    for (const OptionDeclaration& option : options)
        if (option.kind == OptionKind::command_line)
            checker.check_words(option, folder_of);
    return checker.finish();
}
namespace
{

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
