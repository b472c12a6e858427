#include "checkpoint.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>

namespace fresco::synthesize
{
namespace
{

static_assert(sizeof(Match) == 32);

/// Level, rounds, and the counts of matches and of crowding, which follow; little-endian as they are.
using Header = std::array<std::int64_t, 4>;

}  // namespace

void write_checkpoint(const std::filesystem::path& file, const Checkpoint& checkpoint)
{
    std::vector<std::byte> bytes;
    const auto put = [&bytes](const auto& values)
    {
        const auto raw = std::as_bytes(std::span(values));
        bytes.insert(bytes.end(), raw.begin(), raw.end());
    };
    put(Header{checkpoint.level, checkpoint.rounds, std::ssize(checkpoint.matches), std::ssize(checkpoint.crowding)});
    put(checkpoint.matches);
    put(checkpoint.crowding);
    write_checked(file, bytes);
}

std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& file)
{
    if (!path_status(file))
        return std::nullopt;
    const std::vector<std::byte> bytes = read_checked(file);
    const Error damaged(file.string() + ": damaged");
    Header header{};
    if (bytes.size() < sizeof header)
        throw damaged;
    std::memcpy(header.data(), bytes.data(), sizeof header);
    const auto rest = std::span(bytes).subspan(sizeof header);
    const auto matches = static_cast<std::size_t>(header[2]);
    const auto crowding = static_cast<std::size_t>(header[3]);
    if (matches > rest.size() || crowding > rest.size() || matches * sizeof(Match) + crowding * sizeof(float) != rest.size())
        throw damaged;
    Checkpoint result{static_cast<int>(header[0]), static_cast<int>(header[1]), std::vector<Match>(matches),
                      std::vector<float>(crowding)};
    const auto middle = rest.begin() + static_cast<std::ptrdiff_t>(matches * sizeof(Match));
    std::copy(rest.begin(), middle, std::as_writable_bytes(std::span(result.matches)).begin());
    std::copy(middle, rest.end(), std::as_writable_bytes(std::span(result.crowding)).begin());
    return result;
}

}  // namespace fresco::synthesize
