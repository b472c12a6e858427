#include "base/records.h"
#include "base/common.h"
#include "base/file_lock.h"
#include "base/process.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>

namespace fresco::host
{
namespace
{

constexpr std::string_view checksum_begin = ",\"checksum\":\"";
constexpr std::string_view checksum_end = "\"}\n";
constexpr std::size_t checksum_digits = 32;
constexpr std::size_t size_limit = std::size_t{1} << 30U;

/// A map as one line of JSON, with the checksum of its text as the last entry, "checksum".
std::string checked_line(const Value& map)
{
    std::string text = to_json(map);
    text.pop_back();
    const std::string checksum = content_hash(text);
    return text.append(checksum_begin).append(checksum).append(checksum_end);
}

/// The map of such a line, with its checksum; nothing if it is damaged.
std::optional<Value> map_of(std::string_view checked_line)
{
    constexpr std::size_t added = checksum_begin.size() + checksum_digits + checksum_end.size();
    const std::size_t size = checked_line.size() - std::min(checked_line.size(), added);
    const std::string_view map = checked_line.substr(0, size);
    if (checked_line.substr(size) != std::string(checksum_begin) + content_hash(map) + std::string(checksum_end))
        return std::nullopt;
    return parse_json(checked_line, "record");
}

}  // namespace

void write_record(const fs::path& file, const Value& map)
{
    write_durable_file(file, checked_line(map));
}

Value read_record(const fs::path& file)
{
    const std::string text = read_text_file(file, size_limit);
    std::optional<Value> map = map_of(text);
    if (!map)
        throw Error(file.string() + ": is damaged: it does not fit its own checksum");
    return std::move(*map);
}

std::vector<Value> Journal::read() const
{
    std::vector<Value> maps;
    const std::string text = attempt([&] { return read_text_file(file_, size_limit); }).value_or("");
    for (std::size_t begin = 0; begin < text.size();)
    {
        const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
        if (auto map = map_of(std::string_view(text).substr(begin, end - begin)))
            maps.push_back(std::move(*map));
        begin = end;
    }
    return maps;
}

void Journal::add(const Value& map) const
{
    FileLock lock(file_);
    if (!lock.try_exclusive_for(std::chrono::seconds(2)))
        throw Error(file_.string() + ": others have held its lock for two seconds");
    // Opened once it is locked: only then does a network file system know where it ends.
    const FileDescriptor fd = open_file(file_, O_WRONLY | O_APPEND);
    // A process that was killed may have left a part of a line.
    if (!fd.valid() || !write_all(fd.get(), "\n" + checked_line(map)))
        throw Error(file_.string() + ": cannot be written: " + std::strerror(errno));
}

void Journal::replace(const std::vector<Value>& maps) const
{
    std::string text;
    for (const Value& map : maps)
        text += checked_line(map);
    FileLock lock(file_);
    if (!lock.try_exclusive())
        throw Error(file_.string() + ": another process is writing it");
    write_durable_file(file_, text);
}

}  // namespace fresco::host
