#include "commands.h"

#include <fresco/error.h>
#include <fresco/host/machine.h>

#include <csignal>
#include <cstdio>
#include <exception>

namespace
{

constexpr int exit_failed = 1;
constexpr int exit_usage = 2;
constexpr int exit_missing_input = 3;
constexpr int exit_bug = 70;

int run_command_line(int argc, char** argv)
{
    CLI::App app("fresco paints scanned rooms: a pipeline of stages turns posed RGB-D frames, a mesh and a picture into a "
                 "painted, textured mesh.",
                 "fresco");
    app.require_subcommand(1);
    app.set_version_flag("--version", fresco::host::program_version());
    app.footer(
        "Exit codes: 0 done, 1 a stage failed, 2 pipeline or command line invalid, 3 an input is missing, 4 a plugin cannot be "
        "loaded, 70 a bug, 75 interrupted (run again).");
    int exit_code = 0;
    fresco::host::add_run_command(app, exit_code);
    fresco::host::add_plan_command(app, exit_code);
    fresco::host::add_inspect_commands(app, exit_code);
    fresco::host::add_store_command(app, exit_code);
    fresco::host::add_doctor_command(app, exit_code);
    fresco::host::add_internal_commands(app, exit_code);
    app.add_subcommand("version", "Print the version")->callback([] { std::puts(fresco::host::program_version().c_str()); });
    try
    {
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? 0 : exit_usage;
    }
    return exit_code;
}

}  // namespace

int main(int argc, char** argv)
{
    // A reader that goes away (`fresco stages | head`) is no reason to leave a run in disorder.
    std::signal(SIGPIPE, SIG_IGN);
    try
    {
        return run_command_line(argc, argv);
    }
    catch (const fresco::MissingInput& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return exit_missing_input;
    }
    catch (const fresco::Error& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return exit_failed;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr,
                     "error: unexpected: %s\nThis is a bug in fresco; please report it with the command and the pipeline file.\n",
                     error.what());
    }
    catch (...)
    {
        std::fprintf(stderr, "error: something that is no exception was thrown\nThis is a bug in fresco; please report it.\n");
    }
    return exit_bug;
}
