#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/uv_maps.h>

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

namespace fresco
{
namespace
{

constexpr std::string_view magic = "FRESCOUV";
constexpr std::uint32_t form = 3;
constexpr float rounding = 1e-5F;
constexpr int cosine_bits = 8;
constexpr float most_steps_per_meter = 1000;
constexpr int depth_bits = 16;
constexpr int far_depth_bits = 22;
/// Most steps of depth: a float holds this many exactly, with bits to spare for rounding.
constexpr double most_steps = 2'097'152;
constexpr std::size_t most_pixels = std::size_t{1} << 28U;
/// Zstandard's smallest block, of 4 bytes, holds 128 KiB.
constexpr std::size_t most_packed = 32768;
/// Differences hardly repeat: searching longer for repetitions costs more than it saves.
constexpr int zstd_level = 1;

int last_step(int bits)
{
    return (1 << bits) - 1;
}

[[noreturn]] void fail(std::string_view source, std::size_t offset, std::string_view what)
{
    throw Error(fmt::format(
        "{}: offset {}: {}; the file is damaged: rerun the stage that wrote it ('fresco store verify' finds its result)", source,
        offset, what));
}

void check_begin(std::span<const std::byte> file, std::size_t header_bytes, std::string_view begin, std::string_view source)
{
    if (file.size() < header_bytes)
        fail(source, file.size(), fmt::format("ends within the header of {} bytes", header_bytes));
    if (std::memcmp(file.data(), begin.data(), begin.size()) != 0)
        fail(source, 0, fmt::format("expected \"{}\"", begin));
}

/// The 36 bytes before the frame; little-endian numbers.
struct Header
{
    static constexpr std::size_t bytes = 36;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t uv_bits = 0;
    std::uint32_t depth_bits = 0;
    float steps_per_meter = 0;

    std::size_t pixels() const { return std::size_t{width} * height; }
    /// Bytes of the frame: the mask, and a plane for each byte of each quantity's numbers.
    std::size_t content_bytes() const
    {
        return (pixels() + 7) / 8 + pixels() * (2 * planes(uv_bits) + planes(cosine_bits) + planes(depth_bits));
    }
    static std::size_t planes(std::uint32_t bits) { return (bits + 7) / 8; }

    void write(std::span<std::byte> file) const
    {
        const std::array<std::uint32_t, 6> numbers{form,    width,      height,
                                                   uv_bits, depth_bits, std::bit_cast<std::uint32_t>(steps_per_meter)};
        std::memcpy(file.data(), magic.data(), magic.size());
        std::memcpy(file.data() + 8, numbers.data(), sizeof numbers);
        const std::uint32_t sum = checksum(file);
        std::memcpy(file.data() + 32, &sum, sizeof sum);
    }

    static Header read(std::span<const std::byte> file, std::string_view source)
    {
        static_assert(std::endian::native == std::endian::little);
        check_begin(file, bytes, magic, source);
        std::array<std::uint32_t, 7> numbers{};
        std::memcpy(numbers.data(), file.data() + 8, sizeof numbers);
        if (numbers[0] != form)
            fail(source, 8, fmt::format("expected form {}, got {}", form, numbers[0]));
        if (numbers[6] != checksum(file))
            fail(source, 32, "the header's checksum is wrong");
        const Header header{numbers[1], numbers[2], numbers[3], numbers[4], std::bit_cast<float>(numbers[5])};
        if (header.uv_bits < min_uv_bits || header.uv_bits > max_uv_bits ||
            (header.depth_bits != fresco::depth_bits && header.depth_bits != far_depth_bits))
            fail(source, 20, "expected 16 to 22 bits of texcoords, 16 or 22 of depth");
        // Too few would make infinite depths of sound steps.
        if (!(header.steps_per_meter > 0 && header.steps_per_meter <= most_steps_per_meter) ||
            !std::isfinite(4194303.0F / header.steps_per_meter))
            fail(source, 28, "expected steps of depth per meter above 0 and at most 1000");
        if (header.pixels() < 1 || header.pixels() > most_pixels)
            fail(source, 12, fmt::format("expected 1 to {} pixels, got {}x{}", most_pixels, header.width, header.height));
        return header;
    }

