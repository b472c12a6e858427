#include "base/common.h"
#include "report/page.h"
#include "worker/worker_factory.h"

#include "report/report.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/reader.h>
#include <fresco/viewer.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>

namespace fresco::host
{
namespace
{

/// As long as the factory. The probe has seen that it is a T.
template <class T>
T& component(WorkerFactory& factory, const Value& config)
{
    return dynamic_cast<T&>(*factory.create(T::component_kind, config));
}

WorkerFactory factory_for(const Value& libraries)
{
    std::map<std::string, std::filesystem::path> files;
    for (const auto& [type, library] : libraries.as_map())
        files[type] = library.at("library").as_string();
    return {std::move(files), libraries};
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

}  // namespace

PageMedia make_previews(const Value& requests, const Store& store)
{
    WorkerFactory factory = factory_for(requests.at("libraries"));
    std::map<std::string, std::vector<std::string>> shown;  // By a stage: names of its pictures.
    std::uintmax_t video_bytes = PageEntry().video_bytes;
    PageMedia media;
    // What stages made of an artifact comes before it: it may show the same.
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
        send_all(child_channel, title_of(request) + "\n");
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

int internal_page(const std::filesystem::path& request_file)
{
    try
    {
        const Value request = parse_json(read_text_file(request_file), request_file.string());
        const Store store(request.at("store").as_string());
        set_input_roots(input_roots_from(request.at("roots")));
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
