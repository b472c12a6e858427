#include "checkpoint.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <cstring>

namespace fresco::synthesize
{
namespace
{

static_assert(sizeof(Match) == 32);

/// Header of the file, little-endian like the rest.
struct Header
{
    std::int64_t level = 0;
    std::int64_t rounds = 0;
    std::uint64_t matches = 0;
    std::uint64_t crowding = 0;
};

}  // namespace

void write_checkpoint(const std::filesystem::path& file, const Checkpoint& checkpoint)
{
    const Header header{checkpoint.level, checkpoint.rounds, checkpoint.matches.size(), checkpoint.crowding.size()};
    const std::size_t matches_bytes = checkpoint.matches.size() * sizeof(Match);
    const std::size_t crowding_bytes = checkpoint.crowding.size() * sizeof(float);
    std::vector<std::byte> bytes(sizeof header + matches_bytes + crowding_bytes);
    std::byte* at = bytes.data();
    const auto put = [&at](const void* from, std::size_t count)
    {
        if (count > 0)
            std::memcpy(at, from, count);
        at += count;
    };
    put(&header, sizeof header);
    put(checkpoint.matches.data(), matches_bytes);
    put(checkpoint.crowding.data(), crowding_bytes);
    write_checked(file, bytes);
}

std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& file)
{
    if (!path_status(file))
        return std::nullopt;
    const std::vector<std::byte> bytes = read_checked(file);
    const Error damaged(file.string() + ": damaged");
    Header header;
    if (bytes.size() < sizeof header)
        throw damaged;
    const std::byte* at = bytes.data();
    std::memcpy(&header, at, sizeof header);
    at += sizeof header;
    const auto rest = static_cast<std::size_t>(bytes.data() + bytes.size() - at);
    if (header.matches > rest || header.crowding > rest ||
        header.matches * sizeof(Match) + header.crowding * sizeof(float) != rest)
        throw damaged;
    Checkpoint result{static_cast<int>(header.level), static_cast<int>(header.rounds), {}, {}};
    const auto take = [&at](auto& values, std::size_t count)
    {
        values.resize(count);
        const std::size_t size = count * sizeof values[0];
        if (size > 0)
            std::memcpy(values.data(), at, size);
        at += size;
    };
    take(result.matches, header.matches);
    take(result.crowding, header.crowding);
    return result;
}

}  // namespace fresco::synthesize
