#include <fresco/command.h>
#include <fresco/error.h>
#include <fresco/process.h>
#include <fresco/wording.h>

#include <regex>
#include <set>
#include <type_traits>

namespace fresco
{
namespace fs = std::filesystem;
namespace
{

// A name has fewer than 100 characters: std::regex takes stack for each.
const std::regex braces(R"(\{\{|\}\}|\{([^{}]{0,99})\}|[{}])");

/// The word with the value of each {name} in its place.
template <class ValueOf>
std::string with_values(std::string_view word, const ValueOf& value_of)
{
    std::string result;
    const char* text = word.data();
    const char* const end = text + word.size();
    for (std::cregex_iterator found(text, end, braces), none; found != none; ++found)
    {
        const std::string brace(1, *(*found)[0].first);
        result.append(text, (*found)[0].first);
        text = (*found)[0].second;
        if (found->length() == 1)
            throw Error("'" + std::string(word) + "' has a '" + brace +
                        "' without its other: a {name} stands for a port's path, " + brace + brace + " for a brace");
        result += (*found)[1].matched ? value_of(found->str(1)) : brace;
    }
    return result.append(text, end);
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
    with_values(word, [&](const std::string& name) { return names.emplace_back(name); });
    return names;
}

std::string filled_in(std::string_view word, const std::map<std::string, std::string>& values)
{
    const auto value_of = [&](const std::string& name)
    {
        const auto value = values.find(name);
        if (value == values.end())
            throw Error("'" + std::string(word) + "': unknown name {" + name + "}");
        return value->second;
    };
    return with_values(word, value_of);
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