  private:
    static std::uint32_t checksum(std::span<const std::byte> file)
    {
        return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(file.data()), 32));
    }
};

/// The nearest whole number, of numbers from 0 on.
std::uint32_t rounded(double number)
{
    // lround is not vectorized; the last bit, in which they may differ, counts nothing here.
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(number + 0.5));  // NOLINT(bugprone-incorrect-roundings)
}

/// A value of [0,1] in steps; 1e-5 beyond is taken for 0 or 1.
std::uint32_t share_step(float value, int last)
{
    return rounded(static_cast<double>(std::min(std::max(value, 0.0F), 1.0F)) * last);
}

/// Calls check(value) for every valid pixel's values, and throws Error naming the first pixel for which it is false.
template <class Check>
void check_values(const RasterF& raster, const Raster8& valid, std::string_view what, std::string_view expected,
                  std::string_view source, const Check& check)
{
    const auto channels = static_cast<std::size_t>(raster.channels);
    const auto width = static_cast<std::size_t>(raster.width);
    for (std::size_t pixel = 0; pixel < valid.values.size(); ++pixel)
        for (std::size_t i = pixel * channels; valid.values[pixel] != 0 && i < (pixel + 1) * channels; ++i)
            if (!check(raster.values[i]))
                throw Error(fmt::format("{}: {}: pixel ({}, {}) holds {:f}; expected {}", source, what, pixel % width,
                                        pixel / width, raster.values[i], expected));
}

void check_map(const UvMap& map, std::string_view source)
{
    const auto check_size = [&](const auto& raster, int channels, const char* what)
    {
        if (raster.width != map.valid.width || raster.height != map.valid.height || raster.channels != channels)
            throw Error(fmt::format("{}: {}: is {}x{}x{}; expected {}x{}x{}, as the validity has it", source, what, raster.width,
                                    raster.height, raster.channels, map.valid.width, map.valid.height, channels));
    };
    check_size(map.valid, 1, "validity");
    check_size(map.uv, 2, "uv");
    check_size(map.depth, 1, "depth");
    check_size(map.cosine, 1, "cosine");
    if (map.valid.empty() || map.valid.values.size() > most_pixels)
        throw Error(fmt::format("{}: expected 1 to {} pixels, got {}", source, most_pixels, map.valid.values.size()));
    const auto is_share = [](float value) { return value >= -rounding && value <= 1 + rounding; };
    check_values(map.uv, map.valid, "uv", "a number from 0 to 1", source, is_share);
    check_values(map.cosine, map.valid, "cosine", "a number from 0 to 1", source, is_share);
    check_values(map.depth, map.valid, "depth", "a distance in meters", source,
                 [](float value) { return value >= 0 && std::isfinite(value); });
}

