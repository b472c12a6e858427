#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace fresco::host
{

/// Words that can stand at `words[current]` of a command line (`words[0]` is the program), or, as the only one, ":files" or
/// ":folders" where those are asked for. Commands and options are the program's own; types of stages and components are the
/// registry's; `--set` offers the vars and the options of the stages of the pipeline file that is named before. Never throws:
/// what cannot be read offers nothing.
std::vector<std::string> completions(const CLI::App& app, const std::vector<std::string>& words, std::size_t current);

/// The script that makes the shell ask `fresco internal-complete`: for "bash" or "zsh".
const char* completion_script(const std::string& shell);

}  // namespace fresco::host
