#pragma once

#include "room_file.h"

#include <fresco/error.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <functional>
#include <string>

/// \file The frame of a program that is a command of fresco's: completion, help, errors and exit codes.

namespace fresco::paint
{

/// Reads the words into the app's options and runs `act`; the program's exit code. Without words a program that requires some
/// prints its help.
inline int run_command(CLI::App& app, int argc, char** argv, const std::function<int()>& act)
{
    constexpr int exit_usage = 2;
    constexpr int exit_missing_input = 3;
    std::signal(SIGPIPE, SIG_IGN);
    const auto options = app.get_options();
    const bool lacks_words =
        argc == 1 && std::ranges::any_of(options, [](const CLI::Option* option) { return option->get_required(); });
    const std::string first = argc > 1 ? argv[1] : "";
    const std::string last = argv[argc - 1];
    if (first == "internal-complete")
    {
        for (const CLI::Option* option : options)
            for (const std::string& name : option->get_lnames())
                if (last.starts_with("-") && ("--" + name).starts_with(last))
                    fmt::print("--{}\n", name);
        if (!last.starts_with("-"))
            fmt::print(":files\n");
        return 0;
    }
    if (lacks_words || first == "--help-all")
    {
        fmt::print("{}", app.help());
        return lacks_words ? exit_usage : 0;
    }
    try
    {
        app.parse(argc, argv);
        return act();
    }
    catch (const CLI::CallForHelp& asked)
    {
        return app.exit(asked);
    }
    catch (const CLI::ParseError& error)
    {
        fmt::print(stderr, "error: {}; {} --help lists what it accepts\n", error.what(), app.get_name());
        return exit_usage;
    }
    catch (const std::exception& error)
    {
        fmt::print(stderr, "error: {}\n", error.what());
        return dynamic_cast<const UsageError*>(&error) != nullptr     ? exit_usage
               : dynamic_cast<const MissingInput*>(&error) != nullptr ? exit_missing_input
                                                                      : 1;
    }
}

}  // namespace fresco::paint
