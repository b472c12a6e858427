#include "formats.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <numbers>
#include <numeric>

namespace fresco::splats
{
namespace
{

constexpr std::string_view magic = "NGSP";
constexpr std::size_t legacy_header = 16;
constexpr std::size_t header = 32;
constexpr std::size_t table_entry = 16;
constexpr double color_scale = 0.15;

[[noreturn]] void refuse(const std::string& source, const std::string& what)
{
    throw Error(fmt::format("{}: {}; not a whole SPZ file: copy or download it again", source, what));
}

/// Unpacks gzip until `most` bytes or its end.
std::vector<std::byte> inflated(Bytes packed, std::size_t most, const std::string& source)
{
    std::vector<std::byte> result;
    z_stream stream{};
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
    constexpr int gzip = 16;
    int code = inflateInit2(&stream, gzip + MAX_WBITS);
    // Its counters have 32 bits.
    constexpr std::size_t step = std::size_t{1} << 30U;
    std::size_t taken = 0;
    std::size_t made = 0;
    while (code == Z_OK && made < most)
    {
        constexpr std::size_t least_room = 65536;
        // A header may claim more than there is: room is made for twice as much as was unpacked.
        if (made == result.size())
            result.resize(std::min(most, std::max(2 * made, least_room)));
        const std::size_t in = std::min(packed.size() - taken, step);
        const std::size_t room = std::min(result.size() - made, step);
        stream.avail_in = static_cast<uInt>(in);
        stream.next_out = reinterpret_cast<Bytef*>(result.data() + made);
        stream.avail_out = static_cast<uInt>(room);
        code = inflate(&stream, Z_NO_FLUSH);
        taken += in - stream.avail_in;
        made += room - stream.avail_out;
    }
    inflateEnd(&stream);
    if (code != Z_OK && code != Z_STREAM_END)
        refuse(source, fmt::format("its gzip data is damaged or cut short behind {} bytes", taken));
    result.resize(made);
    return result;
}

std::vector<std::byte> deflated(Bytes plain)
{
    constexpr int gzip = 16;
    constexpr int memory_level = 9;
    z_stream stream{};
    if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, gzip + MAX_WBITS, memory_level, Z_DEFAULT_STRATEGY) != Z_OK)
        throw Error("zlib cannot start: out of memory");
    std::vector<std::byte> result(deflateBound(&stream, plain.size()));
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(plain.data()));
    stream.next_out = reinterpret_cast<Bytef*>(result.data());
    int code = Z_OK;
    while (code == Z_OK)
    {
        // Its counters have 32 bits.
        constexpr std::size_t step = std::size_t{1} << 30U;
        const std::size_t left = plain.size() - stream.total_in;
        stream.avail_in = static_cast<uInt>(std::min(left, step));
        stream.avail_out = static_cast<uInt>(std::min(result.size() - stream.total_out, step));
        code = deflate(&stream, left <= step ? Z_FINISH : Z_NO_FLUSH);
    }
    result.resize(stream.total_out);
    deflateEnd(&stream);
    return result;
}

void inflate_frame(Bytes frame, std::size_t bytes, std::vector<std::byte>& result, const std::string& source)
{
    result.resize(bytes);
    const std::size_t made = ZSTD_decompress(result.data(), bytes, frame.data(), frame.size());
    if (ZSTD_isError(made) != 0 || made != bytes)
        refuse(source, "one of its zstd streams is damaged");
}

/// The contents without streams. `file_bytes`: what they may be packed into.
SpzContents begun(Bytes start, std::size_t file_bytes, const std::string& source)
{
    SpzContents spz;
    spz.version = static_cast<int>(value_at<std::uint32_t>(start, 4));
    spz.count = value_at<std::uint32_t>(start, 8);
    spz.degree = value_at<std::uint8_t>(start, 12);
    spz.fraction_bits = value_at<std::uint8_t>(start, 13);
    spz.flags = value_at<std::uint8_t>(start, 14);
    if (spz.version < 2 || spz.version > 4)
        throw Error(fmt::format("{}: is SPZ {}; fresco reads 2, 3 and 4; \"spz_to_ply IN.spz OUT.ply\", which comes with "
                                "Niantic's spz, makes a PLY of it",
                                source, spz.version));
    if (spz.degree > 4 || spz.fraction_bits > 24)
        refuse(source, fmt::format("its header has harmonics of degree {} and {} bits of fractions; expected at most 4 and 24",
                                   spz.degree, spz.fraction_bits));
    // No scene that anybody trained packs this well; a header that claims more is made up.
    constexpr std::size_t most_ratio = 200;
    if (spz.count == 0 || spz.count > (file_bytes + 4096) * most_ratio / spz.bytes_per_gaussian())
        refuse(source, fmt::format("its {} bytes cannot hold the {} Gaussians that its header claims", file_bytes, spz.count));
    return spz;
}

