#include <fresco/recordings/byte_cursor.h>

#include <fresco/error.h>

#include <algorithm>

namespace fresco::recordings
{

std::string ByteCursor::place() const
{
    return source_ + ": byte " + std::to_string(offset_);
}

std::span<const std::byte> ByteCursor::take(std::uint64_t count, std::string_view what)
{
    if (count > left())
        throw Error(place() + ": the file ends inside " + std::string(what) + " (" + std::to_string(count) + " bytes, " +
                    std::to_string(left()) + " remain): it is truncated or damaged; copy it again");
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
        throw Error(place() + ": " + std::to_string(left()) +
                    " bytes after the expected end: the file is damaged; copy it again");
}

}  // namespace fresco::recordings
