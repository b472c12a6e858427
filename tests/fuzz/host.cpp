#include "parsers.h"

#include "framework/tests/hand_made_catalog.h"

#include "base/chunk_hash.h"
#include "base/file_stamp.h"
#include "base/records.h"
#include "pipeline/pipeline.h"
#include "pipeline/pipeline_wiring.h"
#include "store/stage_record.h"
#include "store/statistics.h"
#include "store/store.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/run_context.h>
#include <fresco/testing.h>

#include "plugins/texture_synthesize/checkpoint.h"

#include <bit>
#include <boost/algorithm/string/replace.hpp>
#include <fmt/format.h>
#include <sstream>

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
        require(!program_name(stage).empty(), "a name for its program");
    }
}

/// With the checksum that a record ends with: else nothing behind it would be reached. A line that is not a map stays as it is.
std::string sealed(std::string_view line)
{
    if (!line.starts_with('{'))
        return std::string(line) + '\n';
    const std::string map(line.substr(0, line.rfind('}')));
    return map + ",\"checksum\":\"" + content_hash(map) + "\"}\n";
}

/// Inputs cannot know the path or the stamp of an existing file: "HERE" and "STAMP" stand for them.
std::string filled_in(std::string text, const std::filesystem::path& here)
{
    const FileStamp stamp = stamp_of(here).value();
    boost::replace_all(text, "\"HERE\"", to_json(Value(here.string())));
    boost::replace_all(text, "\"STAMP\"",
                       fmt::format("[{},{},{},{},{},{},{}]", stamp.size, stamp.mtime_ns, stamp.ctime_ns, stamp.inode,
                                   stamp.device, stamp.file_system, stamp.file_system_id));
    return text;
}

/// Records that are written and journals that are tidied read the same as before.
void write_again(const Store& store, const std::filesystem::path& pipeline, const std::optional<StageRecord>& record,
                 const std::filesystem::path& index, const std::filesystem::path& here)
{
    FileHashes hashes(index);
    const std::string hash = hashes.hash(here);
    hashes.save();
    FileHashes(index).tidy();
    require(FileHashes(index).hash(here) == hash, "tidied, the same hashes");
    Statistics(store).add({"t", "o"}, {1, 1, 1});
    const auto figures = [&] { return std::bit_cast<std::uint64_t>(Statistics(store).last({"t", "o"}).value().seconds); };
    const auto untidy = figures();
    Statistics(store).tidy();
    require(figures() == untidy, "tidied, the same usage");
    if (!record)
        return;
    StageRecord changed = *record;
    changed.key += "'";
    write_stage_record(store, pipeline, changed);
    const auto again = read_stage_record(store, pipeline, "s");
    require(again && again->key == changed.key && again->object == record->object &&
                to_json(again->key_document) == to_json(record->key_document),
            "written and read, the same record");
}

/// The first line as the record of a key, of a result and of a stage; all lines as the journals of hashes and of runs.
void read_stored(Bytes bytes)
{
    static const Store store(file_with({}, "format").parent_path() / "store");
    static const std::string key = "k";
    static const std::string object = object_id(key, {});
    static const std::filesystem::path pipeline = "/p.yaml";
    static const std::filesystem::path records = pipeline_folder(store, pipeline);
    static const std::filesystem::path here = store.object(object) / "out/a.json";
    static const bool made = []
    {
        make_folder(here.parent_path());
        file_with(std::as_bytes(std::span("{}", 2)), here.string());
        std::filesystem::create_symlink(here, here.parent_path() / "link");
        make_folder(records);
        file_with({}, (records / "s.log").string());
        std::filesystem::create_symlink("nowhere", records / "gone.json");
        return true;
    }();
    (void)made;
    std::istringstream lines(filled_in(std::string(text_of(bytes)), here));
    std::string journal;
    for (std::string line; std::getline(lines, line);)
        journal += sealed(line);
    const std::string record_text = journal.substr(0, journal.find('\n') + 1);
    for (const auto& file : {store.key_file(key), store.manifest_file(object), records / "s.json"})
        file_with(std::as_bytes(std::span(record_text)), file.string());
    const auto index = store.root() / "index.json";
    for (const auto& file : {index, store.root() / "stats.jsonl"})
        file_with(std::as_bytes(std::span(journal)), file.string());
    const auto result = store.lookup(key);
    const auto damage = store.verify(object, 1);
    const auto record = read_stage_record(store, pipeline, "s");
    used_results(store, 0);
    write_again(store, pipeline, record, index, here);
    if (!result && !record)
    {
        const Value manifest = store.manifest(object);
        for (const Value& entry : manifest.at("files").as_list())
            require(to_value(stored_file_from(entry)) == entry, "the same entry");
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
    {"checked", "sdk/src/run_context\\.cpp|plugins/texture_synthesize/checkpoint\\.cpp", read_checked_files}};

}  // namespace
}  // namespace fresco::fuzz
