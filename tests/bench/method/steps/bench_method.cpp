// One step of the optimization: optimizer, texture lookups, losses and features, each against the obvious way.
#include "command_line.h"
#include "components.h"
#include "method_tables.h"
#include "report.h"

#include <fresco/error.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <unistd.h>

namespace
{

struct Options
{
    std::string json;
    std::vector<std::string> only;
    bench::MethodSettings settings;
};

std::optional<int> read_options(int argc, char** argv, Options& options)
{
    CLI::App app{"Times the parts of an optimization step on generated views"};
    auto& settings = options.settings;
    settings.threads = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
    app.add_option("--json", options.json, "File for the same figures as JSON");
    app.add_option("--only", options.only, "Some of the tables: steps, runs, adam, lookup, losses, features")
        ->check(CLI::IsMember({"steps", "runs", "adam", "lookup", "losses", "features"}))
        ->delimiter(',');
    app.add_option("--sizes", settings.sizes_px, "Texture sizes, multiples of 8")
        ->check(CLI::Range(64, 16384) &
                CLI::Validator([](std::string& text) { return std::stoi(text) % 8 == 0 ? "" : "no multiple of 8: " + text; }, ""))
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--heights", settings.heights_px, "Heights of the views for lookups")
        ->check(CLI::Range(16, 4096))
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--loss-height", settings.loss_height_px, "Height of the picture that losses see")
        ->check(CLI::Range(64, 2048))
        ->capture_default_str();
    app.add_option("--step-size", settings.step_size_px, "Texture size of whole steps, a multiple of 8")
        ->check(CLI::Range(64, 16384))
        ->capture_default_str();
    app.add_option("--threads", settings.threads, "Threads")->check(CLI::Range(1, 1024))->capture_default_str();
    return bench::parse(app, argc, argv);
}

void run(const Options& options)
{
    bench::Report report(
        "method", fresco::Value::Map{{"threads", options.settings.threads}, {"loss_height_px", options.settings.loss_height_px}});
    const fresco::testing::TemporaryFolder folder;
    const auto vgg19 = folder.path() / "random_vgg19.safetensors";
    bench::write_random_vgg19(vgg19);
    const auto wanted = [&](const char* name)
    { return options.only.empty() || std::find(options.only.begin(), options.only.end(), name) != options.only.end(); };
    if (wanted("steps"))
        report.add(bench::step_table(options.settings, folder.path()));
    if (wanted("runs"))
        report.add(bench::run_table(options.settings, folder.path(), vgg19));
    if (wanted("adam"))
        report.add(bench::adam_table(options.settings));
    if (wanted("lookup"))
        report.add(bench::lookup_table(options.settings));
    if (wanted("losses"))
        report.add(bench::loss_table(options.settings, vgg19));
    if (wanted("features"))
        report.add(bench::features_table(options.settings, vgg19));
    if (!options.json.empty())
        report.write(options.json);
}

/// libgomp reads its settings when it is loaded. Left alone its threads spin while they wait, which would count as work: a third
/// of a step's processor time, the reference's too.
void begin_again_without_spinning(char** argv)
{
    if (std::getenv("GOMP_SPINCOUNT") != nullptr)
        return;
    ::setenv("GOMP_SPINCOUNT", "1000", 1);  // As the host has it for its stages.
    ::execv("/proc/self/exe", argv);
}

}  // namespace

int main(int argc, char** argv)
{
    begin_again_without_spinning(argv);
    Options options;
    if (const auto code = read_options(argc, argv, options))
        return *code;
    try
    {
        run(options);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 1;
    }
    return 0;
}