/// A quantity's numbers as planes of bytes, the lowest first. Each is the difference of a pixel's steps from those of the pixel
/// to its left, minus the same difference in the row above: on a flat wall 0. Loop by loop over a row, so that the compiler may
/// vectorize them. `step_of`: the steps of pixel i.
template <class StepOf>
void put_planes(std::vector<std::uint8_t>& content, std::size_t width, std::size_t pixels, int bits, const StepOf& step_of)
{
    const std::size_t planes = Header::planes(static_cast<std::uint32_t>(bits));
    const std::size_t begin = content.size();
    content.resize(begin + planes * pixels);
    std::uint8_t* out = content.data() + begin;
    std::vector<std::uint32_t> above(width);
    std::vector<std::uint32_t> numbers(width);
    std::vector<std::uint32_t> steps(width + 1);
    const int unused = 32 - bits;
    for (std::size_t row = 0; row < pixels; row += width, out += width)
    {
        for (std::size_t x = 0; x < width; ++x)
            steps[x + 1] = step_of(row + x);
        for (std::size_t x = 0; x < width; ++x)
        {
            const std::uint32_t across = steps[x + 1] - steps[x];
            // 0, -1, 1, -2, 2 … as 0, 1, 2, 3, 4 …, counting modulo 2^bits.
            const auto difference = static_cast<std::int32_t>((across - above[x]) << unused) >> unused;
            numbers[x] = static_cast<std::uint32_t>(difference) << 1U ^ static_cast<std::uint32_t>(difference >> 31);
            above[x] = across;
        }
        for (std::size_t plane = 0; plane < planes; ++plane)
            for (std::size_t x = 0; x < width; ++x)
                out[plane * pixels + x] = static_cast<std::uint8_t>(numbers[x] >> 8 * plane);
    }
}

/// The reverse: calls set(i, step) for every pixel. Returns the bytes behind the planes.
template <class Set>
const std::uint8_t* take_planes(const std::uint8_t* content, std::size_t width, std::size_t pixels, int bits, const Set& set)
{
    const std::size_t planes = Header::planes(static_cast<std::uint32_t>(bits));
    const std::uint32_t mask = ~0U >> (32 - bits);
    std::vector<std::uint32_t> above(width);
    std::vector<std::uint32_t> numbers(width);
    const std::uint8_t* in = content;
    for (std::size_t row = 0; row < pixels; row += width, in += width)
    {
        for (std::size_t x = 0; x < width; ++x)
            numbers[x] = in[x];
        for (std::size_t plane = 1; plane < planes; ++plane)
            for (std::size_t x = 0; x < width; ++x)
                numbers[x] |= std::uint32_t{in[plane * pixels + x]} << 8 * plane;
        for (std::size_t x = 0; x < width; ++x)
            above[x] += numbers[x] >> 1U ^ (0U - (numbers[x] & 1U));
        std::uint32_t step = 0;
        for (std::size_t x = 0; x < width; ++x)
            numbers[x] = step += above[x];
        for (std::size_t x = 0; x < width; ++x)
            set(row + x, numbers[x] & mask);
    }
    return content + planes * pixels;
}

/// A Zstandard frame with a checksum, behind `prefix` bytes that the caller fills. The content comes in pieces, made by next(i),
/// because all of it would take as much memory as the raster.
template <class Next>
std::vector<std::byte> compressed(std::size_t prefix, std::size_t bytes, std::size_t pieces, const Next& next)
{
    const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
    if (!context)
        throw std::bad_alloc();
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, zstd_level);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
    ZSTD_CCtx_setPledgedSrcSize(context.get(), bytes);
    std::vector<std::byte> file;
    file.reserve(prefix + ZSTD_compressBound(bytes));  // Its growth would need as much again.
    file.resize(prefix);
    for (std::size_t i = 0; i < pieces; ++i)
    {
        const std::vector<std::uint8_t> content = next(i);
        const std::size_t room = ZSTD_compressBound(content.size());
        const auto packed = std::make_unique_for_overwrite<std::byte[]>(room);
        ZSTD_inBuffer from{content.data(), content.size(), 0};
        const bool is_last = i + 1 == pieces;
        for (std::size_t left = 1; is_last ? left > 0 : from.pos < from.size;)
        {
            ZSTD_outBuffer to{packed.get(), room, 0};
            left = ZSTD_compressStream2(context.get(), &to, &from, is_last ? ZSTD_e_end : ZSTD_e_continue);
            if (ZSTD_isError(left) != 0)
                throw Error(std::string("values cannot be packed: ") + ZSTD_getErrorName(left));
            file.insert(file.end(), packed.get(), packed.get() + to.pos);
        }
    }
    return file;
}

