#include "parsers.h"

#include "framework/tests/hand_made_catalog.h"

#include "base/chunk_hash.h"
#include "base/durable_file.h"
#include "base/file_stamp.h"
#include "pipeline/pipeline.h"
#include "pipeline/pipeline_ports.h"
#include "store/stage_record.h"
#include "store/statistics.h"
#include "store/store.h"

#include <fresco/checked_file.h>
#include <fresco/error.h>
#include <fresco/hash.h>
#include <fresco/kept_pieces.h>
#include <fresco/testing.h>

#include "plugins/texture_synthesize/checkpoint.h"

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

/// What a command line adds, in comments: "# --set NAME=VALUE" and "# --until STAGE".
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

/// What lies behind a line "# base.yaml" is a file of this name beside the other. Throws the first problem; a pipeline with
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
        require(!cost_name(stage).empty(), "a name for its cost");
    }
}

/// With the checksum that a record ends with: else nothing behind it would be reached.
void write_sealed(const std::filesystem::path& file, std::string_view text)
{
    const std::string map(text.substr(0, text.rfind('}')));
    const std::string sealed = map + ",\"checksum\":\"" + content_hash(map) + "\"}\n";
    file_with(std::as_bytes(std::span(sealed)), file.string());
}

/// A record of the store, as that of a key, of a result, of a stage and of a stage's cost.
void read_stored(Bytes bytes)
{
    static const Store store(file_with({}, "format").parent_path() / "store");
    static const std::string key = "k";
    static const std::string object = object_id(key, {});
    static const std::filesystem::path pipeline = "/p.yaml";
    static const std::filesystem::path index = store.root() / "index.json";
    static const std::filesystem::path costs = store.root() / "stats.jsonl";
    static const bool made = []
    {
        make_folder(store.object(object) / "out");
        file_with(std::as_bytes(std::span("{}", 2)), (store.object(object) / "out/a.json").string());
        make_folder(pipeline_folder(store, pipeline));
        return true;
    }();
    (void)made;
    for (const auto& file :
         {store.key_file(key), store.manifest_file(object), pipeline_folder(store, pipeline) / "s.json", index, costs})
        write_sealed(file, text_of(bytes));
    const auto result = store.lookup(key);
    const auto damage = store.verify(object, 1);
    const auto record = read_stage_record(store, pipeline, "s");
    used_results(store);
    FileHashes(index).save();
    Statistics(store).corrected("t", {1, 1, 1});
    if (record)
    {
        write_stage_record(store, pipeline, *record);
        require(read_stage_record(store, pipeline, "s")->key == record->key, "written and read, the same record");
    }
    if (!result && !record)
    {
        const Value manifest = store.manifest(object);
        for (const Value& entry : manifest.at("files").as_list())
            require(to_value(stored_file_from(entry)) == entry && !stored_file_from(entry).digest().empty(), "the same entry");
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
    {"stored",
     "framework/src/store/(stage_record|statistics)\\.cpp|framework/src/base/(durable_file|chunk_hash|file_stamp)\\.cpp",
     read_stored},
    {"checked", "sdk/src/(checked_file|kept_pieces)\\.cpp|plugins/texture_synthesize/checkpoint\\.cpp", read_checked_files}};

}  // namespace
}  // namespace fresco::fuzz
