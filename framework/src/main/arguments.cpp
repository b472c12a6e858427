#include "base/common.h"
#include "base/text.h"
#include "main/commands.h"
#include "pipeline/problems.h"
#include "pipeline/yaml_document.h"
#include "plugins/plugin_search.h"
#include <fresco/error.h>
#include <fresco/files_io.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fmt/format.h>
#include <unistd.h>

namespace fresco::host
{
namespace
{
std::string empty_path_problem(const std::string& text)
{
    return text.empty() ? "the path is empty" : "";
}

/// As far as a pipeline file may be long, and a byte more, for which it is refused.
std::optional<std::string> standard_input()
{
    std::string text(yaml_size_limit + 1, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), stdin));
    return text;
}

/// Results name each other by their paths, in JSON.
std::string name_problem(const std::string& option, const std::filesystem::path& folder)
{
    if (!first_bad_byte(folder.string()))
        return "";
    return option + ": the name of the folder " + folder.string() +
           " is not UTF-8 text without control characters: rename it, or choose another with " + option;
}

/// Problem of writing to a folder, or to the one that it would be made in.
std::string writing_problem(const std::string& option, const std::filesystem::path& folder)
{
    std::error_code error;
    fs::path there = folder;
    while (!fs::exists(fs::symlink_status(there, error)) && there.has_relative_path())
        there = there.parent_path();
    const std::string other = ": choose another with " + option;
    if (!fs::is_directory(there, error))
        return option + ": " + there.string() + " is not a folder" + other;
    if (access(there.c_str(), W_OK | X_OK) != 0)
        return option + ": " + there.string() + " cannot be written: " + std::strerror(errno) + other;
    return "";
}

}  // namespace

const CLI::App* command_named(const CLI::App& app, const std::string& name)
{
    const auto found = app.get_subcommands([&](const CLI::App* each) { return each->get_name() == name; });
    return found.empty() ? nullptr : found.front();
}

void PipelineArguments::add_to(CLI::App& command)
{
    command.add_option("pipeline", file, "Pipeline file (YAML); '-' reads standard input")
        ->required()
        ->each([this](const std::string& word) { given_text = word == "-" ? standard_input() : std::nullopt; });
    command.add_option("--text", text_file, "Read the pipeline from this copy of the file, which may have been edited since");
    command.add_option("--set", sets, "NAME=VALUE sets a var, STAGE.OPTION=VALUE an option; may be repeated")
        ->allow_extra_args(false)
        ->check(
            [](const std::string& text) {
                return text.find('=') == std::string::npos || text.front() == '=' ? "'" + text + "' is not NAME=VALUE"
                                                                                  : std::string();
            });
    command.add_option("--without", without, "Leave out this stage; no remaining stage may read it; may be repeated")
        ->allow_extra_args(false);
    command.add_flag("--preview", preview, "Apply the file's 'preview': fewer frames, faces and texels, in under a minute");
}

PipelineRequest PipelineArguments::request() const
{
    PipelineRequest request;
    request.file = file;
    request.working_directory = std::filesystem::current_path();
    request.until = until;
    request.preview = preview;
    request.without = without;
    if (!text_file.empty())
        request.texts.push_back({(request.working_directory / file).lexically_normal(), read_text_file(text_file)});
    if (given_text)
        request.texts.push_back({request.working_directory / file, *given_text});
    for (const auto& text : sets)
    {
        const auto equals = text.find('=');
        request.sets.emplace_back(text.substr(0, equals), text.substr(equals + 1));
    }
    return request;
}

void PlaceArguments::add_store_to(CLI::App& command)
{
    command.add_option("--store", store, "Folder for cached stage results")->capture_default_str()->check(empty_path_problem);
}

void PlaceArguments::add_out_to(CLI::App& command)
{
    command_ = &command;
    command.add_option("--out", out, "Folder for output files; of a preview, out/preview")
        ->default_str("out")
        ->check(empty_path_problem);
    command.add_flag("--replace", replace, "Overwrite files in --out that fresco did not write, or that changed since");
}

void PipelineArguments::add_until_to(CLI::App& command)
{
    command.add_option("--until", until, "Only this stage and those it needs");
}

std::string PlaceArguments::out_name() const
{
    // A preview overwrites nothing of the full run.
    return !out.empty() ? out : command_ != nullptr && command_->count("--preview") > 0 ? "out/preview" : "out";
}

std::filesystem::path PlaceArguments::out_folder() const
{
    return std::filesystem::absolute(out_name()).lexically_normal();
}

std::filesystem::path PlaceArguments::store_folder() const
{
    return std::filesystem::absolute(store).lexically_normal();
}

Store PlaceArguments::existing_store() const
{
    if (!Store::is_at(store_folder()))
        throw MissingInput(store_folder().string() + ": not a store; set its folder with --store");
    return Store(store_folder());
}

void PlaceArguments::check() const
{
    for (const auto& found : {name_problem("--store", store_folder()), name_problem("--out", out_folder()),
                              writing_problem("--store", store_folder()), writing_problem("--out", out_folder())})
        if (!found.empty())
            throw UsageError("error: " + found);
}

void print_value(const Value& value)
{
    fmt::print("{}\n", to_json(value, 2));
}

void warn_of_plugin_folders()
{
    for (const std::string& warning : plugin_folder_warnings())
        print_message("warning: " + warning);
}

std::unique_ptr<LoadedPipeline> load_and_report(const PipelineRequest& request)
{
    auto loaded = std::make_unique<LoadedPipeline>();
    loaded->catalog = load_catalog();
    warn_of_plugin_folders();
    loaded->result = load_pipeline(request, loaded->catalog);
    for (const auto* problems : {&loaded->result.problems, &loaded->result.left_out, &loaded->result.warnings})
        for (const std::string& line : told(*problems))
            print_message(line);
    return loaded;
}

}  // namespace fresco::host
