#include "base/common.h"
#include "base/process.h"
#include "base/text.h"
#include "main/commands.h"
#include "pipeline/pipeline_document.h"

#include "plugins/plugin_search.h"
#include "plugins/templates.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace fresco::host
{
namespace
{

struct NewArguments
{
    std::string kind;
    std::string type;
    std::string in = ".";
    std::string folder;
};

/// Makes `folder`, or fills it where it is there and empty. After an error it is empty.
void write_folder(const fs::path& folder, const std::vector<TextFile>& files)
{
    if (fs::exists(fs::symlink_status(folder)) && !(fs::is_directory(folder) && fs::is_empty(folder)))
        throw UsageError("error: " + folder.string() + ": already exists; nothing was written: choose another name");
    try
    {
        for (const auto& file : files)
        {
            fs::create_directories((folder / file.path).parent_path());
            write_durable_file(folder / file.path, file.text);
        }
    }
    catch (...)
    {
        std::error_code ignored;
        for (const auto& file : files)
            for (fs::path each = file.path; !each.empty() && fs::remove(folder / each, ignored); each = each.parent_path())
                ;
        throw;
    }
}

/// Prefix of this program's installation, if it is installed.
fs::path own_prefix()
{
    const fs::path prefix = own_program().parent_path().parent_path();
    return fs::exists(prefix / "lib/cmake/fresco/frescoConfig.cmake") ? prefix : fs::path();
}

/// Adds the installed pictures that files of a template name, so that its pipeline runs as it is.
void add_pictures(std::vector<TextFile>& files)
{
    const fs::path folder = installed_pipelines() / "pictures";
    std::error_code missing;
    fs::directory_iterator pictures(folder, missing);
    if (missing)
        throw Error(folder.string() + " is missing: install fresco again");
    const std::vector<TextFile> own = files;
    for (const auto& picture : pictures)
        if (const std::string name = picture.path().filename().string();
            std::ranges::any_of(own, [&](const TextFile& file) { return file.text.find(name) != std::string::npos; }))
            files.push_back({name, read_text_file(picture.path())});
}

int begin_plugin(const NewArguments& arguments)
{
    auto files = new_plugin(arguments.kind, arguments.type);
    const Catalog catalog = load_catalog();
    if (const auto libraries = catalog.libraries_of(arguments.type); !libraries.empty())
        throw UsageError(fmt::format("error: '{}' already exists, in {}; two plugins of one name cannot be used together",
                                     arguments.type, libraries.front()));
    add_pictures(files);
    const fs::path folder = fs::path(arguments.in) / plugin_folder_name(arguments.type);
    write_folder(folder, files);
    for (const auto& file : files)
        print_line((folder / file.path).string());
    const fs::path prefix = own_prefix();
    const std::string place = shell_word(folder.lexically_normal().string());
    if (prefix.empty())
        fmt::print("\n{}\n", folded("It builds against an installed fresco: cmake --install BUILD --prefix PREFIX. Then",
                                    terminal_width(STDOUT_FILENO)));
    else
        fmt::print("\nNow\n");
    fmt::print("  cmake -S {0} -B {0}/build -DCMAKE_PREFIX_PATH={1}\n"
               "  cmake --build {0}/build && ctest --test-dir {0}/build\n"
               "  FRESCO_PLUGIN_PATH={0}/build fresco run {0}/pipeline.yaml\n",
               place, prefix.empty() ? "PREFIX" : shell_word(prefix.string()));
    return 0;
}

int begin_project(const NewArguments& arguments)
{
    auto files = template_files("project");
    for (auto& file : files)
        if (file.path == "gitignore")
            file.path = ".gitignore";
        else if (const fs::path schema = installed_schema(); fs::exists(schema))
            file.text = "# yaml-language-server: $schema=" + schema.string() + "\n" + file.text;
    add_pictures(files);
    const fs::path folder = arguments.folder;
    write_folder(folder, files);
    for (const auto& file : files)
        print_line((folder / file.path).string());
    fmt::print(
        "\nNow\n  cd {} && fresco run pipeline.yaml\n{}\n", shell_word(folder.string()),
        folded("It paints a generated room; the file says how to use your own scan and picture.", terminal_width(STDOUT_FILENO)));
    return 0;
}

}  // namespace

void add_new_commands(CLI::App& app, int& exit_code)
{
    const auto arguments = std::make_shared<NewArguments>();
    CLI::App* init = app.add_subcommand("init", "Create a project: a folder with a commented pipeline that needs no data");
    init->add_option("folder", arguments->folder, "Folder to create")->required();
    init->callback([arguments, &exit_code] { exit_code = begin_project(*arguments); });

    CLI::App* plugin = app.add_subcommand("new", "Create a plugin: a folder that builds, tests and installs by itself");
    plugin->add_option("kind", arguments->kind, join(plugin_kinds(), " or "))->required()->check(CLI::IsMember(plugin_kinds()));
    plugin->add_option("type", arguments->type, "Type name in pipelines, such as my.dots; the folder is then my_dots")
        ->required();
    plugin->add_option("--in", arguments->in, "Parent of the new folder")->capture_default_str();
    plugin->callback([arguments, &exit_code] { exit_code = begin_plugin(*arguments); });
}

}  // namespace fresco::host
