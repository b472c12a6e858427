#include "parsers.h"

#include "framework/tests/hand_made_catalog.h"

#include "pipeline/pipeline.h"
#include "pipeline/pipeline_wiring.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/run_context.h>
#include <fresco/testing.h>

#include "plugins/texture/synthesize/checkpoint.h"

namespace fresco::fuzz
{
namespace
{

using namespace fresco::host;

Catalog catalog_with_command()
{
    Catalog catalog = host::testing::hand_made_catalog();
    catalog.add(host::testing::described("command", "stage", R"json({
        "options": [{"name": "run", "kind": "command_line", "required": true, "help": "Program"},
                    {"name": "files", "kind": "input_files", "default": [], "help": "Files"},
                    {"name": "inputs", "kind": "input_ports", "default": {}, "help": "Inputs"},
                    {"name": "outputs", "kind": "output_ports", "required": true, "help": "Outputs"}],
        "inputs": [], "outputs": []})json"));
    return catalog;
}

/// Reads command-line arguments from comments: "# --set NAME=VALUE" and "# --until STAGE".
void take_arguments(std::string_view text, PipelineRequest& request)
{
    while (!text.empty())
    {
        const std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(line.size() + 1, text.size()));
        if (line.starts_with("# --until "))
            request.until = line.substr(10);
        const auto equals = line.find('=');
        if (line.starts_with("# --set ") && equals != std::string_view::npos)
            request.sets.emplace_back(line.substr(8, equals - 8), line.substr(equals + 1));
    }
}

/// Text after a line "# base.yaml" is a file of this name beside the other. Throws the first problem; a pipeline with
/// problems is refused whole.
void read_pipeline(Bytes bytes)
{
    static const Catalog catalog = catalog_with_command();
    constexpr std::string_view border = "# base.yaml\n";
    const std::string_view text = text_of(bytes);
    const auto end = std::min(text.find(border), text.size());
    static const auto picture = file_with(std::as_bytes(std::span(host::testing::jpeg_text)), "pic.jpg");
    const auto file = file_with(bytes.first(end), "p.yaml");
    file_with(bytes.subspan(std::min(end + border.size(), text.size())), "base.yaml");
    PipelineRequest request{file.filename(), {}, file.parent_path()};
    take_arguments(text.substr(0, end), request);
    const PipelineResult result = load_pipeline(request, catalog);
    require((result.exit_code() == 0) == result.problems.empty(), "an exit code for each problem");
    if (!result.problems.empty())
        throw Error(to_string(result.problems.front()));
    for (const PipelineStage& stage : result.pipeline.stages)
    {
        require(stage.type != nullptr, "a type for each stage");
        require(result.pipeline.find(stage.name) == &stage, "a name for each stage");
        require(!program_name(stage).empty(), "a name for its program");
    }
}

/// Files that end with a checksum: the checkpoint of a painting, and notes of finished pieces.
void read_checked_files(Bytes bytes)
{
    static fresco::testing::TestRun run;
    static const KeptPieces pieces(run);
    run.messages.clear();
    const std::string sealed = std::string(text_of(bytes)) + content_hash(bytes);
    const auto file = file_with(std::as_bytes(std::span(sealed)), (run.checkpoint_folder() / "piece_0.json").string());
    require(read_checked_text(file) == text_of(bytes), "the bytes without their checksum");
    if (text_of(bytes).starts_with('{') ? !pieces.find(0) : !synthesize::read_checkpoint(file))
        throw Error("not a note");
}

const Registered registered{
    {"pipeline", "framework/src/pipeline/(yaml_.*|pipeline_.*|pipeline)\\.cpp", read_pipeline},
    {"checked", "sdk/src/run_context\\.cpp|plugins/texture/synthesize/checkpoint\\.cpp", read_checked_files}};

}  // namespace
}  // namespace fresco::fuzz
