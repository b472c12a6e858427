#include "pipeline/pipeline_document.h"
#include "base/common.h"
#include "base/process.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/wording.h>

#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <ranges>

namespace fresco::host
{
namespace
{
constexpr std::size_t base_limit = 16;

/// One file, before it is merged with its base.
struct Layer
{
    PipelineDocument content;
    YamlNode base;  ///< Null: none.
    bool has_stages = false;
};

/// Returns the map under `key`, or an empty one. Reports keys that cannot name a `named`.
YamlNode section(const YamlNode& root, std::string_view key, const std::string& named, ProblemList& problems)
{
    const YamlNode::Entry* entry = root.find(key);
    if (entry && !entry->value.is_map() && !entry->value.is_null() && entry->value.is_valid())
        problems.add(entry->value, "'" + std::string(key) + "' must be a map {name: …}, got " + entry->value.summary());
    if (!entry || !entry->value.is_map())
        return YamlNode(YamlNode::Kind::map, root);
    for (const YamlNode::Entry& named_entry : entry->value.entries)
        if (!is_name(named_entry.key))
            problems.add(named_entry, "'" + named_entry.key + "' cannot name a " + named +
                                          ": a name has letters, digits, '_' and '-' and begins with a letter or '_'");
    return entry->value;
}

/// Returns nothing if the file cannot be read, which is reported.
std::optional<std::string> text_on_disk(const fs::path& file, const Position& wanted_at, ProblemList& problems)
{
    try
    {
        return read_text_file(file, yaml_size_limit);
    }
    catch (const MissingInput& error)
    {
        problems.add(wanted_at, error.what(), ProblemKind::missing_input);
    }
    catch (const Error& error)
    {
        problems.add(wanted_at, error.what());
    }
    return std::nullopt;
}

Layer read_layer(const fs::path& file, const std::vector<PipelineText>& texts, const std::string& shown,
                 const Position& wanted_at, ProblemList& problems)
{
    problems.announce_file(shown);
    Layer layer;
    const auto given = std::ranges::find(texts, file, &PipelineText::file);
    const std::optional<std::string> text = given != texts.end() ? given->text : text_on_disk(file, wanted_at, problems);
    PipelineDocument& content = layer.content;
    content.complete = text.has_value();
    content.texts.push_back({file, text.value_or("")});
    if (!text)
        return layer;
    const auto source = std::make_shared<const YamlSource>(YamlSource{shown, file.parent_path(), false});
    YamlNode root = parse_yaml(*text, source, problems, content.complete);
    if (!root.is_map())
    {
        if (content.complete)
            problems.add(root, root.is_null() ? "the file is empty: a pipeline has 'version: 1' and 'stages:'"
                                              : "a pipeline is a map with 'version: 1' and 'stages:', got " + root.summary());
        content.complete = false;
        return layer;
    }
    static const std::vector<std::string> keys{"version", "base", "vars", "matrix", "components", "stages", "preview"};
    for (const YamlNode::Entry& entry : root.entries)
        if (std::ranges::find(keys, entry.key) == keys.end())
            problems.add(entry, "unknown key '" + entry.key + "'" + suggestion(entry.key, keys));
    const YamlNode::Entry* version = root.find("version");
    if (!version && content.complete)
        problems.add(root, "missing 'version: 1'");
    else if (version && version->value.is_valid() && !version->value.is_word("1"))
        problems.add(version->value, "version must be 1, got " + version->value.summary());
    content.vars = section(root, "vars", "var", problems);
    content.matrix = section(root, "matrix", "var", problems);
    content.components = section(root, pipeline_components, "kind of component", problems);
    content.stages = section(root, "stages", "stage", problems);
    const YamlNode::Entry* stages = root.find("stages");
    layer.has_stages = stages && !stages->value.is_null() && !(stages->value.is_map() && content.stages.entries.empty());
    if (root.find("preview"))
        content.preview = section(root, "preview", "stage", problems);
    if (const YamlNode::Entry* base = root.find("base"))
    {
        const bool usable =
            base->value.is_scalar() && !base->value.text.empty() && base->value.text.find("${") == std::string::npos;
        if (usable)
            layer.base = base->value;
        else if (base->value.is_valid())
            problems.add(base->value, "'base' must be the path of a pipeline file, without vars, got " + base->value.summary());
        content.complete = content.complete && usable;
    }
    return layer;
}

bool type_changes(const YamlNode& below, const YamlNode& above)
{
    const YamlNode::Entry* old_type = below.find("type");
    const YamlNode::Entry* new_type = above.find("type");
    return old_type && new_type && old_type->value.is_scalar() && new_type->value.is_scalar() &&
           old_type->value.text != new_type->value.text;
}

/// Kind of a merged map.
enum class Level
{
    stages,
    stage,
    input,
    config,
    axes
};

void merge(YamlNode& below, YamlNode above, Level level, ProblemList& problems);

void merge_entry(YamlNode& below, YamlNode::Entry above, Level level, ProblemList& problems)
{
    YamlNode::Entry* old = below.find(above.key);
    if (above.value.is_null())
    {
        if (old)
            below.erase(above.key);
        else
            problems.add(above, "an empty value removes what the base has, but the base has no '" + above.key + "' here");
    }
    else if (!old)
        below.entries.push_back(std::move(above));
    else if (level != Level::axes && old->value.is_map() && above.value.is_map())
    {
        static_cast<YamlPlace&>(*old) = above;
        const Level inner = level == Level::stages                          ? Level::stage
                            : level == Level::stage && above.key == "input" ? Level::input
                            : level == Level::input                         ? Level::input
                                                                            : Level::config;
        merge(old->value, std::move(above.value), inner, problems);
    }
    else
        *old = std::move(above);
}

void merge(YamlNode& below, YamlNode above, Level level, ProblemList& problems)
{
    const bool one_file = level == Level::input && (below.find("file") || above.find("file"));
    if (one_file || (level != Level::stages && type_changes(below, above)))
    {
        // An option of the old type means nothing to the new one; where the stage's inputs come from still does.
        if (const YamlNode::Entry* input = below.find("input"); level == Level::stage && input && !above.find("input"))
            above.entries.push_back(*input);
        below = std::move(above);
        return;
    }
    below.stand_at(above);
    for (YamlNode::Entry& entry : above.entries)
        merge_entry(below, std::move(entry), level, problems);
}

/// Brings a base's preview to a file above it. What the base's preview changes in a stage means nothing to another type.
void merge_preview(PipelineDocument& below, PipelineDocument& above, ProblemList& problems)
{
    for (const YamlNode::Entry& stage : above.stages.entries)
        if (const YamlNode::Entry* old = below.stages.find(stage.key); old && type_changes(old->value, stage.value))
            below.preview.erase(stage.key);
    if (above.preview.is_null())
        return;
    below.preview.kind = YamlNode::Kind::map;
    merge(below.preview, std::move(above.preview), Level::stages, problems);
}

/// Puts a file above its base.
void merge_documents(PipelineDocument& below, PipelineDocument above, ProblemList& problems)
{
    for (YamlNode::Entry& var : above.vars.entries)
    {
        // A var that the upper file sets is not an axis any more, unless the file says so.
        if (!above.matrix.find(var.key))
            below.matrix.erase(var.key);
        if (YamlNode::Entry* old = below.vars.find(var.key))
            *old = std::move(var);
        else
            below.vars.entries.push_back(std::move(var));
    }
    for (YamlNode::Entry& axis : above.matrix.entries)
        merge_entry(below.matrix, std::move(axis), Level::axes, problems);
    merge_preview(below, above, problems);
    if (above.components.is_map())
        merge(below.components, std::move(above.components), Level::config, problems);
    if (above.stages.is_map())
        merge(below.stages, std::move(above.stages), Level::stages, problems);
    below.texts.insert(below.texts.begin(), above.texts.begin(), above.texts.end());
}

/// The base that `name` names: the file `beside` the `upper` one, else an installed pipeline, which a file of the same name can
/// extend so. Nothing, and a problem, where there is neither.
std::optional<fs::path> base_file(const fs::path& upper, const fs::path& beside, const YamlNode& name,
                                  const std::vector<PipelineText>& texts, ProblemList& problems)
{
    const fs::path installed = (installed_pipelines() / name.text).lexically_normal();
    const std::vector<fs::path> files = beside == upper ? std::vector{installed} : std::vector{beside, installed};
    for (const fs::path& file : files)
        if (std::ranges::find(texts, file, &PipelineText::file) != texts.end())
            return file;
    std::error_code unknown;
    for (const fs::path& file : files)
        if (fs::exists(file, unknown))
            return file;
    const std::string also = installed == beside ? "" : ", nor an installed one, '" + installed.string() + "'";
    problems.add(name, "no such pipeline file '" + beside.string() + "'" + also, ProblemKind::missing_input);
    return std::nullopt;
}

/// A base may be shared by pipelines of which only some have a stage that its preview names.
void check_preview(const YamlNode& preview, const YamlNode& stages, const std::shared_ptr<const YamlSource>& own,
                   ProblemList& problems)
{
    for (const YamlNode::Entry& entry : preview.entries)
        if (!entry.value.is_map() && entry.value.is_valid())
            problems.add(entry, "the preview of '" + entry.key + "' must be a map {option: …}, got " + entry.value.summary());
        else if (entry.value.find("type"))
            problems.add(*entry.value.find("type"), "a preview cannot change the type of a stage");
        else if (entry.source == own && !stages.entries.empty() && !stages.find(entry.key))
            problems.add(entry, "unknown stage '" + entry.key + "'" +
                                    problems.hint(entry.key, std::views::transform(stages.entries, &YamlNode::Entry::key)));
}

void check_stages(const YamlNode& stages, const YamlNode& vars, ProblemList& problems)
{
    for (const YamlNode::Entry& stage : stages.entries)
        if (!stage.value.is_map() && stage.value.is_valid())
            problems.add(stage, "stage '" + stage.key + "' must be a map {type: …, option: …}, got " + stage.value.summary());
        else if (stage.key == pipeline_components)
            problems.add(stage, "'components' cannot name a stage: --set components.KIND=… sets the pipeline's components");
    for (const YamlNode::Entry& var : vars.entries)
        if (const YamlNode::Entry* stage = stages.find(var.key))
            problems.add(
                var, fmt::format(
                         "the var '{}' has the name of the stage on line {}: rename one of them, so that --set {} is unambiguous",
                         var.key, stage->line, var.key));
}
}  // namespace

fs::path installed_pipelines()
{
    return own_program().parent_path().parent_path() / "share/fresco/pipelines";
}

PipelineDocument read_pipeline_document(const fs::path& file, const std::string& shown, const std::vector<PipelineText>& texts,
                                        ProblemList& problems)
{
    std::vector<Layer> layers;
    fs::path next = file.lexically_normal();
    std::string name = shown;
    Position wanted_at{shown, 0, 0};
    bool complete = true;
    while (true)
    {
        layers.push_back(read_layer(next, texts, name, wanted_at, problems));
        complete = complete && layers.back().content.complete;
        const YamlNode& base = layers.back().base;
        if (base.is_null())
            break;
        const fs::path beside = (base.path_base() / base.text).lexically_normal();
        const auto found = base_file(next, beside, base, texts, problems);
        complete = complete && found;
        if (!found)
            break;
        next = *found;
        wanted_at = base;
        if (layers.size() >= base_limit)
        {
            problems.add(wanted_at, fmt::format("more than {} nested base files; does one lead back to another?", base_limit));
            complete = false;
            break;
        }
        name = fs::path(base.text).is_absolute() ? base.text
               : next == beside                  ? (fs::path(name).parent_path() / base.text).lexically_normal().string()
                                                 : next.string();
    }
    if (complete && std::ranges::none_of(layers, &Layer::has_stages))
        problems.add(layers.front().content.stages, "missing stages: a pipeline needs 'stages: {name: {type: …}}'");
    const std::shared_ptr<const YamlSource> own = layers.front().content.stages.source;
    PipelineDocument document = std::move(layers.back().content);
    document.vars.kind = document.matrix.kind = document.components.kind = document.stages.kind = YamlNode::Kind::map;
    for (layers.pop_back(); !layers.empty(); layers.pop_back())
        merge_documents(document, std::move(layers.back().content), problems);
    document.complete = complete;
    if (document.complete)
        check_preview(document.preview, document.stages, own, problems);
    check_stages(document.stages, document.vars, problems);
    for (YamlNode::Entry& stage : document.stages.entries)
        if (!stage.value.is_map())
            stage.value.kind = YamlNode::Kind::invalid;
    return document;
}

void apply_preview(PipelineDocument& document, const std::string& shown, ProblemList& problems)
{
    if (document.preview.is_null() && document.complete)
        problems.add({"--preview", 0, 0},
                     fmt::format("{} has no 'preview': {{STAGE: {{OPTION: VALUE}}}}, the options that make it fast; "
                                 "'base: …/presets/preview.yaml' has some",
                                 shown));
    for (YamlNode::Entry& entry : document.preview.entries)
        if (YamlNode::Entry* stage = document.stages.find(entry.key); stage && stage->value.is_map() && entry.value.is_map())
            merge(stage->value, std::move(entry.value), Level::stage, problems);
}

void drop_stages(PipelineDocument& document, const std::vector<std::string>& names, ProblemList& problems)
{
    const std::vector<std::string> known = document.stages.keys();
    for (const std::string& name : names)
        if (document.stages.find(name))
        {
            document.stages.erase(name);
            document.dropped.insert(name);
        }
        else if (document.complete && !document.dropped.contains(name))
            problems.add({"--without " + name, 0, 0}, "unknown stage '" + name + "'" + suggestion(name, known));
}

}  // namespace fresco::host
