#include "run/exports.h"
#include "base/common.h"
#include "base/fault.h"
#include "base/machine.h"
#include "base/records.h"
#include <fresco/error.h>
#include <fresco/files.h>

#include <algorithm>

namespace fresco::host
{
namespace
{

/// Flushed to the disk together. As many descriptors are open at a time.
constexpr std::size_t most_copies_at_once = 128;

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
    const std::size_t at_once =
        std::clamp(static_cast<std::size_t>(std::max(free_descriptors(), 0)) / 2, std::size_t{1}, most_copies_at_once);
    for (const auto& output : files_outputs(stage))
    {
        const fs::path folder = store_.object(object) / output;
        if (auto damage = store_.verify(object, 1, output + "/files.json"); damage)
            throw std::move(*damage);
        std::shared_ptr<const Files> listed;
        try
        {
            listed = Files::load({folder, store_.root()});
        }
        catch (const Error& error)
        {
            throw Damage{object, error.what()};
        }
        bool verified = false;
        std::vector<File> found;
        std::vector<FileCopy> copies;
        for (const auto& name : listed->names)
        {
            if (stop())
                return;
            if (copies.size() >= at_once)
                place(found, copies);
            const fs::path to = place_of(stage, name);
            const auto collision = owners_.claim(fs::path(stage.place) / name, stage.name, true);
            const fs::path from = folder / name;
            const bool same = is_there(to, from);
            // Two exports of one texture may well agree on its picture.
            if (collision && !same)
                throw Error(to.string() + ": " + *collision);
            if (!same)
            {
                // All files at once: there may be thousands, and each look reads the manifest.
                if (auto damage = verified ? std::nullopt : store_.verify(object, 1, output))
                    throw std::move(*damage);
                verified = true;
                if (is_folder(to))
                    throw Error(to.string() + ": is a folder where the stage's file goes; move it away");
                make_folder_or(to.parent_path(), "choose another with --out");
                copies.push_back({from, to});
            }
            found.push_back({stage.name, to, !same});
        }
        place(found, copies);
    }
}

void Exporter::place(std::vector<File>& found, std::vector<FileCopy>& copies)
{
    copy_files(copies, [] { fault_point("export.written"); });
    for (const FileCopy& copy : copies)
    {
        hashes_.remember(copy.to, hashes_.hash(copy.from));
        fault_point("export.copied");
    }
    files_.insert(files_.end(), found.begin(), found.end());
    found.clear();
    copies.clear();
}

std::size_t Exporter::missing(const PipelineStage& stage, const std::string& object) const
{
    std::size_t count = 0;
    for (const auto& output : files_outputs(stage))
    {
        const fs::path folder = store_.object(object) / output;
        const auto listed = Files::load({folder, store_.root()});
        for (const auto& name : listed->names)
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