SpzContents unpacked_legacy(Bytes bytes, const std::string& source)
{
    const bool is_packed = value_at<std::uint16_t>(bytes, 0) == 0x8b1f;
    const auto take = [&](std::size_t most)
    {
        const Bytes begin = bytes.first(std::min(most, bytes.size()));
        return is_packed ? inflated(bytes, most, source) : std::vector<std::byte>(begin.begin(), begin.end());
    };
    const auto start = take(legacy_header);
    if (start.size() < legacy_header || std::memcmp(start.data(), magic.data(), magic.size()) != 0)
        throw Error(source + ": its gzip data doesn't hold SPZ; unpack other files first");
    SpzContents spz = begun(start, bytes.size(), source);
    const auto row = spz.row_bytes();
    constexpr std::size_t most_extra = 65536;
    const std::size_t least_bytes = legacy_header + spz.count * spz.bytes_per_gaussian(), most_bytes = least_bytes + most_extra;
    const auto plain = take(most_bytes + 1);
    if (plain.size() > most_bytes)
        refuse(source, "more than 64 KiB stand behind its Gaussians");
    if (plain.size() < least_bytes)
        refuse(source, fmt::format("its {} Gaussians end behind {} bytes", spz.count, plain.size()));
    auto at = plain.begin() + legacy_header;
    for (std::size_t k = 0; k < row.size(); ++k)
    {
        const auto end = at + static_cast<std::ptrdiff_t>(spz.count * row[k]);
        spz.streams[k].assign(at, end);
        at = end;
    }
    spz.extensions.assign(at, plain.end());
    return spz;
}

SpzContents unpacked_ngsp(Bytes bytes, const std::string& source)
{
    SpzContents spz = begun(bytes, bytes.size(), source);
    const auto row = spz.row_bytes();
    const std::size_t streams = value_at<std::uint8_t>(bytes, 15);
    const std::size_t table = value_at<std::uint32_t>(bytes, 16);
    if (streams != (spz.degree > 0 ? 6U : 5U) || table < header || table > bytes.size() ||
        streams * table_entry > bytes.size() - table)
        refuse(source, fmt::format("its table of {} streams at byte {} is missing", streams, table));
    std::size_t at = table + streams * table_entry;
    for (std::size_t k = 0; k < streams; ++k)
    {
        const auto packed = value_at<std::uint64_t>(bytes, table + k * table_entry);
        const auto plain = value_at<std::uint64_t>(bytes, table + k * table_entry + 8);
        if (packed > bytes.size() - at || plain != spz.count * row[k])
            refuse(source, fmt::format("its stream {} is cut short or has another size than its Gaussians", k));
        inflate_frame(bytes.subspan(at, packed), plain, spz.streams[k], source);
        at += packed;
    }
    spz.extensions.assign(bytes.begin() + header, bytes.begin() + static_cast<std::ptrdiff_t>(table));
    return spz;
}

/// The number of the largest component of x, y, z, w, and the others from the first in ten bits each, the sign before the size.
std::array<double, 4> rotation_of_smallest(std::uint32_t packed)
{
    const auto component = [&](unsigned shift)
    {
        const double size = (packed >> shift & 511U) * (std::numbers::sqrt2 / 2 / 511);
        return (packed >> shift >> 9U & 1U) != 0 ? -size : size;
    };
    const auto [x, y, z, w] = completed({component(20), component(10), component(0)}, packed >> 30U);
    return {w, x, y, z};
}

