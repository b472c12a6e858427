#include "base/common.h"
#include "report/page.h"

#include "pipeline/pipeline_options.h"
#include "report/report.h"
#include "run/exports.h"
#include "worker/worker_factory.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/reader.h>
#include <fresco/viewer.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>
#include <set>

namespace fresco::host
{
namespace
{

constexpr std::size_t most_pictures = 36;  // Limit for one type of artifact.
constexpr std::size_t most_of_one = 12;

class Requests
{
  public:
    Requests(const std::vector<ShownStage>& stages, const Catalog& catalog, const Store& store, const ShowingPage& page)
        : stages_(stages), types_(catalog), store_(store), page_(page)
    {
        for (const TypeDescription* type : catalog.types(Viewer::component_kind))
            viewers_.emplace(type->declaration.at("artifact").as_string(), type);
    }

    Value take()
    {
        for (const ShownStage& shown : stages_)
        {
            if (!shown.object.empty() && store_.present(shown.object))
                add_outputs(shown);
            if (shown.names.empty())
                add_files(*shown.stage);
        }
        share_out();
        return Value::Map{{"libraries", std::move(libraries_)}, {"artifacts", std::move(artifacts_)}};
    }

  private:
    void use(const TypeDescription& type)
    {
        libraries_.set(type.type, Value::Map{{"library", type.library.string()}, {"hash", type.bytes->hash()}});
    }

    /// The configuration of a viewer with its defaults and the pipeline's components; of one that lacks a part, what it has: it
    /// says so itself.
    Value used(const TypeDescription& viewer, const PipelineStage& stage)
    {
        use(viewer);
        const Value only_type = Value::Map{{"type", viewer.type}};
        ProblemList problems;
        OptionUses uses;
        Value config =
            OptionChecker(types_, *stage.chosen_components, problems)
                .complete_component(Viewer::component_kind, yaml_from_value(only_type, {}), {}, "viewer " + viewer.type, uses);
        for (const TypeDescription* part : uses.components)
            use(*part);
        return config.is_null() ? only_type : config;
    }

    void add_outputs(const ShownStage& shown)
    {
        const PipelineStage& stage = *shown.stage;
        const std::vector<std::string> exported = files_outputs(stage);
        for (const Value& output : stage.type->declaration.at("outputs").as_list())
        {
            const std::string& name = output.at("name").as_string();
            const bool exports = std::ranges::find(exported, name) != exported.end();
            const auto viewer = viewers_.find(output.at("artifact").as_string());
            if (viewer == viewers_.end() || (!shown.names.empty() && !exports) ||
                !fs::is_directory(store_.object(shown.object) / name))
                continue;
            Value& request = add(stage, name, *viewer);
            request.set("object", shown.object);
            request.set("readers", readers(stage.name, name));
            request.set("names", Value::List(shown.names.begin(), shown.names.end()));
            if (!exports)
                continue;
            const fs::path folder = (page_.out / stage.place).lexically_normal().lexically_relative(page_.folder);
            request.set("folder", folder == "." ? "" : folder.generic_string());
        }
    }

    void add_files(const PipelineStage& stage)
    {
        for (const Wire& wire : stage.wires)
        {
            const auto viewer = viewers_.find(wire.artifact);
            if (wire.file.empty() || viewer == viewers_.end() || !files_.insert(wire.file).second)
                continue;
            for (const TypeDescription* component : stage.components)
                use(*component);
            Value& request = add(stage, wire.port, *viewer);
            request.set("file", wire.file.string());
            request.set("reader", wire.reader);
        }
    }

    /// For an artifact and its viewer.
    Value& add(const PipelineStage& stage, const std::string& port,
               const std::pair<const std::string, const TypeDescription*>& viewer)
    {
        return artifacts_.emplace_back(Value::Map{{"stage", stage.name},
                                                  {"port", port},
                                                  {"artifact", viewer.first},
                                                  {"viewer", used(*viewer.second, stage)},
                                                  {"readers", Value::List{}},
                                                  {"names", Value::List{}}});
    }

    Value::List readers(const std::string& stage, const std::string& port) const
    {
        Value::List names;
        for (const ShownStage& other : stages_)
            if (std::ranges::any_of(other.stage->wires,
                                    [&](const Wire& wire) { return wire.from_stage == stage && wire.from_port == port; }))
                names.push_back(other.stage->name);
        return names;
    }

