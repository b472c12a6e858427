#pragma once

#include <fresco/artifact.h>
#include <fresco/image_io.h>
#include <fresco/run_context.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace fresco::host
{

/// How an artifact is handed to a program and taken back from it (sdk/docs/commands.md).
struct ExchangeForm
{
    std::string_view artifact;
    int version = 1;
    std::vector<std::string_view> as;  ///< What `as` may say, the default first; empty where there is one form alone.
};

/// Of every artifact that a program can make.
const std::vector<ExchangeForm>& exchange_forms();
/// nullptr where a program cannot make the artifact.
const ExchangeForm* exchange_form(std::string_view artifact);

/// A port as a pipeline declares it.
struct CommandPort
{
    std::string artifact;
    std::string as;
};

/// Where the stored or read input of one port is put down for the program; the path that it gets. `value` is null for one from
/// the store, whose folder `stored` is then. What is small is written into `folder`, which is empty; uv maps, files and artifacts
/// of other plugins are used where they lie.
std::filesystem::path hand_over(const CommandPort& port, const ArtifactFolder& stored, const Artifact* value,
                                const std::filesystem::path& folder, const ImageIo* images);

/// The path that a program gets for what it shall make: in `scratch`, or in `published`, the output's own folder, where the
/// artifact has files that stay where the program wrote them.
std::filesystem::path place_for(const CommandPort& port, const std::filesystem::path& scratch,
                                const std::filesystem::path& published);

/// Reads what the program wrote to place_for's path, with all checks, and writes it to its final form in `published`. Throws
/// Error naming what is missing or wrong.
void take_back(const CommandPort& port, const std::filesystem::path& path, const ArtifactFolder& published, const ImageIo* images,
               RunContext& run);

}  // namespace fresco::host
