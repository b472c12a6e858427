#include <fresco/recordings/byte_cursor.h>

#include <fresco/error.h>

#include <algorithm>
#include <fmt/format.h>

namespace fresco::recordings
{

std::string ByteCursor::place() const
{
    return fmt::format("{}: byte {}", source_, offset_);
}

std::span<const std::byte> ByteCursor::take(std::uint64_t count, std::string_view what)
{
    if (count > left())
        throw Error(fmt::format("{}: the file ends inside {} ({} bytes, {} remain): it is truncated or damaged; copy it again",
                                place(), what, count, left()));
    const auto part = bytes_.subspan(offset_, static_cast<std::size_t>(count));
    offset_ += part.size();
    return part;
}

std::string_view ByteCursor::text(std::string_view what)
{
    const auto rest = bytes_.subspan(offset_);
    const auto end = std::find(rest.begin(), rest.end(), std::byte{0});
    if (end == rest.end())
        throw Error(place() + ": the file ends inside " + std::string(what) +
                    ", without a zero byte: it is truncated or damaged; copy it again");
    const auto size = static_cast<std::size_t>(end - rest.begin());
    offset_ += size + 1;
    return {reinterpret_cast<const char*>(rest.data()), size};
}

void ByteCursor::expect_end() const
{
    if (left() > 0)
        throw Error(fmt::format("{}: {} bytes after the expected end: the file is damaged; copy it again", place(), left()));
}

}  // namespace fresco::recordings
