#include "base/chunk_hash.h"
#include "base/common.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace fresco::host
{

StoredFile hash_chunks(const std::filesystem::path& root, const std::string& relative_path)
{
    const std::filesystem::path file = root / relative_path;
    const FileDescriptor fd = open_file(file, O_RDONLY | O_NOFOLLOW);
    if (!fd.valid())
        throw Error(file.string() + ": cannot be opened: " + std::strerror(errno));
    struct stat status = {};
    if (fstat(fd.get(), &status) != 0 || !S_ISREG(status.st_mode))
        throw Error(file.string() + ": is not a regular file");
    std::vector<std::byte> buffer(std::min<std::uint64_t>(chunk_bytes, static_cast<std::uint64_t>(status.st_size) + 1));
    StoredFile result{relative_path, 0, {}};
    std::size_t filled = 0;
    do
    {
        filled = 0;
        for (ssize_t count = 1; count > 0 && filled < buffer.size(); filled += static_cast<std::size_t>(count))
        {
            count = uninterrupted([&] { return read(fd.get(), buffer.data() + filled, buffer.size() - filled); });
            if (count < 0)
                throw Error(file.string() + ": cannot be read at byte " + std::to_string(result.size + filled) + ": " +
                            std::strerror(errno));
        }
        result.size += filled;
        if (filled > 0 || result.chunks.empty())
            result.chunks.push_back(content_hash(std::span<const std::byte>(buffer.data(), filled)));
    } while (filled == buffer.size());
    return result;
}

std::optional<std::string> find_damage(const std::filesystem::path& root, const StoredFile& expected)
{
    const std::filesystem::path file = root / expected.path;
    std::error_code error;
    const auto size = std::filesystem::file_size(file, error);
    if (error)
        return file.string() + ": " + error.message();
    if (size != expected.size)
        return file.string() + ": has " + std::to_string(size) + " bytes, " + std::to_string(expected.size) + " were written";
    try
    {
        const StoredFile found = hash_chunks(root, expected.path);
        const auto damaged = std::ranges::mismatch(found.chunks, expected.chunks).in1;
        if (damaged == found.chunks.end())
            return std::nullopt;
        return file.string() + ": the bytes from " +
               std::to_string(static_cast<std::size_t>(damaged - found.chunks.begin()) * chunk_bytes) +
               " on are not those that were written";
    }
    catch (const Error& failure)
    {
        return failure.what();
    }
}

Value to_value(const StoredFile& file)
{
    Value::List chunks(file.chunks.begin(), file.chunks.end());
    return Value::List{file.path, file.size, std::move(chunks)};
}

StoredFile stored_file_from(const Value& value)
{
    const auto& list = value.as_list();
    if (list.size() != 3)
        throw Error("a stored file has 3 entries, this one " + std::to_string(list.size()));
    return {list[0].as_string(), static_cast<std::uint64_t>(list[1].as_int()), each(list[2].as_list(), &Value::as_string)};
}

}  // namespace fresco::host
