#include "base/common.h"
#include "base/text.h"
#include "main/commands.h"
#include "pipeline/pipeline_document.h"
#include "pipeline/pipeline_types.h"
#include "plugins/catalog.h"
#include "plugins/plugin_search.h"
#include "plugins/templates.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

namespace fresco::host
{

namespace
{

using Words = std::vector<std::string>;

const Words any_file{":files"};
const Words any_folder{":folders"};

/// The command that the words before the last have come to, and how many words of its own it has got.
struct Place
{
    const CLI::App* command = nullptr;
    const CLI::Option* waiting = nullptr;  ///< An option that still wants its value.
    Words given;                           ///< Positional words.
};

/// bash cuts `--set a.b=4` and `--out=a` at the sign of equality.
Words whole_words(const Words& words)
{
    Words whole{words.front()};
    for (std::size_t i = 1; i < words.size(); ++i)
        if (i > 1 && (words[i] == "=" || words[i - 1] == "="))
            whole.back() += words[i];
        else
            whole.push_back(words[i]);
    return whole;
}

/// The last word is the one that is completed.
Place place_of(const CLI::App& app, const Words& words)
{
    Place place{&app, nullptr, {}};
    for (std::size_t i = 1; i + 1 < words.size(); ++i)
        if (place.waiting != nullptr)
            place.waiting = nullptr;
        else if (words[i].starts_with("-"))
        {
            const CLI::Option* option = place.command->get_option_no_throw(words[i]);
            place.waiting = option != nullptr && option->get_items_expected_max() > 0 ? option : nullptr;
        }
        else if (const CLI::App* below = place.given.empty() ? command_named(*place.command, words[i]) : nullptr)
            place.command = below;
        else
            place.given.push_back(words[i]);
    return place;
}

/// The names that `--set` takes: vars, the pipeline's components, and every option of every stage. The shell inserts words as
/// they are: a name that it would take for a command is not offered.
Words settings(const std::string& file, bool stages_alone)
{
    ProblemList problems;
    const auto document = read_pipeline_document(fs::absolute(file), file, {}, problems);
    Words result = stages_alone ? document.stages.keys() : Words{};
    const Catalog catalog = stages_alone ? Catalog() : load_catalog();
    TypeTable types(catalog);
    const auto add = [&](const std::string& name) { result.push_back(name + "="); };
    if (!stages_alone)
        std::ranges::for_each(document.vars.keys(), add);
    for (const auto& [kind, default_value] : types.pipeline_components())
        if (!document.stages.entries.empty())
            add(std::string(pipeline_components) + "." + kind);
    for (const auto& entry : document.stages.entries)
        if (const auto* type = entry.value.find("type"))
            if (const KnownType known = types.find(type->value.text, "stage"))
                for (const auto& option : known.declaration->option_names())
                    add(entry.key + "." + option);
    std::erase_if(result, [](const std::string& word) { return shell_word(word) != word; });
    return result;
}

Words values_of(const CLI::Option& option, const Place& place)
{
    const std::string& name = option.get_single_name();
    if (name == "set" || name == "until" || name == "without" || name == "thumbnails")
        return place.given.empty() ? Words{} : settings(place.given.front(), name != "set");
    if (name == "store" || name == "out" || name == "in")
        return any_folder;
    return name == "to" ? any_file : Words{};
}

/// Candidates for the command's next word without a dash.
Words positional(const Place& place)
{
    std::size_t number = 0;
    for (const CLI::Option* option : place.command->get_options())
    {
        if (!option->get_positional() || number++ != place.given.size())
            continue;
        const std::string name = option->get_single_name();
        if (name == "pipeline" || name == "file" || name == "out")
            return any_file;
        if (name == "folder")
            return any_folder;
        if (name == "stage")
            return settings(place.given.front(), true);
        if (name == "kind")
            return plugin_kinds();
        if (name == "shell")
            return {"bash", "fish", "zsh"};
        if (name == "type" && place.command->get_name() == "describe")
            return each(load_catalog().types(), &TypeDescription::type);
    }
    return {};
}

Words offered(const CLI::App& app, Words asked, std::size_t current)
{
    asked.resize(current + 1);
    if (current > 1 && !asked[1].starts_with("-") && command_named(app, asked[1]) == nullptr)
        return program_completions({asked.begin() + 1, asked.end()});
    const Words words = whole_words(asked);
    const Place place = place_of(app, words);
    // `--out=a` and `--set a=b` are completed after the sign.
    std::string word = words.back();
    const std::size_t sign = word.find('=');
    const bool with_option = place.waiting == nullptr && word.starts_with("--") && sign != std::string::npos;
    const bool of_setting = place.waiting != nullptr && place.waiting->check_lname("set") && sign != std::string::npos;
    const CLI::Option* option = with_option ? place.command->get_option_no_throw(word.substr(0, sign)) : place.waiting;
    if (with_option || of_setting)
        word = word.substr(sign + 1);
    Words result;
    if (of_setting)
        result = any_file;
    else if (option != nullptr)
        result = values_of(*option, place);
    else if (word.starts_with("-"))
    {
        for (const CLI::Option* each : place.command->get_options())
            for (const auto& name : each->get_lnames())
                result.push_back("--" + name);
    }
    else if (!with_option)
    {
        for (const CLI::App* command :
             place.command->get_subcommands([](const CLI::App* each) { return !each->get_group().empty(); }))
            if (!command->get_name().empty())
                result.push_back(command->get_name());
        if (place.command == &app)
            std::ranges::copy(program_commands(), std::back_inserter(result));
        if (result.empty())
            result = positional(place);
    }
    if (result != any_file && result != any_folder)
        std::erase_if(result, [&](const std::string& each) { return !each.starts_with(word); });
    return result;
}

}  // namespace

/// Words that can stand at `words[current]` of a command line (`words[0]` is the program), or, as the only one, ":files" or
/// ":folders" where those are asked for. Commands and options are the program's own; types of stages and components are the
/// registry's; `--set` offers the vars and the options of the stages of the pipeline file that is named before. Never throws:
/// what cannot be read offers nothing.
std::vector<std::string> completions(const CLI::App& app, const std::vector<std::string>& words, std::size_t current)
{
    try
    {
        Words result = offered(app, words, current);
        std::ranges::sort(result);
        return result;
    }
    catch (const std::exception&)
    {
        return {};
    }
}

void add_completion_commands(CLI::App& app)
{
    const auto shell = std::make_shared<std::string>();
    CLI::App* script = app.add_subcommand("completion", "Print a completion script for the shell");
    script->add_option("shell", *shell, "bash, fish or zsh")->required()->check(CLI::IsMember({"bash", "fish", "zsh"}));
    script->callback(
        [shell]
        {
            for (const TextFile& file : template_files("completion"))
                if (file.path == *shell)
                    std::fputs(file.text.c_str(), stdout);
        });

    CLI::App* ask = app.add_subcommand("internal-complete", "Offer words; the shell calls this")->group("");
    const auto current = std::make_shared<std::size_t>();
    const auto words = std::make_shared<Words>();
    ask->add_option("current", *current)->required();
    ask->add_option("words", *words);
    ask->callback(
        [current, words, &app]
        {
            for (const auto& word : completions(app, *words, *current))
                std::puts(word.c_str());
        });
}

}  // namespace fresco::host
