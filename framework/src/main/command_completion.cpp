#include "main/commands.h"
#include "main/completion.h"

#include <cstdio>
#include <memory>

namespace fresco::host
{
namespace
{

struct CompletionArguments
{
    std::string shell;
    std::size_t current = 0;
    std::vector<std::string> words;
};

}  // namespace

void add_completion_commands(CLI::App& app)
{
    const auto arguments = std::make_shared<CompletionArguments>();
    CLI::App* script = app.add_subcommand("completion", "Print a completion script for the shell");
    script->add_option("shell", arguments->shell, "bash, fish or zsh")->required()->check(CLI::IsMember({"bash", "fish", "zsh"}));
    script->callback([arguments] { std::fputs(completion_script(arguments->shell), stdout); });

    CLI::App* ask = app.add_subcommand("internal-complete", "Offer words; the shell calls this")->group("");
    ask->add_option("current", arguments->current)->required();
    ask->add_option("words", arguments->words);
    ask->callback(
        [arguments, &app]
        {
            for (const auto& word : completions(app, arguments->words, arguments->current))
                std::puts(word.c_str());
        });
}

}  // namespace fresco::host