/// `frame`: at byte `offset` of the file.
std::unique_ptr<std::uint8_t[]> decompressed(std::span<const std::byte> frame, std::size_t bytes, std::size_t offset,
                                             std::string_view source)
{
    if (bytes / most_packed > frame.size())
        fail(source, 12, fmt::format("so many pixels cannot be in {} bytes", frame.size()));
    const auto says = ZSTD_getFrameContentSize(frame.data(), frame.size());
    if (says != bytes)
        fail(source, offset,
             fmt::format("expected a Zstandard frame of {} bytes, got {}", bytes,
                         says == ZSTD_CONTENTSIZE_ERROR || says == ZSTD_CONTENTSIZE_UNKNOWN ? "none" : std::to_string(says)));
    auto content = std::make_unique_for_overwrite<std::uint8_t[]>(bytes);
    const std::size_t size = ZSTD_decompress(content.get(), bytes, frame.data(), frame.size());
    if (ZSTD_isError(size) != 0)
        fail(source, offset, ZSTD_getErrorName(size));
    return content;
}

}  // namespace

int uv_bits_for_texture(int size_px)
{
    if (size_px < 1 || size_px > 4096 << (max_uv_bits - min_uv_bits))
        throw std::invalid_argument(fmt::format("expected a texture of 1 to 262144 texels per side, got {}", size_px));
    return std::max(min_uv_bits, min_uv_bits - 12 + static_cast<int>(std::bit_width(static_cast<unsigned>(size_px - 1))));
}

int uv_bits_of(const UvMap& map)
{
    const auto exact = [&](int bits)
    {
        const auto last = static_cast<float>(last_step(bits));
        for (std::size_t i = 0; i < map.uv.values.size(); ++i)
        {
            const float value = map.uv.values[i];
            if (map.valid.values[i / 2] != 0 &&
                static_cast<float>(std::nearbyint(static_cast<double>(value) * last)) / last != value)
                return false;
        }
        return true;
    };
    int bits = min_uv_bits;
    while (bits < max_uv_bits && !exact(bits))
        ++bits;
    return bits;
}

std::vector<std::byte> pack_uv_map(const UvMap& map, int uv_bits, std::string_view source)
{
    if (uv_bits < min_uv_bits || uv_bits > max_uv_bits)
        throw std::invalid_argument(fmt::format("expected 16 to 22 bits of texcoords, got {}", uv_bits));
    check_map(map, source);
    const std::size_t pixels = map.valid.values.size();
    double deepest = 0;
    for (std::size_t i = 0; i < pixels; ++i)
        if (map.valid.values[i] != 0)
            deepest = std::max(deepest, static_cast<double>(map.depth.values[i]));
    float steps_per_meter = most_steps_per_meter;
    while (deepest * steps_per_meter > most_steps)
        steps_per_meter /= 2;
    const bool far = deepest * steps_per_meter + 0.5 >= last_step(depth_bits) + 1;
    const Header header{static_cast<std::uint32_t>(map.valid.width), static_cast<std::uint32_t>(map.valid.height),
                        static_cast<std::uint32_t>(uv_bits), static_cast<std::uint32_t>(far ? far_depth_bits : depth_bits),
                        steps_per_meter};

    std::vector<std::uint8_t> content((pixels + 7) / 8);
    content.reserve(header.content_bytes());
    for (std::size_t i = 0; i < pixels; ++i)
        content[i / 8] |= static_cast<std::uint8_t>((map.valid.values[i] != 0 ? 1U : 0U) << i % 8);
    const auto width = static_cast<std::size_t>(map.valid.width);
    const auto put = [&](int bits, const float* values, std::size_t channels, const auto& step_of)
    {
        // An invalid pixel counts as 0, whatever it holds: without a branch that borders of the surface would mislead.
        put_planes(content, width, pixels, bits,
                   [&](std::size_t i)
                   {
                       const auto mask = map.valid.values[i] != 0 ? ~0U : 0U;
                       return step_of(std::bit_cast<float>(std::bit_cast<std::uint32_t>(values[i * channels]) & mask));
                   });
    };
    const auto share = [](int last) { return [last](float value) { return share_step(value, last); }; };
    for (const std::size_t channel : {0U, 1U})
        put(uv_bits, map.uv.values.data() + channel, 2, share(last_step(uv_bits)));
    put(cosine_bits, map.cosine.values.data(), 1, share(last_step(cosine_bits)));
    put(static_cast<int>(header.depth_bits), map.depth.values.data(), 1,
        [steps_per_meter](float depth)
        {
            // Surface in front of the camera stays there.
            const std::uint32_t step = rounded(static_cast<double>(depth) * steps_per_meter);
            const std::uint32_t least = depth > 0 ? 1 : 0;
            return step < least ? least : step;
        });
    auto file = compressed(Header::bytes, content.size(), 1, [&](std::size_t) { return std::move(content); });
    header.write(file);
    return file;
}

