#include "run/output_record.h"
#include "base/common.h"
#include "base/records.h"
#include "base/text.h"
#include "store/stage_record.h"
#include <fresco/error.h>
#include <fresco/file_access.h>

#include <algorithm>
#include <cerrno>

namespace fresco::host
{

OutputRecord::OutputRecord(fs::path folder) : folder_(std::move(folder))
{
    read();
}

void OutputRecord::read()
{
    entries_.clear();
    const fs::path file = folder_ / file_name;
    if (!path_status(file) && (errno == ENOENT || errno == ENOTDIR))
        return;
    std::optional<Value> record;
    try
    {
        record = read_record(file);
    }
    catch (const MissingInput&)
    {
        throw Error(file.string() + ": cannot be read; it lists the files here that fresco may replace");
    }
    catch (const Error&)
    {
        return;
    }
    for (const auto& [name, entry] : record->at("files").as_map())
        entries_.emplace(name, entry);
}

void OutputRecord::write() const
{
    write_record(folder_ / file_name,
                 Value::Map{{"format", "fresco-outputs"}, {"files", Value::Map(entries_.begin(), entries_.end())}});
}

Value OutputRecord::identity(const OutputOwner& owner) const
{
    const fs::path from_here = resolved(owner.pipeline).lexically_relative(resolved(folder_));
    return Value::Map{{"pipeline", from_here.generic_string()},
                      {"combination", owner.combination},
                      {"stage", owner.stage},
                      {"output", owner.output}};
}

std::string OutputRecord::obstacle(const std::string& name, const OutputOwner& owner, FileHashes& hashes) const
{
    const fs::path file = folder_ / name;
    if (!path_status(file))
        return "";
    const auto found = entries_.find(name);
    if (found == entries_.end() || !is_file(file))
        return is_folder(file) ? "is a folder in place of a file" : "is not in fresco's record of this folder";
    const Value& entry = found->second;
    const Value own = identity(owner);
    const bool is_report = owner.stage.empty() && entry.at("stage").as_string().empty();
    if (!is_report && !(entry.at("pipeline") == own.at("pipeline")))
        return "was written by another pipeline, " + resolved(folder_ / entry.at("pipeline").as_string()).string();
    if (!is_report && !(entry.at("combination") == own.at("combination")))
        return "was written by another combination, '" + entry.at("combination").as_string() + "'";
    if (is_unfinished(name))
        return "";
    const std::string now = attempt([&] { return hashes.hash(file); }).value_or("");
    if (now.empty())
        return "cannot be read, so fresco cannot tell whether it changed";
    return now == entry.at("hash").as_string() || now == entry.at("before").as_string() ? "" : "changed since fresco wrote it";
}

bool OutputRecord::is_unfinished(const std::string& name) const
{
    const auto found = entries_.find(name);
    return found != entries_.end() && found->second.at("hash").as_string().empty();
}

void OutputRecord::note(const std::vector<NewFile>& files, const OutputOwner& owner, FileHashes* hashes)
{
    read();
    for (const NewFile& file : files)
    {
        const fs::path path = folder_ / file.name;
        const bool replaces_own = hashes != nullptr && is_file(path) && obstacle(file.name, owner, *hashes).empty();
        Value entry = identity(owner);
        entry.set("before", replaces_own ? hashes->hash(path) : "");
        entry.set("hash", file.hash);
        entries_.insert_or_assign(file.name, std::move(entry));
    }
    write();
}

std::vector<std::string> OutputRecord::names_of(const OutputOwner& owner) const
{
    const Value own = identity(owner);
    std::vector<std::string> names;
    for (const auto& [name, entry] : entries_)
        if (std::ranges::all_of(own.as_map(), [&](const auto& part) { return entry.at(part.first) == part.second; }))
            names.push_back(name);
    return names;
}

void OutputRecord::forget(const std::vector<std::string>& names)
{
    read();
    for (const std::string& name : names)
        entries_.erase(name);
    write();
}

void refuse_obstacles(const std::vector<std::string>& obstacles)
{
    constexpr std::size_t shown = 8;
    if (obstacles.empty())
        return;
    std::string text = obstacles.front();
    for (std::size_t i = 1; i < std::min(obstacles.size(), shown); ++i)
        text += "\n  " + obstacles[i];
    if (obstacles.size() > shown)
        text += "\n  and " + counted(obstacles.size() - shown, "more file");
    throw Error(text);
}

}  // namespace fresco::host
