#pragma once

#include <fresco/option_declaration.h>

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

/// \file The words of a CommandLine option.

namespace fresco
{

/// The names in braces of a word: "--out={result}" has "result". "{{" and "}}" stand for braces. Throws Error for a brace without
/// its other.
std::vector<std::string> names_in(std::string_view word);

/// The word with each {name} replaced. Throws as names_in, and for a name that is not among `values`.
std::string filled_in(std::string_view word, const std::map<std::string, std::string>& values);

/// One thing that keeps a program from being run as it is declared.
struct CommandLineProblem
{
    std::string option;  ///< Where it is,
    int word = -1;       ///< and at which word of it; -1: the option as a whole.
    std::string text;
    bool is_missing = false;  ///< A program that is not there; otherwise the pipeline is wrong.
};

/// Checks the command lines of a stage against its files and ports: unknown {names}, outputs that no word passes to the program,
/// files that are used but not declared, programs that there are not. `values` are the checked values of `options`; `folder_of`
/// gives the folder that a relative path in an option's word starts from.
std::vector<CommandLineProblem>
check_command_line(const std::vector<OptionDeclaration>& options, const Value& values,
                   const std::function<std::filesystem::path(const std::string& option, std::size_t word)>& folder_of);

}  // namespace fresco
