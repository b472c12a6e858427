#include "base/common.h"
#include "base/process.h"
#include "base/text.h"
#include "main/commands.h"

#include <fresco/error.h>
#include <fresco/process.h>
#include <fresco/wording.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <set>
#include <unistd.h>

/// \file Commands that are programs of their own, as git and cargo have them: `fresco NAME` runs fresco-NAME, which lies beside
/// fresco or in a folder of PATH. So a plugin brings a command along, and anybody can add one.

namespace fresco::host
{
namespace
{
constexpr std::string_view prefix = "fresco-";

/// In the order in which they are searched.
std::vector<fs::path> searched_folders()
{
    std::vector<fs::path> all{own_program().parent_path()};
    const char* path = std::getenv("PATH");
    for (const std::string& folder : split(path != nullptr ? path : "", ':'))
        if (folder.starts_with('/'))
            all.emplace_back(folder);
    return all;
}

fs::path program_of(const std::string& command)
{
    if (is_name(command) && !command.starts_with("internal-"))
        for (const fs::path& folder : searched_folders())
            if (const std::string file = find_program(folder / (std::string(prefix) + command)); !file.empty())
                return file;
    return {};
}

std::set<std::string> commands_in(const fs::path& folder)
{
    std::set<std::string> names;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error); !error && entry != fs::directory_iterator(); entry.increment(error))
        if (const std::string name = entry->path().filename(); name.starts_with(prefix) && !find_program(entry->path()).empty())
            if (std::string command = name.substr(prefix.size()); is_name(command))
                names.insert(std::move(command));
    return names;
}

/// Output of a program beside fresco; one from elsewhere may not know the question.
std::vector<std::string> answer_of(const std::string& command, const std::vector<std::string>& words)
{
    const fs::path file = own_program().parent_path() / (std::string(prefix) + command);
    std::vector<std::string> lines;
    if (find_program(file).empty())
        return lines;
    ProcessStart start{.file = file, .arguments = {file.filename()}, .own_session = true};
    start.arguments.insert(start.arguments.end(), words.begin(), words.end());
    Process process = start_process(start);
    const HeardEnd end = hear_out(
        {process.pid, {}, std::move(process.output)}, std::chrono::seconds(5), [](const auto&) {},
        [&](const std::string& line) { lines.push_back(line); });
    return end.exit_code == 0 ? lines : std::vector<std::string>{};
}
}  // namespace

std::vector<std::string> program_commands()
{
    std::set<std::string> names;
    for (const fs::path& folder : searched_folders())
        names.merge(commands_in(folder));
    return {names.begin(), names.end()};
}

void run_program_command(char** words)
{
    const fs::path file = program_of(words[1]);
    if (file.empty())
        return;
    // Other programs expect the signals that this one ignores.
    std::signal(SIGPIPE, SIG_DFL);
    std::signal(SIGXFSZ, SIG_DFL);
    const std::string name = file.filename();
    std::vector<char*> arguments{const_cast<char*>(name.c_str())};
    for (char** word = words + 2; *word != nullptr; ++word)
        arguments.push_back(*word);
    arguments.push_back(nullptr);
    execv(file.c_str(), arguments.data());
    throw Error(file.string() + ": cannot be run: " + std::strerror(errno));
}

std::vector<std::string> program_completions(const std::vector<std::string>& words)
{
    std::vector<std::string> asked{"internal-complete"};
    asked.insert(asked.end(), words.begin() + 1, words.end());
    return answer_of(words.front(), asked);
}

std::vector<std::pair<std::string, std::vector<std::string>>> program_helps()
{
    std::vector<std::pair<std::string, std::vector<std::string>>> helps;
    for (const std::string& name : commands_in(own_program().parent_path()))
        helps.emplace_back(name, answer_of(name, {"--help-all"}));
    return helps;
}

}  // namespace fresco::host