std::uint32_t smallest_of(const std::array<float, 4>& rotation)
{
    std::size_t largest = 0;  // Counted x, y, z, w.
    const auto at = [&](std::size_t k) { return static_cast<double>(rotation[(k + 1) % 4]); };
    for (std::size_t k = 1; k < 4; ++k)
        if (std::abs(at(k)) > std::abs(at(largest)))
            largest = k;
    auto packed = static_cast<std::uint32_t>(largest);
    for (std::size_t k = 0; k < 4; ++k)
        if (k != largest)
        {
            const auto size =
                static_cast<std::uint32_t>(std::min(511.0, std::round(511 * std::numbers::sqrt2 * std::abs(at(k)))));
            packed = packed << 10U | ((at(k) < 0) != (at(largest) < 0) ? 512U : 0U) | size;
        }
    return packed;
}

std::byte rounded(double value)
{
    return static_cast<std::byte>(std::lround(std::clamp(value, 0.0, 255.0)));
}

}  // namespace

std::array<std::size_t, 6> SpzContents::row_bytes() const
{
    return {9, 1, 3, 3, version == 2 ? 3U : 4U, 3 * coefficients_of(degree)};
}

std::size_t SpzContents::bytes_per_gaussian() const
{
    const auto row = row_bytes();
    return std::accumulate(row.begin(), row.end(), std::size_t{0});
}

void SpzContents::put(std::size_t i, Vec3f center, Vec3f scale, double opacity)
{
    constexpr double most = 8388607;
    const std::array<float, 3> place{center.x, center.y, center.z};
    const std::array<float, 3> size{scale.x, scale.y, scale.z};
    for (std::size_t k = 0; k < 3; ++k)
    {
        const auto fixed = static_cast<std::int32_t>(
            std::lround(std::clamp(std::ldexp(static_cast<double>(place[k]), fraction_bits), -most, most)));
        std::memcpy(streams[positions].data() + 9 * i + 3 * k, &fixed, 3);
        streams[scales][3 * i + k] = rounded(16 * (std::log(static_cast<double>(size[k])) + 10));
    }
    streams[opacities][i] = rounded(255 * opacity);
}

void SpzContents::put_color(std::size_t i, Vec3f color)
{
    const std::array<float, 3> rgb{color.x, color.y, color.z};
    for (std::size_t k = 0; k < 3; ++k)
        streams[colors][3 * i + k] = rounded(255 * ((static_cast<double>(rgb[k]) - 0.5) / harmonic_0 * color_scale + 0.5));
}

SpzContents spz_of(const Splats& splats)
{
    double largest = 1;
    for (const Vec3f c : splats.centers)
        largest = std::max({largest, std::abs(double{c.x}), std::abs(double{c.y}), std::abs(double{c.z})});
    SpzContents spz;
    spz.version = 3;
    spz.count = splats.size();
    constexpr int usual_bits = 16;
    spz.fraction_bits = std::clamp(22 - std::ilogb(largest), 0, usual_bits);
    std::vector<float> sizes;
    for (const Vec3f size : splats.scales)
        sizes.push_back(std::max({size.x, size.y, size.z}));
    std::ranges::nth_element(sizes, sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2));
    if (largest >= std::ldexp(1.0, 23) ||
        (!sizes.empty() && std::ldexp(1.0, -spz.fraction_bits) > double{sizes[sizes.size() / 2]}))
        throw Error(
            "SPZ cannot hold these splats: they are so far from 0 that its steps are larger than most of them; set format: ply");
    const auto row = spz.row_bytes();
    for (std::size_t k = 0; k < row.size(); ++k)
        spz.streams[k].resize(spz.count * row[k]);
    for (std::size_t i = 0; i < spz.count; ++i)
    {
        spz.put(i, splats.centers[i], splats.scales[i], double{splats.opacities[i]});
        spz.put_color(i, splats.colors[i]);
        const std::uint32_t packed = smallest_of(splats.rotations[i]);
        std::memcpy(spz.streams[SpzContents::rotations].data() + 4 * i, &packed, sizeof packed);
    }
    return spz;
}

bool is_spz(Bytes bytes)
{
    // A gzip file begins with its mark, its only method, and flags of which three bits are reserved.
    return bytes.size() >= legacy_header && ((value_at<std::uint32_t>(bytes, 0) & 0xe0ffffffU) == 0x00088b1f ||
                                             std::memcmp(bytes.data(), magic.data(), magic.size()) == 0);
}