    /// Finds the last artifacts of each type, and how many pictures each may show.
    void share_out()
    {
        std::map<std::string, std::size_t> counts;
        for (const Value& request : artifacts_)
            ++counts[request.at("artifact").as_string()];
        std::set<std::string> seen;
        std::ranges::reverse(artifacts_);
        for (Value& request : artifacts_)
        {
            const std::string artifact = request.at("artifact").as_string();
            request.set("longest_px", page_.longest_px);
            request.set("last", seen.insert(artifact).second);
            request.set("most", std::clamp<std::size_t>(most_pictures / counts[artifact], 1, most_of_one));
        }
        std::ranges::reverse(artifacts_);
    }

    const std::vector<ShownStage>& stages_;
    TypeTable types_;
    std::map<std::string, const TypeDescription*> viewers_;  ///< By the artifact.
    const Store& store_;
    const ShowingPage& page_;
    std::set<fs::path> files_;
    Value libraries_{Value::Map{}};
    Value::List artifacts_;
};

/// As long as the factory. fresco-describe has seen that it is a T.
template <class T>
T& component(WorkerFactory& factory, const Value& config)
{
    return dynamic_cast<T&>(*factory.create(T::component_kind, config));
}

std::shared_ptr<const Artifact> artifact_of(const Value& request, const Viewer& viewer, WorkerFactory& factory,
                                            const Store& store)
{
    if (const Value* file = request.find("file"))
        return component<FileReader>(factory, request.at("reader")).read(file->as_string());
    return viewer.type().load({store.object(request.at("object").as_string()) / request.at("port").as_string(), store.root()});
}

/// "texture.texture", of a stage; or a file.
std::string title_of(const Value& request)
{
    if (const Value* file = request.find("file"))
        return file->as_string();
    return request.at("stage").as_string() + "." + request.at("port").as_string();
}

/// Makes the previews. Artifacts that cannot be shown get a note.
PageMedia make_previews(const Value& requests, const Store& store)
{
    std::map<std::string, fs::path> libraries;
    for (const auto& [type, library] : requests.at("libraries").as_map())
        libraries[type] = library.at("library").as_string();
    WorkerFactory factory(std::move(libraries), requests.at("libraries"));
    std::map<std::string, std::vector<std::string>> shown;  // By a stage: names of its pictures.
    std::uintmax_t video_bytes = PageEntry().video_bytes;
    PageMedia media;
    // Results made from an artifact come before it, as they may show the same.
    Value::List artifacts = requests.at("artifacts").as_list();
    std::ranges::reverse(artifacts);
    for (const Value& request : artifacts)
    {
        PageEntry page;
        page.longest_px = static_cast<int>(request.at("longest_px").as_int());
        page.last = request.at("last").as_bool();
        page.most_pictures = static_cast<std::size_t>(request.at("most").as_int());
        page.video_bytes = video_bytes;
        page.names = each(request.at("names").as_list(), &Value::as_string);
        page.most_pictures = std::max(page.most_pictures, page.names.size());
        for (const Value& reader : request.at("readers").as_list())
            std::ranges::copy(shown[reader.as_string()], std::back_inserter(page.names));
        write_all(child_channel, title_of(request) + "\n");
        try
        {
            const auto& viewer = component<Viewer>(factory, request.at("viewer"));
            viewer.show(*artifact_of(request, viewer, factory, store), page);
        }
        catch (const std::exception& error)
        {
            page.note(error.what());
        }
        video_bytes = page.video_bytes;
        Value& entry = page.value;
        if (entry.as_map().empty())
            continue;
        if (page.scripts != nullptr && std::ranges::find(media.scripts, page.scripts) == media.scripts.end())
            media.scripts.push_back(page.scripts);
        if (const Value* pictures = request.find("folder") != nullptr ? entry.find("pictures") : nullptr)
            for (const Value& picture : pictures->as_list())
                shown[request.at("stage").as_string()].push_back(picture.at("name").as_string());
        for (const char* name : {"stage", "port", "artifact", "folder", "file"})
            if (const Value* value = request.find(name))
                entry.set(name, *value);
        media.entries.push_back(std::move(entry));
    }
    std::ranges::reverse(media.entries);
    return media;
}

}  // namespace

Value preview_requests(const std::vector<ShownStage>& stages, const Catalog& catalog, const Store& store, const ShowingPage& page)
{
    return Requests(stages, catalog, store, page).take();
}

int internal_page(const std::filesystem::path& request_file)
{
    try
    {
        const Value request = parse_json(read_text_file(request_file), request_file.string());
        const Store store(request.at("store").as_string());
        const PageMedia media = make_previews(request.at("previews"), store);
        write_durable_file(request.at("html").as_string(),
                           page_html(request.at("data"), media, request.at("signature").as_string()));
        return 0;
    }
    catch (const std::exception& error)
    {
        std::puts(error.what());
        return 1;
    }
}

}  // namespace fresco::host
