// Decimation, atlases, uv maps and mixtures: time, memory and quality of every implementation on the same meshes.
#include "command_line.h"
#include "report.h"
#include "tables.h"

#include <fresco/error.h>

#include <algorithm>
#include <cstdio>
#include <thread>

namespace
{

constexpr int views = 4;

struct Options
{
    std::vector<std::string> meshes;
    std::vector<std::string> scans;
    std::string json;
    double edge_m = 0.03;
    bool room = true;
    std::vector<std::string> only{"decimation", "atlas", "uv-maps", "packed-uv-maps", "mix"};
    bench::GeometrySettings settings;
};

std::optional<int> read_options(int argc, char** argv, Options& options)
{
    CLI::App app{"Times decimation, atlases, uv maps and mixtures on a generated room and measures their quality"};
    auto& settings = options.settings;
    settings.threads = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
    app.add_option("--mesh", options.meshes, "PLY or OBJ meshes to run over in addition to the room")->check(CLI::ExistingFile);
    app.add_option("--scan", options.scans, "Recordings in the layout of 7-Scenes, whose meshes and poses to run over as well")
        ->check(CLI::ExistingDirectory);
    app.add_option("--json", options.json, "File for the same figures as JSON");
    app.add_option("--edge-m", options.edge_m, "Edges of the generated room's mesh, meters")
        ->check(CLI::Range(0.01, 0.2))
        ->capture_default_str();
    app.add_option("--keep", settings.keep, "Share of the faces that decimation leaves")
        ->check(CLI::Range(0.001, 1.0))
        ->capture_default_str();
    app.add_option("--faces", settings.faces, "Numbers of faces that decimation leaves, in place of --keep")->delimiter(',');
    app.add_option("--repeats", settings.repeats, "Times that each decimation runs; the fastest counts")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    app.add_option("--only", options.only, "Tables to print")
        ->check(CLI::IsMember({"decimation", "atlas", "uv-maps", "packed-uv-maps", "mix"}))
        ->delimiter(',');
    app.add_flag("!--no-room", options.room, "Leave the generated room out");
    app.add_option("--size-px", settings.size_px, "Texture that atlases are made for")
        ->check(CLI::Range(64, 32768))
        ->capture_default_str();
    app.add_option("--samples", settings.samples, "Points per surface for distances")
        ->check(CLI::Range(100, 10'000'000))
        ->capture_default_str();
    app.add_option("--heights", settings.heights_px, "Heights of the uv maps")
        ->check(CLI::Range(16, 4096))
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--threads", settings.threads, "Threads")->check(CLI::Range(1, 1024))->capture_default_str();
    return bench::parse(app, argc, argv);
}

void run(const Options& options)
{
    const auto& settings = options.settings;
    bench::Report report("geometry", fresco::Value::Map{{"threads", settings.threads},
                                                        {"edge_m", options.edge_m},
                                                        {"keep", settings.keep},
                                                        {"size_px", settings.size_px},
                                                        {"samples", settings.samples}});
    std::vector<bench::GeometryInput> inputs;
    bench::Threads progress(settings.threads);
    if (options.room)
        inputs.push_back(bench::synthetic_room(options.edge_m, views, progress));
    for (const auto& file : options.meshes)
        inputs.push_back(bench::mesh_file(file, views));
    for (const auto& folder : options.scans)
        inputs.push_back(bench::scan_folder(folder, views));
    const auto wanted = [&](const char* name)
    { return std::find(options.only.begin(), options.only.end(), name) != options.only.end(); };
    if (wanted("decimation"))
        report.add(bench::decimation_table(inputs, settings));
    if (wanted("atlas"))
        report.add(bench::atlas_table(inputs, settings));
    if (wanted("uv-maps"))
    {
        report.add(bench::uv_map_table(inputs, settings));
        report.add(bench::uv_map_agreement_table(inputs, settings));
        report.add(bench::uv_map_twin_table(inputs, settings));
    }
    if (wanted("packed-uv-maps"))
        report.add(bench::packed_uv_map_table(inputs, settings));
    if (wanted("mix"))
        report.add(bench::mix_table(inputs, settings));
    if (!options.json.empty())
        report.write(options.json);
}

}  // namespace

int main(int argc, char** argv)
{
    Options options;
    if (const auto code = read_options(argc, argv, options))
        return *code;
    try
    {
        run(options);
    }
    catch (const fresco::MissingInput& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 3;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 1;
    }
    return 0;
}
