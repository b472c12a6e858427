#include "download.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/weights/sha256.h>
#include <fresco/weights/vgg19.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <list>

/// \file The program fresco-weights, which `fresco weights` runs: inspects, converts and downloads weights of VGG-19.

using namespace fresco;

namespace
{

namespace fs = std::filesystem;

/// Replaces control characters (ASCII, and C2 80 to C2 9F in UTF-8), which files may give and which would move the cursor.
std::string without_controls(std::string text)
{
    for (std::size_t i = 0; i < text.size(); ++i)
        if (const auto c = static_cast<unsigned char>(text[i]); c < 0x20 || c == 0x7F)
            text[i] = '?';
        else if (c == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0)
            text.replace(i, 2, "?");
    return text;
}

/// torchvision names its files after the beginning of their SHA-256.
constexpr const char* published_url = "https://download.pytorch.org/models/vgg19-dcbb9e9d.pth";
constexpr const char* published_sha256 = "dcbb9e9dad569fff7a846263a77324fc34978fea2bfb039c012d710e1776ae44";
/// The published file has 574,673,361; other files of the whole VGG-19 differ by some kilobytes.
constexpr std::uint64_t most_bytes = 600'000'000;
constexpr const char* published_name = "vgg19-dcbb9e9d.pth";

struct WeightsArguments
{
    std::string file;
    std::string out;
    std::string until;
    std::string network;
    std::string url = published_url;
    std::string sha256 = published_sha256;
    std::string to;
};

int inspect(const WeightsArguments& arguments)
{
    const auto file = weights::read_weights(arguments.file);
    const auto vgg19 = weights::recognize_vgg19(file.contents, arguments.file);
    const auto line = [](const char* key, std::string_view text) { fmt::print("{:<11} {}\n", key, text); };
    line("form", fmt::format("{}, {} bytes", weights::name_of(file.contents.form), file.bytes.size()));
    line("sha256", weights::sha256(file.bytes));
    line("network", fmt::format("VGG-19, conv1_1 to conv{}, {} names", vgg19.layers.back().name,
                                vgg19.keys == weights::Vgg19Keys::caffe ? "Caffe's" : "torchvision's"));
    line("input", weights::input_text(vgg19.input));
    line("padding", weights::padding_text(vgg19.input.padding));
    line("scale", vgg19.raw ? "raw: what the weights of StyleMesh's losses are for" : "other: rescaled before use");
    for (const auto& layer : vgg19.layers)
        for (const auto* tensor : {&layer.weight, &layer.bias})
            fmt::print("  conv{}  {:<20}  {:<4}  {}\n", layer.name, without_controls(tensor->name),
                       weights::name_of(tensor->type), weights::shape_text(tensor->shape));
    for (const auto& name : vgg19.ignored)
        fmt::print("  not used: {}\n", without_controls(name));
    return 0;
}

/// Leaves out what comes after the layer "relu4_1".
void cut(weights::Vgg19Weights& vgg19, const std::string& until, const std::string& file)
{
    const auto last = std::find_if(vgg19.layers.begin(), vgg19.layers.end(),
                                   [&](const weights::Vgg19Layer& layer) { return "relu" + layer.name == until; });
    if (last == vgg19.layers.end())
        throw Error("--until " + until + ": " + file + " has relu1_1 to relu" + vgg19.layers.back().name);
    vgg19.layers.erase(last + 1, vgg19.layers.end());
}

int convert(const WeightsArguments& arguments)
{
    if (fs::exists(fs::symlink_status(arguments.out)))
        throw Error(arguments.out + ": already exists; choose another name, or remove it");
    const auto file = weights::read_weights(arguments.file);
    auto vgg19 = weights::recognize_vgg19(file.contents, arguments.file);
    if (!arguments.until.empty())
        cut(vgg19, arguments.until, arguments.file);
    std::list<std::vector<float>> values;
    std::vector<weights::TensorView> tensors;
    for (const auto& layer : vgg19.layers)
        for (const auto* tensor : {&layer.weight, &layer.bias})
        {
            values.push_back(weights::to_float32(*tensor, arguments.file));
            tensors.push_back(
                {tensor->name, weights::ElementType::float32, tensor->shape, std::as_bytes(std::span(values.back()))});
        }
    auto metadata = weights::vgg19_metadata(vgg19);
    metadata["source_sha256"] = weights::sha256(file.bytes);
    const auto bytes = weights::to_safetensors(tensors, metadata);
    write_durable_file(arguments.out, bytes);
    fmt::print("{}: VGG-19, conv1_1 to conv{}, {} bytes\n", arguments.out, vgg19.layers.back().name, bytes.size());
    return 0;
}

fs::path place(const WeightsArguments& arguments)
{
    if (!arguments.to.empty())
        return fs::is_directory(arguments.to) ? fs::path(arguments.to) / published_name : fs::path(arguments.to);
    // Beside fresco's own cache.
    for (const auto& [variable, below] : {std::pair{"XDG_CACHE_HOME", "fresco"}, std::pair{"HOME", ".cache/fresco"}})
        if (const char* folder = std::getenv(variable); folder != nullptr && *folder == '/')
            return fs::path(folder) / below / "weights" / published_name;
    throw Error("neither XDG_CACHE_HOME nor HOME is set; name a file with --to");
}

int get(const WeightsArguments& arguments)
{
    const fs::path to = place(arguments);
    const bool fetched = weights::download({arguments.url, arguments.sha256, to, most_bytes});
    std::fprintf(stderr, "%s\n", fetched ? "downloaded; SHA-256 verified" : "already there; SHA-256 verified");
    fmt::print("{}\n", to.string());
    return 0;
}

void add_commands(CLI::App& app, int& exit_code)
{
    app.require_subcommand(1);
    const auto arguments = std::make_shared<WeightsArguments>();
    const auto add = [&](const char* name, const char* help, int (*action)(const WeightsArguments&))
    {
        CLI::App* sub = app.add_subcommand(name, help);
        sub->callback([arguments, action, &exit_code] { exit_code = action(*arguments); });
        return sub;
    };
    const char* file_help = "Weights of VGG-19: safetensors, or a state dict as .pth";

    CLI::App* look = add("inspect", "Print format, layers, shapes, expected input and SHA-256", inspect);
    look->add_option("file", arguments->file, file_help)->required();

    CLI::App* change = add("convert", "Write the convolutions as safetensors, with metadata", convert);
    change->add_option("file", arguments->file, file_help)->required();
    change->add_option("out", arguments->out, "The safetensors file to write")->required();
    change->add_option("--until", arguments->until, "The last layer to write, such as relu4_1 (default: all)");

    CLI::App* fetch =
        add("get", "Download torchvision's file with curl, or the rest of it, verify its SHA-256 and print its path", get);
    fetch->add_option("network", arguments->network, "vgg19 (548 MB)")->required()->check(CLI::IsMember({"vgg19"}));
    fetch->add_option("--url", arguments->url, "URL to download from, at most 600 MB; https is not redirected to http")
        ->capture_default_str();
    fetch->add_option("--sha256", arguments->sha256, "The expected SHA-256, or its first 8 digits or more")
        ->capture_default_str();
    fetch->add_option("--to", arguments->to, "Destination file or folder (default: weights/ in the user's cache)");
}

/// The words that can stand at the last of `words`, for `fresco internal-complete`; ":files" where a file can.
void offer(const CLI::App& app, const std::vector<std::string>& words)
{
    std::vector<std::string> offered;
    const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
    const auto named = std::ranges::find_if(commands, [&](const CLI::App* each) { return each->get_name() == words.front(); });
    const CLI::App* command = words.size() > 1 && named != commands.end() ? *named : nullptr;
    if (words.size() < 2)
        for (const CLI::App* each : commands)
            offered.push_back(each->get_name());
    else if (command != nullptr && words.back().starts_with("-"))
        for (const CLI::Option* option : command->get_options())
            for (const std::string& name : option->get_lnames())
                offered.push_back("--" + name);
    else if (command != nullptr)
        offered.emplace_back(command->get_name() == "get" && words.size() == 2 ? "vgg19" : ":files");
    std::ranges::sort(offered);
    for (const std::string& word : offered)
        if (word == ":files" || words.empty() || word.starts_with(words.back()))
            fmt::print("{}\n", word);
}

int run(int argc, char** argv)
{
    CLI::App app("Inspect, convert or download VGG-19 weights", "fresco weights");
    int exit_code = 0;
    add_commands(app, exit_code);
    app.set_help_all_flag("--help-all", "Print the help of all commands");
    if (argc > 1 && std::string_view(argv[1]) == "internal-complete")
    {
        offer(app, {argv + 2, argv + argc});
        return 0;
    }
    try
    {
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        constexpr int exit_usage = 2;
        return app.exit(error) == 0 ? 0 : exit_usage;
    }
    return exit_code;
}

}  // namespace

int main(int argc, char** argv)
{
    // A reader that goes away must not end a download.
    std::signal(SIGPIPE, SIG_IGN);
    // Beyond `ulimit -f` writing fails with a reason, as on a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    constexpr int exit_missing_input = 3;
    try
    {
        const int exit_code = run(argc, argv);
        if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0)
            return exit_code;
        fmt::print(stderr, "error: standard output could not be written; is the disk full?\n");
    }
    catch (const MissingInput& error)
    {
        fmt::print(stderr, "error: {}\n", without_controls(error.what()));
        return exit_missing_input;
    }
    catch (const std::exception& error)
    {
        fmt::print(stderr, "error: {}\n", without_controls(error.what()));
    }
    return 1;
}
