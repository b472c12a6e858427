#include "run/exports.h"
#include "base/durable_file.h"
#include "base/fault.h"
#include <fresco/copy_file.h>
#include <fresco/error.h>
#include <fresco/files.h>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

void copy_whole(const fs::path& from, const fs::path& to)
{
    try
    {
        make_folder(to.parent_path());
    }
    catch (const Error& error)
    {
        throw Error(std::string(error.what()) + "; choose another with --out");
    }
    copy_file(from, to, [] { fault_point("export.written"); });
}

}  // namespace

std::vector<std::string> files_outputs(const PipelineStage& stage)
{
    std::vector<std::string> names;
    for (const auto& output : stage.type->declaration.at("outputs").as_list())
        if (output.at("artifact").as_string() == Files::artifact_name)
            names.push_back(output.at("name").as_string());
    return names;
}

void Exporter::copy(const PipelineStage& stage, const std::string& object, const std::function<bool()>& stop)
{
    for (const auto& output : files_outputs(stage))
    {
        const fs::path folder = store_.object(object) / output;
        if (auto damage = store_.verify(object, 1, output + "/files.json"); damage)
            throw DamagedObject{std::move(*damage)};
        std::shared_ptr<const Files> listed;
        try
        {
            listed = Files::load({folder, store_.root()});
        }
        catch (const Error& error)
        {
            throw DamagedObject{{object, error.what()}};
        }
        bool verified = false;
        for (const auto& name : listed->names)
        {
            if (stop())
                return;
            const fs::path to = place_of(stage, name);
            const auto collision = owners_.claim(fs::path(stage.place) / name, stage.name);
            const fs::path from = folder / name;
            const bool same = is_there(to, from);
            // Two exports of one texture may well agree on its picture.
            if (collision && !same)
                throw Error(to.string() + ": " + *collision);
            if (!same)
            {
                // All files at once: there may be thousands, and each look reads the manifest.
                if (auto damage = verified ? std::nullopt : store_.verify(object, 1, output))
                    throw DamagedObject{std::move(*damage)};
                verified = true;
                if (std::error_code error; fs::is_directory(to, error))
                    throw Error(to.string() + ": is a folder where the stage's file goes; move it away");
                copy_whole(from, to);
                hashes_.remember(to, hashes_.hash(from));
                fault_point("export.copied");
            }
            files_.push_back({stage.name, to, !same});
        }
    }
}

std::size_t Exporter::missing(const PipelineStage& stage, const std::string& object) const
{
    std::size_t count = 0;
    for (const auto& output : files_outputs(stage))
    {
        const fs::path folder = store_.object(object) / output;
        for (const auto& name : Files::load({folder, store_.root()})->names)
            count += is_there(place_of(stage, name), folder / name) ? 0 : 1;
    }
    return count;
}

fs::path Exporter::place_of(const PipelineStage& stage, const std::string& name) const
{
    return (out_ / stage.place / name).lexically_normal();
}

bool Exporter::is_there(const fs::path& to, const fs::path& from) const
{
    try
    {
        return fs::is_regular_file(to) && fs::file_size(to) == fs::file_size(from) && hashes_.hash(to) == hashes_.hash(from);
    }
    catch (const std::exception&)
    {
        return false;
    }
}

}  // namespace fresco::host
