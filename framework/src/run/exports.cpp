#include "run/exports.h"
#include "base/common.h"
#include "base/fault.h"
#include "base/records.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files.h>
#include <fresco/wording.h>

#include <algorithm>
#include <sys/stat.h>
#include <utility>

namespace fresco::host
{
namespace
{

/// Flushed to the disk together. As many descriptors are open at a time.
constexpr std::size_t most_copies_at_once = 128;

std::string normal(const std::string& name)
{
    return fs::path(name).lexically_normal().generic_string();
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

void KnownFiles::add(const fs::path& file)
{
    struct stat status = {};
    if (stat(file.c_str(), &status) != 0)
        return;
    by_id_.emplace(Id(status.st_dev, status.st_ino), file);
    by_name_.emplace(lower_case(file.lexically_normal().string()), file);
}

std::optional<fs::path> KnownFiles::find(const fs::path& file) const
{
    struct stat status = {};
    if (stat(file.c_str(), &status) != 0)
        return std::nullopt;
    if (const auto found = by_id_.find(Id(status.st_dev, status.st_ino)); found != by_id_.end())
        return found->second;
    const auto found = by_name_.find(lower_case(file.lexically_normal().string()));
    if (found == by_name_.end())
        return std::nullopt;
    // On a case-sensitive file system, the folder lists both names.
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(file.parent_path(), error))
        if (entry.path().filename() == file.filename())
            return std::nullopt;
    return found->second;
}

std::vector<fs::path> named_inputs(const Pipeline& pipeline)
{
    std::vector<fs::path> files;
    for (const PipelineText& text : pipeline.texts)
        files.push_back(text.file);
    for (const PipelineStage& stage : pipeline.stages)
        files.insert(files.end(), stage.input_files.begin(), stage.input_files.end());
    return files;
}

Exporter::Exporter(const Store& store, const Pipeline& pipeline, fs::path out, FileHashes& hashes, bool replace)
    : store_(store), pipeline_(pipeline), out_(std::move(out)), hashes_(hashes), replace_(replace),
      new_inputs_(named_inputs(pipeline))
{
}

void Exporter::protect(const fs::path& input)
{
    new_inputs_.push_back(input);
}

bool Exporter::is_input(const fs::path& file)
{
    if (!path_status(file))
        return false;
    for (const fs::path& input : std::exchange(new_inputs_, {}))
        inputs_.add(input);
    return inputs_.find(file).has_value();
}

OutputOwner Exporter::owner(const PipelineStage& stage) const
{
    std::string output;
    for (const PipelineStage::Output& each : stage.outputs)
        output += (output.empty() ? "" : ", ") + each.name;
    return {pipeline_.file, stage.place, stage.own_name, output};
}

fs::path Exporter::folder_of(const PipelineStage& stage) const
{
    return (out_ / stage.place).lexically_normal();
}

std::string Exporter::obstacle(const PipelineStage& stage, const OutputRecord& record, const std::string& name)
{
    const fs::path file = folder_of(stage) / name;
    if (is_input(file))
        return file.string() + ": " + input_obstacle;
    if (file.filename() == OutputRecord::file_name)
        return file.string() + ": is the name of fresco's record; give the output another name";
    if (const auto other = exported_.find(file); other && *other != file)
        return file.string() + ": is the same file as " + other->string() +
               ", which this run wrote: the file system ignores case; give one of them another name";
    if (is_folder(file))
        return file.string() + ": is a folder where the stage's file goes; move it away";
    const std::string reason = replace_ ? "" : record.obstacle(name, owner(stage), hashes_);
    return reason.empty() ? "" : file.string() + ": " + reason + "; " + obstacle_advice;
}

std::vector<std::string> Exporter::obstacles(const PipelineStage& stage, const std::string& object)
{
    const OutputRecord record(folder_of(stage));
    std::set<std::string> names;
    if (object.empty())
    {
        for (const PipelineStage::Output& output : stage.outputs)
            if (output.is_file || !is_folder(folder_of(stage) / output.name))
                names.insert(normal(output.name));
        for (const std::string& name : record.names_of(owner(stage)))
            names.insert(name);
    }
    else  // A list that cannot be read is repaired when it is copied.
        names = attempt([&] { return missing(stage, object); }).value_or(names);
    std::vector<std::string> found;
    for (const std::string& name : names)
        if (std::string text = obstacle(stage, record, name); !text.empty())
            found.push_back(std::move(text));
    return found;
}

std::size_t Exporter::copy(const PipelineStage& stage, const std::string& object, const std::function<bool()>& stop)
{
    OutputRecord record(folder_of(stage));
    std::set<std::string> written;
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
        Batch batch;
        for (const std::string& listed_name : listed->names)
        {
            const std::string name = normal(listed_name);
            if (stop())
                return 0;
            if (batch.copies.size() >= most_copies_at_once)
                place(stage, record, batch);
            const fs::path to = folder_of(stage) / name;
            const auto collision = owners_.claim(fs::path(stage.place) / name, stage.name, true);
            const fs::path from = folder / name;
            // With --replace, identical files are written again, so that the record lists them.
            const bool same = is_there(to, from) && !(replace_ && !record.obstacle(name, owner(stage), hashes_).empty());
            // Two exports of one texture may well agree on its picture.
            if (collision && !same)
                throw Error(to.string() + ": " + *collision);
            if (!same)
            {
                // All files at once: there may be thousands, and each look reads the manifest.
                if (auto damage = verified ? std::nullopt : store_.verify(object, 1, output))
                    throw std::move(*damage);
                verified = true;
                if (const std::string text = obstacle(stage, record, name); !text.empty())
                    throw Error(text);
                make_folder_or(to.parent_path(), "choose another with --out");
                batch.copies.push_back({from, to});
            }
            batch.found.push_back({stage.name, to, !same});
            written.insert(name);
        }
        place(stage, record, batch);
    }
    return remove_stale(stage, record, written);
}

void Exporter::place(const PipelineStage& stage, OutputRecord& record, Batch& batch)
{
    std::vector<OutputRecord::NewFile> files;
    for (const FileCopy& copy : batch.copies)
        files.push_back({copy.to.lexically_relative(folder_of(stage)).generic_string(), hashes_.hash(copy.from)});
    if (!files.empty())
        record.begin(files, owner(stage), hashes_);
    copy_files(batch.copies, [] { fault_point("export.written"); });
    for (std::size_t i = 0; i < files.size(); ++i)
    {
        hashes_.remember(batch.copies[i].to, files[i].hash);
        fault_point("export.copied");
    }
    if (!files.empty())
        record.wrote(files, owner(stage));
    for (const File& file : batch.found)
    {
        if (const auto other = exported_.find(file.path); other && *other != file.path)
            throw Error(obstacle(stage, record, file.path.lexically_relative(folder_of(stage)).generic_string()));
        exported_.add(file.path);
    }
    files_.insert(files_.end(), batch.found.begin(), batch.found.end());
    batch = {};
}

std::size_t Exporter::remove_stale(const PipelineStage& stage, OutputRecord& record, const std::set<std::string>& written)
{
    std::vector<std::string> gone;
    std::size_t count = 0;
    for (const std::string& name : record.names_of(owner(stage)))
    {
        const fs::path file = folder_of(stage) / name;
        if (written.contains(name) || exported_.find(file) || is_input(file))
            continue;
        const bool is_own = is_file(file) && record.obstacle(name, owner(stage), hashes_).empty();
        const bool removed = is_own && remove_path(file);
        count += removed ? 1 : 0;
        // A changed file is the user's from now on.
        if (removed || !is_own)
            gone.push_back(name);
    }
    if (!gone.empty())
        record.forget(gone);
    return count;
}

std::set<std::string> Exporter::missing(const PipelineStage& stage, const std::string& object) const
{
    std::set<std::string> names;
    for (const auto& output : files_outputs(stage))
    {
        const fs::path folder = store_.object(object) / output;
        const auto listed = Files::load({folder, store_.root()});
        for (const std::string& name : listed->names)
            if (!is_there(folder_of(stage) / name, folder / name))
                names.insert(normal(name));
    }
    return names;
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