SpzContents unpacked_spz(Bytes bytes, const std::string& source)
{
    const bool is_plain = std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
    if (!is_plain || value_at<std::uint32_t>(bytes, 4) < 4)
        return unpacked_legacy(bytes, source);
    if (bytes.size() < header)
        refuse(source, "its header is cut short");
    return unpacked_ngsp(bytes, source);
}

std::vector<std::byte> packed_spz(const SpzContents& spz)
{
    std::string start(magic);
    const auto put = [&](std::uint64_t number, std::size_t bytes)
    { start.append(reinterpret_cast<const char*>(&number), bytes); };
    const bool is_ngsp = spz.version >= 4;
    const std::size_t streams = spz.degree > 0 ? 6 : 5;
    put(static_cast<std::uint64_t>(spz.version), 4);
    put(spz.count, 4);
    put(static_cast<std::uint64_t>(spz.degree), 1);
    put(static_cast<std::uint64_t>(spz.fraction_bits), 1);
    put(spz.flags, 1);
    put(is_ngsp ? streams : 0, 1);
    std::vector<std::byte> result;
    const auto append = [&](const void* data, std::size_t bytes)
    { result.insert(result.end(), static_cast<const std::byte*>(data), static_cast<const std::byte*>(data) + bytes); };
    if (is_ngsp)
    {
        put(header + spz.extensions.size(), 4);
        start.resize(header);
        start.append(reinterpret_cast<const char*>(spz.extensions.data()), spz.extensions.size());
        constexpr int level = 12;
        std::vector<std::vector<std::byte>> frames(streams);
        for (std::size_t k = 0; k < streams; ++k)
        {
            frames[k].resize(ZSTD_compressBound(spz.streams[k].size()));
            frames[k].resize(
                ZSTD_compress(frames[k].data(), frames[k].size(), spz.streams[k].data(), spz.streams[k].size(), level));
            put(frames[k].size(), 8);
            put(spz.streams[k].size(), 8);
        }
        append(start.data(), start.size());
        for (const auto& frame : frames)
            append(frame.data(), frame.size());
        return result;
    }
    append(start.data(), start.size());
    for (const auto& stream : spz.streams)
        append(stream.data(), stream.size());
    append(spz.extensions.data(), spz.extensions.size());
    return deflated(result);
}

SplatFile parse_spz(Bytes bytes, const std::string& source)
{
    const SpzContents spz = unpacked_spz(bytes, source);
    SplatFile file;
    file.format = SplatFormat::spz;
    resize(file.splats, spz.count);
    const auto number = [&](SpzContents::Stream stream, std::size_t at)
    { return static_cast<double>(std::to_integer<int>(spz.streams[stream][at])); };
    for (std::size_t i = 0; i < spz.count; ++i)
    {
        std::array<float, 3> center{};
        for (std::size_t k = 0; k < 3; ++k)
        {
            std::uint32_t fixed = 0;
            std::memcpy(&fixed, spz.streams[SpzContents::positions].data() + 9 * i + 3 * k, 3);
            center[k] = static_cast<float>(std::ldexp(static_cast<std::int32_t>(fixed << 8U) >> 8U, -spz.fraction_bits));
        }
        const auto vector = [&](SpzContents::Stream stream) {
            return Vec3d{number(stream, 3 * i), number(stream, 3 * i + 1), number(stream, 3 * i + 2)};
        };
        const Vec3d color = (vector(SpzContents::colors) * (1 / 255.0) - Vec3d{0.5, 0.5, 0.5}) * (harmonic_0 / color_scale) +
                            Vec3d{0.5, 0.5, 0.5};
        const auto& turns = spz.streams[SpzContents::rotations];
        const auto turned = [&](std::size_t k) { return number(SpzContents::rotations, 3 * i + k) / 127.5 - 1; };
        const auto rotation = spz.version == 2 ? completed({turned(0), turned(1), turned(2)}, 0)
                                               : rotation_of_smallest(value_at<std::uint32_t>(turns, 4 * i));
        set(file.splats, i, {center[0], center[1], center[2]}, rotation,
            vector(SpzContents::scales) * (1 / 16.0) - Vec3d{10, 10, 10}, number(SpzContents::opacities, i) / 255,
            vec_cast<float>(color), source);
    }
    return file;
}

}  // namespace fresco::splats