UvMap unpack_uv_map(std::span<const std::byte> bytes, int width, int height, std::string_view source)
{
    const Header header = Header::read(bytes, source);
    if (header.width != static_cast<std::uint32_t>(width) || header.height != static_cast<std::uint32_t>(height))
        throw Error(
            fmt::format("{}: offset 12: is {}x{}; the index says {}x{}", source, header.width, header.height, width, height));
    const auto content = decompressed(bytes.subspan(Header::bytes), header.content_bytes(), Header::bytes, source);
    UvMap map{{width, height, 2}, {width, height}, {width, height}, {width, height}};
    for (std::size_t i = 0; i < header.pixels(); ++i)
        map.valid.values[i] = content[i / 8] >> i % 8 & 1U;
    const std::uint8_t* next = content.get() + (header.pixels() + 7) / 8;
    const int uv_bits = static_cast<int>(header.uv_bits);
    const auto take = [&](int bits, float* values, std::size_t channels, float steps_of_one)
    {
        next = take_planes(next, static_cast<std::size_t>(width), header.pixels(), bits,
                           [&, steps_of_one](std::size_t i, std::uint32_t step) {
                               values[i * channels] = map.valid.values[i] != 0
                                                          ? static_cast<float>(static_cast<std::int32_t>(step)) / steps_of_one
                                                          : 0.0F;
                           });
    };
    for (const std::size_t channel : {0U, 1U})
        take(uv_bits, map.uv.values.data() + channel, 2, static_cast<float>(last_step(uv_bits)));
    take(cosine_bits, map.cosine.values.data(), 1, static_cast<float>(last_step(cosine_bits)));
    take(static_cast<int>(header.depth_bits), map.depth.values.data(), 1, header.steps_per_meter);
    return map;
}

namespace
{

/// The header of a packed raster, little-endian.
struct RasterHeader
{
    static constexpr std::size_t bytes = 24;
    static constexpr std::string_view magic = "FRESCORA";
    std::uint32_t type = 0;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t channels = 0;

    std::size_t pixels() const { return std::size_t{width} * height; }
    std::size_t content_bytes() const { return pixels() * channels * (static_cast<std::size_t>(bits()) / 8); }
    int bits() const { return type == shares ? 8 : 8 << type; }

    static constexpr std::uint32_t shares = 3;  ///< Floats that all are n / 255, as bytes n.
};

template <class T>
constexpr std::uint32_t raster_type = std::bit_width(sizeof(T)) - 1;  // Bytes, 16-bit numbers, floats.

template <class T>
std::uint32_t step_of(T value)
{
    if constexpr (std::is_same_v<T, float>)
        return std::bit_cast<std::uint32_t>(value);
    else
        return value;
}

std::uint32_t share_of(float value)
{
    return share_step(value, 255);
}

bool are_shares(const RasterF& raster)
{
    return std::ranges::all_of(
        raster.values, [](float value)
        { return value >= 0 && value <= 1 && !std::signbit(value) && static_cast<float>(share_of(value)) / 255 == value; });
}

}  // namespace

