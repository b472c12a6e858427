#include "parsers.h"

#include "framework/tests/hand_made_catalog.h"

#include "base/durable_file.h"
#include "pipeline/pipeline.h"
#include "store/stage_record.h"
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

/// Throws the first problem; a pipeline with problems is refused whole.
void read_pipeline(Bytes bytes)
{
    static const Catalog catalog = host::testing::hand_made_catalog();
    const auto file = file_with(bytes, "p.yaml");
    const PipelineResult result = load_pipeline({file.filename(), {}, file.parent_path()}, catalog);
    require((result.exit_code() == 0) == result.problems.empty(), "an exit code for each problem");
    if (!result.problems.empty())
        throw Error(to_string(result.problems.front()));
    for (const PipelineStage& stage : result.pipeline.stages)
        require(stage.type != nullptr, "a type for each stage");
}

/// With the checksum that a record ends with: else nothing behind it would be reached.
void write_sealed(const std::filesystem::path& file, std::string_view text)
{
    const std::string map(text.substr(0, text.rfind('}')));
    const std::string sealed = map + ",\"checksum\":\"" + content_hash(map) + "\"}\n";
    file_with(std::as_bytes(std::span(sealed)), file.string());
}

/// A record of the store, as that of a key, of a result and of a stage.
void read_stored(Bytes bytes)
{
    static const Store store(file_with({}, "format").parent_path() / "store");
    static const std::string key = "k";
    static const std::string object = object_id(key, {});
    static const std::filesystem::path pipeline = "/p.yaml";
    static const bool made = []
    {
        make_folder(store.object(object));
        make_folder(pipeline_folder(store, pipeline));
        return true;
    }();
    (void)made;
    for (const auto& file : {store.key_file(key), store.manifest_file(object), pipeline_folder(store, pipeline) / "s.json"})
        write_sealed(file, text_of(bytes));
    const auto result = store.lookup(key);
    const auto damage = store.verify(object, 1);
    const auto record = read_stage_record(store, pipeline, "s");
    used_results(store);
    if (!result && !record)
        (void)store.manifest(object);
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
    {"stored", "framework/src/store/stage_record\\.cpp|framework/src/base/(durable_file|chunk_hash|file_stamp)\\.cpp",
     read_stored},
    {"checked", "sdk/src/(checked_file|kept_pieces)\\.cpp|plugins/texture_synthesize/checkpoint\\.cpp", read_checked_files}};

}  // namespace
}  // namespace fresco::fuzz
