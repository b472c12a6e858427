#include "base/durable_file.h"
#include "base/process.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>
#include <fresco/retry.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <unistd.h>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

constexpr std::string_view checksum_begin = ",\"checksum\":\"";
constexpr std::string_view checksum_end = "\"}\n";
constexpr std::size_t checksum_digits = 32;

}  // namespace

std::string checked_line(const Value& map)
{
    std::string text = to_json(map);
    text.pop_back();
    const std::string checksum = content_hash(text);
    return text.append(checksum_begin).append(checksum).append(checksum_end);
}

std::optional<Value> map_of(std::string_view checked_line)
{
    constexpr std::size_t added = checksum_begin.size() + checksum_digits + checksum_end.size();
    const std::size_t size = checked_line.size() - std::min(checked_line.size(), added);
    const std::string_view map = checked_line.substr(0, size);
    if (checked_line.substr(size) != std::string(checksum_begin) + content_hash(map) + std::string(checksum_end))
        return std::nullopt;
    return parse_json(checked_line, "record");
}

void sync_path(const fs::path& path)
{
    const FileDescriptor fd(uninterrupted([&] { return open(path.c_str(), O_RDONLY | O_CLOEXEC); }));
    if (!fd.valid() || uninterrupted([&] { return fsync(fd.get()); }) != 0)
        throw Error(path.string() + ": cannot be written to the disk: " + std::strerror(errno));
}

void make_folder(const fs::path& folder)
{
    std::error_code error;
    if (folder.empty() || fs::is_directory(folder, error))
        return;
    make_folder(folder.parent_path());
    fs::create_directory(folder, error);
    if (error)
        throw Error(folder.string() + ": cannot make the folder: " + error.message());
    sync_path(folder.has_parent_path() ? folder.parent_path() : ".");
}

void write_record(const fs::path& file, const Value& map)
{
    write_durable_file(file, checked_line(map));
}

Value read_record(const fs::path& file)
{
    const std::string text = read_text_file(file, std::size_t{1} << 30U);
    std::optional<Value> map = map_of(text);
    if (!map)
        throw Error(file.string() + ": is damaged: it does not fit its own checksum");
    return std::move(*map);
}

}  // namespace fresco::host
