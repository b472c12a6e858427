#include "sens_depth.h"

#include <fresco/error.h>

#include <bit>
#include <fmt/format.h>
#include <limits>
#include <zlib.h>

namespace sens
{

fresco::Raster16 unpack_depth(std::span<const std::byte> packed, int width, int height, const std::string& place)
{
    static_assert(std::endian::native == std::endian::little);
    const std::size_t expected = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * sizeof(std::uint16_t);
    const auto fail = [&](const std::string& what)
    {
        throw fresco::Error(
            fmt::format("{}: {}; expected a zlib-compressed depth picture of {} bytes: the file is damaged; copy it again", place,
                        what, expected));
    };
    if (packed.size() > std::numeric_limits<uInt>::max() || expected > std::numeric_limits<uInt>::max())
        fail("more than 4 GiB");
    // Deflate makes nothing more than 1032 times smaller: what cannot be whole takes no memory.
    if (packed.size() < expected / 1032)
        fail(fmt::format("{} packed bytes", packed.size()));
    fresco::Raster16 depth(width, height);
    z_stream stream = {};
    if (::inflateInit(&stream) != Z_OK)
        throw fresco::Error(place + ": zlib cannot start: out of memory");
    // zlib's interface is not const; it does not write there.
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(depth.values.data());
    stream.avail_out = static_cast<uInt>(expected);
    const int code = ::inflate(&stream, Z_FINISH);
    const std::size_t made = expected - stream.avail_out;
    ::inflateEnd(&stream);
    if (code != Z_STREAM_END)
        fail(code == Z_BUF_ERROR && made == expected ? "more" : "damaged data");
    if (made != expected)
        fail(fmt::format("{} bytes", made));
    return depth;
}

}  // namespace sens
