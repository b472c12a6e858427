#pragma once

#include <CLI/CLI.hpp>

#include <optional>

namespace bench
{

/// Reads the command line into the options of `app`. The exit code to end with (0 after --help, 2 with a message for wrong
/// options), or nothing to go on.
inline std::optional<int> parse(CLI::App& app, int argc, char** argv)
{
    try
    {
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? 0 : 2;
    }
    return std::nullopt;
}

}  // namespace bench
