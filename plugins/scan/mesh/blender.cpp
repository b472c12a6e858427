#include "blender.h"

#include "import_model.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/programs/run_program.h>
#include <fresco/recordings/layout.h>
#include <fresco/wording.h>

#include <deque>
#include <fmt/format.h>
#include <set>
#include <string>

namespace scan_mesh
{

namespace fs = std::filesystem;

namespace
{

constexpr double most_seconds = 1800;
constexpr double most_memory_mb = 32 * 1024;
constexpr std::size_t kept_lines = 6;

/// Reads what the script says, and keeps the last that Blender prints.
struct Printed
{
    std::string version;
    std::set<fs::path> files;
    bool has_importer = true;
    std::deque<std::string> tail;

    void take(const std::string& line)
    {
        const auto said = [&](const std::string& key)
        { return line.starts_with(key) ? std::optional(line.substr(key.size())) : std::nullopt; };
        if (const auto number = said("fresco: version "))
            version = *number;
        else if (const auto file = said("fresco: file "))
            files.insert(*file);
        else if (said("fresco: no importer"))
            has_importer = false;
        else if (line.find_first_not_of(" \r") != std::string::npos)
            tail.push_back(line);
        if (tail.size() > kept_lines)
            tail.pop_front();
    }
};

}  // namespace

fresco::FileFormat blender_format()
{
    return {.name = "a model that Blender reads",
            .extensions = {".3ds", ".abc", ".blend", ".dae", ".fbx", ".stl", ".usd", ".usda", ".usdc", ".usdz", ".wrl", ".x3d"}};
}

fs::path glb_by_blender(const fs::path& model, fresco::RunContext& run)
{
    const std::string program = fresco::find_program("blender");
    const std::string kind = fresco::lower_extension(model);
    const std::string way_out = ", or save the model as .glb in another program";
    if (program.empty())
        throw fresco::MissingInput(
            fmt::format("{}: {} files are read by Blender, and no program \"blender\" is in PATH; install it{}", model.string(),
                        kind, way_out));
    run.reads_file(program);
    const fs::path folder = run.scratch_folder();
    const fs::path script = folder / "import_model.py";
    const fs::path glb = folder / "model.glb";
    fresco::write_file(script, std::string_view(import_model_py));
    Printed printed;
    // Neither the user's settings nor scripts in the model count.
    const auto end = fresco::programs::run_program(
        {.file = program,
         .arguments = {program, "--background", "--factory-startup", "--disable-autoexec", "-noaudio", "--threads",
                       std::to_string(run.threads()), "--python-exit-code", "1", "--python", script.string(), "--",
                       fs::absolute(model).string(), glb.string()},
         .environment = {{"HOME", folder.string()},
                         {"XDG_CONFIG_HOME", folder.string()},
                         {"TMPDIR", folder.string()},
                         {"PYTHONNOUSERSITE", "1"},
                         {"PYTHONDONTWRITEBYTECODE", "1"}},
         .folder = folder.string(),
         .data_limit_mb = most_memory_mb},
        run, [&](const std::string& line) { printed.take(line); }, most_seconds);
    const std::string blender = "Blender " + printed.version;
    if (!printed.has_importer)
        throw fresco::MissingInput(
            fmt::format("{}: {} ({}) has no importer for {} files; install one that has, from blender.org{}", model.string(),
                        blender, program, kind, way_out));
    if (end.exit_code != 0 || !fs::exists(glb))
        throw fresco::Error(fmt::format("{}: {} cannot read it: {}{}; the last it printed:\n    | {}", model.string(), blender,
                                        end.signal != 0 ? fresco::signal_text(end.signal)
                                                        : fmt::format("it ended with exit code {}", end.exit_code),
                                        way_out, fmt::join(printed.tail, "\n    | ")));
    for (const fs::path& file : printed.files)
    {
        fresco::recordings::looks_for(file, run);
        if (fs::is_regular_file(file))
            run.reads_file(file);
        else
            run.warning(fmt::format("{}: it names {}, which is not there", model.filename().string(), file.string()));
    }
    run.message(fmt::format("{}: read by {}, {}", model.filename().string(), blender, program));
    run.report("blender", printed.version);
    return glb;
}

}  // namespace scan_mesh