template <class T>
std::vector<std::byte> detail::pack_raster(const Raster<T>& raster, std::string_view source)
{
    RasterHeader header{raster_type<T>, static_cast<std::uint32_t>(raster.width), static_cast<std::uint32_t>(raster.height),
                        static_cast<std::uint32_t>(raster.channels)};
    if (header.pixels() > most_pixels)
        throw Error(fmt::format("{}: expected at most {} pixels, got {}x{}", source, most_pixels, raster.width, raster.height));
    if constexpr (std::is_same_v<T, float>)
        if (are_shares(raster))
            header.type = RasterHeader::shares;
    const auto planes_of = [&](std::size_t channel)
    {
        std::vector<std::uint8_t> content;
        const T* const values = raster.values.data() + channel;
        const std::size_t channels = header.channels;
        if (header.type == RasterHeader::shares)
            put_planes(content, header.width, header.pixels(), 8,
                       [&](std::size_t i) { return share_of(static_cast<float>(values[i * channels])); });
        else
            put_planes(content, header.width, header.pixels(), header.bits(),
                       [&](std::size_t i) { return step_of(values[i * channels]); });
        return content;
    };
    auto file = compressed(RasterHeader::bytes, header.content_bytes(), header.channels, planes_of);
    std::memcpy(file.data(), RasterHeader::magic.data(), RasterHeader::magic.size());
    std::memcpy(file.data() + 8, &header, sizeof header);
    return file;
}

template <class T>
Raster<T> detail::unpack_raster(std::span<const std::byte> file, std::string_view source)
{
    check_begin(file, RasterHeader::bytes, RasterHeader::magic, source);
    RasterHeader header;
    std::memcpy(&header, file.data() + 8, sizeof header);
    const bool are_shares = std::is_same_v<T, float> && header.type == RasterHeader::shares;
    if (header.type != raster_type<T> && !are_shares)
        fail(source, 8, fmt::format("expected values of type {}, got {}", raster_type<T>, header.type));
    const bool is_empty = header.width == 0 && header.height == 0;
    if ((header.pixels() < 1 && !is_empty) || header.pixels() > most_pixels || header.channels < 1 || header.channels > 4)
        fail(source, 12,
             fmt::format("expected 1 to {} pixels and 1 to 4 channels, or 0x0, got {}x{}x{}", most_pixels, header.width,
                         header.height, header.channels));
    const auto content = decompressed(file.subspan(RasterHeader::bytes), header.content_bytes(), RasterHeader::bytes, source);
    Raster<T> raster(static_cast<int>(header.width), static_cast<int>(header.height), static_cast<int>(header.channels));
    const std::uint8_t* next = content.get();
    for (std::size_t channel = 0; channel < header.channels; ++channel)
        next = take_planes(
            next, header.width, header.pixels(), header.bits(),
            [&, values = raster.values.data() + channel, channels = header.channels](std::size_t i, std::uint32_t step)
            {
                if constexpr (std::is_same_v<T, float>)
                    values[i * channels] = are_shares ? static_cast<float>(step) / 255 : std::bit_cast<float>(step);
                else
                    values[i * channels] = static_cast<T>(step);
            });
    return raster;
}

template std::vector<std::byte> detail::pack_raster(const Raster8& raster, std::string_view source);
template std::vector<std::byte> detail::pack_raster(const Raster16& raster, std::string_view source);
template std::vector<std::byte> detail::pack_raster(const RasterF& raster, std::string_view source);
template Raster8 detail::unpack_raster(std::span<const std::byte> file, std::string_view source);
template Raster16 detail::unpack_raster(std::span<const std::byte> file, std::string_view source);
template RasterF detail::unpack_raster(std::span<const std::byte> file, std::string_view source);

}  // namespace fresco
