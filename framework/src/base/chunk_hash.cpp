#include "base/chunk_hash.h"
#include "base/process.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <functional>
#include <sys/stat.h>
#include <unistd.h>

namespace fresco::host
{
namespace
{

/// Calls `piece(index, hash)` for each piece until it returns false; gives the bytes read. Throws Error if reading fails.
std::uint64_t for_each_chunk(const std::filesystem::path& file, const std::function<bool(std::size_t, std::string)>& piece)
{
    const FileDescriptor fd = open_file(file, O_RDONLY | O_NOFOLLOW);
    if (!fd.valid())
        throw Error(file.string() + ": cannot be opened: " + std::strerror(errno));
    struct stat status = {};
    if (fstat(fd.get(), &status) != 0 || !S_ISREG(status.st_mode))
        throw Error(file.string() + ": is not a regular file");
    std::vector<std::byte> buffer(std::min<std::uint64_t>(chunk_bytes, static_cast<std::uint64_t>(status.st_size) + 1));
    std::uint64_t total = 0;
    for (std::size_t index = 0;; ++index)
    {
        std::size_t filled = 0;
        while (filled < buffer.size())
        {
            const ssize_t count = uninterrupted([&] { return read(fd.get(), buffer.data() + filled, buffer.size() - filled); });
            if (count < 0)
                throw Error(file.string() + ": cannot be read at byte " + std::to_string(total + filled) + ": " +
                            std::strerror(errno));
            if (count == 0)
                break;
            filled += static_cast<std::size_t>(count);
        }
        if (filled == 0 && index > 0)
            return total;
        total += filled;
        if (!piece(index, content_hash(std::span<const std::byte>(buffer.data(), filled))) || filled < buffer.size())
            return total;
    }
}

}  // namespace

StoredFile hash_chunks(const std::filesystem::path& root, const std::string& relative_path)
{
    StoredFile file;
    file.path = relative_path;
    file.size = for_each_chunk(root / relative_path,
                               [&](std::size_t, std::string hash)
                               {
                                   file.chunks.push_back(std::move(hash));
                                   return true;
                               });
    return file;
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
    std::optional<std::string> damage;
    try
    {
        for_each_chunk(file,
                       [&](std::size_t index, const std::string& hash)
                       {
                           if (index < expected.chunks.size() && hash == expected.chunks[index])
                               return true;
                           damage = file.string() + ": the bytes from " + std::to_string(index * chunk_bytes) +
                                    " on are not those that were written";
                           return false;
                       });
    }
    catch (const Error& failure)
    {
        damage = failure.what();
    }
    return damage;
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
    StoredFile file;
    file.path = list[0].as_string();
    file.size = static_cast<std::uint64_t>(list[1].as_int());
    for (const auto& chunk : list[2].as_list())
        file.chunks.push_back(chunk.as_string());
    return file;
}

}  // namespace fresco::host
