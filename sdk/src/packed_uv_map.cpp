#include "packed_uv_map.h"
#include "residuals.h"

#include <fresco/error.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <zlib.h>
#include <zstd.h>

namespace fresco::detail
{
namespace
{

constexpr char magic[] = "FRESCOUV";
constexpr std::uint32_t form = 2;

std::uint32_t crc32(std::span<const std::byte> bytes)
{
    return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

class HeaderWriter
{
  public:
    explicit HeaderWriter(std::span<std::byte> out) : out_(out) {}
    void byte(std::uint8_t value) { out_[at_++] = std::byte{value}; }
    void number(std::uint32_t value)
    {
        for (unsigned shift = 0; shift < 32; shift += 8)
            byte(static_cast<std::uint8_t>(value >> shift));
    }
    std::span<const std::byte> written() const { return out_.first(at_); }

  private:
    std::span<std::byte> out_;
    std::size_t at_ = 0;
};

class Reader
{
  public:
    explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}
    std::uint8_t byte() { return std::to_integer<std::uint8_t>(bytes_[at_++]); }
    std::uint32_t number()
    {
        std::uint32_t value = 0;
        for (unsigned shift = 0; shift < 32; shift += 8)
            value |= std::uint32_t{byte()} << shift;
        return value;
    }
    std::size_t at() const { return at_; }
    std::span<const std::byte> done() const { return bytes_.first(at_); }

  private:
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
};

}  // namespace

void fail_packed(std::string_view source, std::size_t offset, std::string_view what)
{
    throw Error(fmt::format(
        "{}: offset {}: {}; the file is damaged: rerun the stage that wrote it ('fresco store verify' finds its result)", source,
        offset, what));
}

std::array<std::byte, PackedUvMapHeader::bytes> PackedUvMapHeader::write() const
{
    std::array<std::byte, bytes> out{};
    HeaderWriter writer(out);
    for (const char letter : std::string_view(magic))
        writer.byte(static_cast<std::uint8_t>(letter));
    for (const std::uint32_t value : {form, width, height, valid_pixels})
        writer.number(value);
    for (const std::uint8_t value : bits)
        writer.byte(value);
    writer.number(std::bit_cast<std::uint32_t>(depth_steps_per_meter));
    writer.number(mask);
    for (const PackedParts& quantity : parts)
        for (const std::uint32_t size : {quantity.low, quantity.extra, quantity.large})
            writer.number(size);
    writer.number(crc32(writer.written()));
    return out;
}

PackedUvMapHeader PackedUvMapHeader::read(std::span<const std::byte> file, std::string_view source)
{
    if (file.size() < bytes)
        fail_packed(source, file.size(), fmt::format("ends within the header of {} bytes", bytes));
    if (std::memcmp(file.data(), magic, std::strlen(magic)) != 0)
        fail_packed(source, 0, "expected \"FRESCOUV\", the beginning of a packed uv map");
    Reader reader(file);
    reader.number();
    reader.number();
    if (const std::uint32_t found = reader.number(); found != form)
        fail_packed(source, 8, fmt::format("expected form {}, got {}", form, found));
    PackedUvMapHeader header;
    header.width = reader.number();
    header.height = reader.number();
    header.valid_pixels = reader.number();
    for (std::uint8_t& value : header.bits)
        value = reader.byte();
    header.depth_steps_per_meter = std::bit_cast<float>(reader.number());
    std::uint64_t end = bytes;
    end += header.mask = reader.number();
    for (PackedParts& quantity : header.parts)
        for (std::uint32_t* size : {&quantity.low, &quantity.extra, &quantity.large})
            end += * size = reader.number();
    const std::uint32_t sum = crc32(reader.done());
    if (reader.number() != sum)
        fail_packed(source, bytes - 4, "the header's checksum is wrong");
    if (end != file.size())
        fail_packed(source, file.size(), fmt::format("ends; the header lists parts up to {}", end));

    const auto& [u, v, cosine, depth] = header.bits;
    if (u < 16 || u > 22 || v != u || cosine != 8 || (depth != 16 && depth != 22))
        fail_packed(source, 24, "expected 16 to 22 bits of u and as many of v, 8 of the cosine, 16 or 22 of depth");
    // Too few would make infinite depths of sound steps.
    if (!(header.depth_steps_per_meter > 0 && header.depth_steps_per_meter <= 1000) ||
        !std::isfinite(4194303.0F / header.depth_steps_per_meter))
        fail_packed(source, 28, "expected steps of depth per meter above 0 and at most 1000");
    return header;
}
namespace
{

// Residuals hardly repeat: what counts is how often each byte occurs. Short repetitions, and long searches for them, cost more
// than they save.
constexpr int level = 1;
constexpr int shortest_repetition = 7;
constexpr int searched_log = 10;

/// The thread's own: making one costs more than a small frame.
ZSTD_CCtx* compressor()
{
    struct Free
    {
        void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    };
    thread_local const std::unique_ptr<ZSTD_CCtx, Free> context(ZSTD_createCCtx());
    if (!context)
        throw std::bad_alloc();
    return context.get();
}

ZSTD_DCtx* decompressor()
{
    struct Free
    {
        void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
    };
    thread_local const std::unique_ptr<ZSTD_DCtx, Free> context(ZSTD_createDCtx());
    if (!context)
        throw std::bad_alloc();
    return context.get();
}

}  // namespace

std::uint32_t FrameWriter::append(std::span<const std::uint8_t> contents)
{
    if (contents.empty())
        return 0;
    const std::size_t bound = ZSTD_compressBound(contents.size());
    if (bound > scratch_bytes_)
    {
        scratch_ = std::make_unique_for_overwrite<std::byte[]>(bound);
        scratch_bytes_ = bound;
    }
    ZSTD_CCtx* context = compressor();
    ZSTD_CCtx_reset(context, ZSTD_reset_session_and_parameters);
    ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, level);
    ZSTD_CCtx_setParameter(context, ZSTD_c_minMatch, shortest_repetition);
    ZSTD_CCtx_setParameter(context, ZSTD_c_hashLog, searched_log);
    ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
    const std::size_t size = ZSTD_compress2(context, scratch_.get(), bound, contents.data(), contents.size());
    if (ZSTD_isError(size) != 0)
        throw Error(std::string("a uv map cannot be packed: ") + ZSTD_getErrorName(size));
    bytes_.insert(bytes_.end(), scratch_.get(), scratch_.get() + size);
    return static_cast<std::uint32_t>(size);
}

std::string read_frame(std::span<const std::byte> frame, std::span<std::uint8_t> bytes)
{
    if (bytes.empty())
        return frame.empty() ? "" : "expected no bytes";
    const auto says = ZSTD_getFrameContentSize(frame.data(), frame.size());
    if (says == ZSTD_CONTENTSIZE_ERROR || says == ZSTD_CONTENTSIZE_UNKNOWN)
        return "expected a Zstandard frame with its size";
    if (says != bytes.size())
        return fmt::format("expected a frame of {} bytes, got {}", bytes.size(), says);
    const std::size_t size = ZSTD_decompressDCtx(decompressor(), bytes.data(), bytes.size(), frame.data(), frame.size());
    return ZSTD_isError(size) != 0 ? ZSTD_getErrorName(size) : "";
}

}  // namespace fresco::detail

namespace fresco
{
namespace
{

using detail::fail_packed;
using detail::PackedUvMapHeader;
using detail::ResidualDecoder;
using detail::ResidualEncoder;

constexpr float uv_rounding = 1e-5F;
constexpr int cosine_bits = 8;
constexpr float most_steps_per_meter = 1000;
constexpr int depth_bits = 16;
constexpr int far_depth_bits = 22;
/// Of depth: a float holds so many exactly, with bits to spare for rounding.
constexpr double most_steps = 2'097'152;
constexpr std::size_t most_pixels = std::size_t{1} << 28U;
/// Zstandard's smallest block, of 4 bytes, holds 128 KiB.
constexpr std::size_t most_packed = 32768;

constexpr int last_step(int bits)
{
    return (1 << bits) - 1;
}

std::string pixel_text(std::size_t pixel, int width)
{
    const auto columns = static_cast<std::size_t>(width);
    return fmt::format("pixel ({}, {})", pixel % columns, pixel / columns);
}

/// All ones where a pixel is valid, 0 elsewhere.
void keep_masks(const std::uint8_t* __restrict valid, std::size_t width, std::uint32_t* __restrict keep)
{
    for (std::size_t x = 0; x < width; ++x)
        keep[x] = valid[x] != 0 ? ~0U : 0U;
}

void pick_channel(const float* __restrict values, std::size_t width, std::size_t channels, std::size_t channel,
                  std::uint32_t* __restrict out)
{
    for (std::size_t x = 0; x < width; ++x)
        out[x] = std::bit_cast<std::uint32_t>(values[x * channels + channel]);
}

/// The nearest whole number, of numbers from 0 on.
std::int32_t rounded(double number)
{
    // lround is not vectorized; the last bit, in which they may differ, counts nothing here.
    return static_cast<std::int32_t>(number + 0.5);  // NOLINT(bugprone-incorrect-roundings)
}

/// Floats of a row, as bits, rounded to steps of [0,1]; 1e-5 beyond is taken for 0 or 1. False if a kept value is farther out.
bool share_steps(std::uint32_t* __restrict row, const std::uint32_t* __restrict keep, std::size_t width, int last)
{
    std::uint32_t bad = 0;
    for (std::size_t x = 0; x < width; ++x)
    {
        const auto value = std::bit_cast<float>(row[x] & keep[x]);
        const std::uint32_t good = (value >= -uv_rounding ? ~0U : 0U) & (value <= 1 + uv_rounding ? ~0U : 0U);
        bad |= ~good;
        const auto within = static_cast<double>(std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) & good));
        const auto step = rounded(within * last);
        row[x] = static_cast<std::uint32_t>(step < 0 ? 0 : step > last ? last : step);
    }
    return bad == 0;
}

/// The same for depth: surface in front of the camera stays there.
void depth_steps(std::uint32_t* __restrict row, const std::uint32_t* __restrict keep, std::size_t width, double per_meter)
{
    for (std::size_t x = 0; x < width; ++x)
    {
        const auto depth = std::bit_cast<float>(row[x] & keep[x]);
        const std::int32_t step = rounded(static_cast<double>(depth) * per_meter);
        const std::int32_t least = depth > 0 ? 1 : 0;
        row[x] = static_cast<std::uint32_t>(step < least ? least : step);
    }
}

/// The largest depth of a valid pixel; negative and not finite ones throw.
float largest_depth(const UvMap& map, std::string_view source)
{
    // Compared as bits: of floats from 0 on they are in the same order, those of all others are larger than infinity's.
    constexpr auto infinity = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::infinity());
    const float* depth = map.depth.values.data();
    const std::uint8_t* valid = map.valid.values.data();
    const std::size_t pixels = map.valid.values.size();
    const auto bits_at = [&](std::size_t i) { return valid[i] != 0 ? std::bit_cast<std::uint32_t>(depth[i] + 0.0F) : 0U; };
    std::uint32_t largest = 0;
    for (std::size_t i = 0; i < pixels; ++i)
        largest = std::max(largest, bits_at(i));
    if (largest >= infinity)
    {
        std::size_t bad = 0;
        while (bits_at(bad) < infinity)
            ++bad;
        throw Error(fmt::format("{}: depth: {} holds {:f}; expected a distance in meters", source,
                                pixel_text(bad, map.depth.width), depth[bad]));
    }
    return std::bit_cast<float>(largest);
}

[[noreturn]] void fail_share(const RasterF& raster, const Raster8& valid, std::string_view what, std::string_view source)
{
    for (std::size_t i = 0; i < raster.values.size(); ++i)
    {
        const std::size_t pixel = i / static_cast<std::size_t>(raster.channels);
        const float value = raster.values[i];
        if (valid.values[pixel] != 0 && !(value >= -uv_rounding && value <= 1 + uv_rounding))
            throw Error(fmt::format("{}: {}: {} holds {:f}; expected a number from 0 to 1", source, what,
                                    pixel_text(pixel, raster.width), value));
    }
    throw std::logic_error("no value is out of range");
}

void check_rasters(const UvMap& map, std::string_view source)
{
    const auto check = [&](const auto& raster, int channels, const char* what)
    {
        if (raster.width != map.valid.width || raster.height != map.valid.height || raster.channels != channels)
            throw Error(fmt::format("{}: {}: is {}x{}x{}; expected {}x{}x{}, as the validity has it", source, what, raster.width,
                                    raster.height, raster.channels, map.valid.width, map.valid.height, channels));
    };
    check(map.valid, 1, "validity");
    check(map.uv, 2, "uv");
    check(map.depth, 1, "depth");
    check(map.cosine, 1, "cosine");
    if (map.valid.empty() || map.valid.values.size() > most_pixels)
        throw Error(fmt::format("{}: expected 1 to {} pixels, got {}", source, most_pixels, map.valid.values.size()));
}

/// Bit i % 8 of byte i / 8 says whether pixel i is valid.
std::vector<std::uint8_t> mask_of(const Raster8& valid, std::uint32_t& valid_pixels)
{
    const std::size_t pixels = valid.values.size();
    std::vector<std::uint8_t> mask((pixels + 7) / 8);
    std::size_t ones = 0;
    for (std::size_t i = 0; i < mask.size(); ++i)
    {
        std::array<std::uint8_t, 8> eight{};
        std::copy_n(valid.values.data() + 8 * i, std::min<std::size_t>(8, pixels - 8 * i), eight.data());
        for (std::uint8_t& pixel : eight)
            pixel = pixel != 0 ? 1 : 0;
        // The product's top byte collects the lowest bits of the eight bytes.
        mask[i] = static_cast<std::uint8_t>(std::bit_cast<std::uint64_t>(eight) * 0x0102040810204080U >> 56U);
        ones += static_cast<std::size_t>(std::popcount(mask[i]));
    }
    valid_pixels = static_cast<std::uint32_t>(ones);
    return mask;
}

std::size_t put_mask(std::span<const std::uint8_t> mask, Raster8& valid)
{
    static_assert(std::endian::native == std::endian::little, "the first of eight pixels is a word's lowest byte");
    const std::size_t pixels = valid.values.size();
    std::size_t ones = 0;
    for (std::size_t i = 0; i < mask.size(); ++i)
    {
        // Byte k keeps bit k of the mask, then becomes 1 if it has any.
        const std::uint64_t bits = mask[i] * 0x0101010101010101U & 0x8040201008040201U;
        const auto eight = std::bit_cast<std::array<std::uint8_t, 8>>((bits + 0x7f7f7f7f7f7f7f7fU) >> 7U & 0x0101010101010101U);
        std::copy_n(eight.data(), std::min<std::size_t>(8, pixels - 8 * i), valid.values.data() + 8 * i);
        ones += static_cast<std::size_t>(std::popcount(mask[i]));
    }
    return ones;
}

/// Before anything is allocated for them.
void check_pixels(const PackedUvMapHeader& header, std::string_view source)
{
    const std::size_t pixels = std::size_t{header.width} * header.height;
    if (pixels < 1 || pixels > most_pixels)
        fail_packed(source, 12, fmt::format("expected 1 to {} pixels, got {}x{}", most_pixels, header.width, header.height));
    for (const detail::PackedParts& quantity : header.parts)
        if (pixels / most_packed > quantity.low)
            fail_packed(source, 12, fmt::format("{}x{} pixels cannot be in {} bytes", header.width, header.height, quantity.low));
}

/// Fetches the parts of a file one after the other.
class PartReader
{
  public:
    PartReader(std::span<const std::byte> file, std::string_view source) : file_(file), source_(source) {}

    std::span<const std::uint8_t> next(std::uint32_t packed, std::size_t bytes, std::unique_ptr<std::uint8_t[]>& memory)
    {
        memory = std::make_unique_for_overwrite<std::uint8_t[]>(bytes);
        const std::span<std::uint8_t> out(memory.get(), bytes);
        const std::string wrong = detail::read_frame(file_.subspan(at_, packed), out);
        if (!wrong.empty())
            fail_packed(source_, at_, wrong);
        at_ += packed;
        return out;
    }

  private:
    std::span<const std::byte> file_;
    std::string_view source_;
    std::size_t at_ = PackedUvMapHeader::bytes;
};

/// One quantity's planes out of a file, and their decoder.
struct Quantity
{
    Quantity(PartReader& parts, const detail::PackedParts& sizes, int width, int height, int bits)
        : pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
          low_bytes(parts.next(sizes.low, pixels, low)),
          extra_bytes(parts.next(sizes.extra, detail::extra_bits(bits) > 0 ? pixels : 0, extra)),
          large_bytes(parts.next(sizes.large, 2 * detail::count_large(low_bytes, bits), large)),
          rows(width, bits, low_bytes.data(), extra_bytes.data(), large_bytes)
    {
    }

    std::unique_ptr<std::uint8_t[]> low;
    std::unique_ptr<std::uint8_t[]> extra;
    std::unique_ptr<std::uint8_t[]> large;
    std::size_t pixels;
    std::span<const std::uint8_t> low_bytes;
    std::span<const std::uint8_t> extra_bytes;
    std::span<const std::uint8_t> large_bytes;
    ResidualDecoder rows;
};

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
    check_rasters(map, source);
    const int width = map.valid.width;
    const int height = map.valid.height;

    float steps_per_meter = most_steps_per_meter;
    const auto deepest = static_cast<double>(largest_depth(map, source));
    while (deepest * steps_per_meter > most_steps)
        steps_per_meter /= 2;
    const bool far = deepest * steps_per_meter + 0.5 >= last_step(depth_bits) + 1;

    PackedUvMapHeader header;
    header.width = static_cast<std::uint32_t>(width);
    header.height = static_cast<std::uint32_t>(height);
    header.bits = {static_cast<std::uint8_t>(uv_bits), static_cast<std::uint8_t>(uv_bits), cosine_bits,
                   static_cast<std::uint8_t>(far ? far_depth_bits : depth_bits)};
    header.depth_steps_per_meter = steps_per_meter;
    const auto mask = mask_of(map.valid, header.valid_pixels);

    std::array<ResidualEncoder, detail::packed_quantities> encoders{
        ResidualEncoder(width, height, header.bits[0]), ResidualEncoder(width, height, header.bits[1]),
        ResidualEncoder(width, height, header.bits[2]), ResidualEncoder(width, height, header.bits[3])};
    const auto columns = static_cast<std::size_t>(width);
    std::vector<std::uint32_t> keep(columns);
    std::vector<std::uint32_t> steps(columns);
    for (int y = 0; y < height; ++y)
    {
        const std::uint8_t* valid = &map.valid.at(0, y);
        keep_masks(valid, columns, keep.data());
        for (const std::size_t channel : {detail::packed_u, detail::packed_v})
        {
            pick_channel(&map.uv.at(0, y), columns, 2, channel, steps.data());
            if (!share_steps(steps.data(), keep.data(), columns, last_step(uv_bits)))
                fail_share(map.uv, map.valid, "uv", source);
            encoders[channel].row(steps.data(), valid);
        }
        pick_channel(&map.cosine.at(0, y), columns, 1, 0, steps.data());
        if (!share_steps(steps.data(), keep.data(), columns, last_step(cosine_bits)))
            fail_share(map.cosine, map.valid, "cosine", source);
        encoders[detail::packed_cosine].row(steps.data(), valid);
        pick_channel(&map.depth.at(0, y), columns, 1, 0, steps.data());
        depth_steps(steps.data(), keep.data(), columns, static_cast<double>(steps_per_meter));
        encoders[detail::packed_depth].row(steps.data(), valid);
    }

    detail::FrameWriter frames(PackedUvMapHeader::bytes);
    header.mask = frames.append(mask);
    for (std::size_t i = 0; i < encoders.size(); ++i)
    {
        const auto planes = std::move(encoders[i]).planes();
        header.parts[i] = {frames.append(planes.low), frames.append(planes.extra), frames.append(planes.large)};
    }
    auto file = std::move(frames).bytes();
    std::ranges::copy(header.write(), file.begin());
    return file;
}

UvMap unpack_uv_map(std::span<const std::byte> bytes, int width, int height, std::string_view source)
{
    const PackedUvMapHeader header = PackedUvMapHeader::read(bytes, source);
    if (header.width != static_cast<std::uint32_t>(width) || header.height != static_cast<std::uint32_t>(height))
        throw Error(
            fmt::format("{}: offset 12: is {}x{}; the index says {}x{}", source, header.width, header.height, width, height));
    check_pixels(header, source);
    UvMap map{{width, height, 2}, {width, height}, {width, height}, {width, height}};
    PartReader parts(bytes, source);
    {
        std::unique_ptr<std::uint8_t[]> memory;
        const auto mask = parts.next(header.mask, (map.valid.values.size() + 7) / 8, memory);
        if (const std::size_t ones = put_mask(mask, map.valid); ones != header.valid_pixels)
            fail_packed(source, 20, fmt::format("{} valid pixels are listed, the mask has {}", header.valid_pixels, ones));
    }
    const auto quantity = [&](std::size_t i) { return Quantity(parts, header.parts[i], width, height, header.bits[i]); };
    Quantity u = quantity(detail::packed_u);
    Quantity v = quantity(detail::packed_v);
    Quantity cosine = quantity(detail::packed_cosine);
    Quantity depth = quantity(detail::packed_depth);

    const auto last_uv = static_cast<float>(last_step(header.bits[detail::packed_u]));
    const auto last_cosine = static_cast<float>(last_step(header.bits[detail::packed_cosine]));
    const auto columns = static_cast<std::size_t>(width);
    for (int y = 0; y < height; ++y)
    {
        const std::uint8_t* valid = &map.valid.at(0, y);
        const std::uint32_t* us = u.rows.row();
        const std::uint32_t* vs = v.rows.row();
        const std::uint32_t* cosines = cosine.rows.row();
        const std::uint32_t* depths = depth.rows.row();
        float* uv_row = &map.uv.at(0, y);
        float* cosine_row = &map.cosine.at(0, y);
        float* depth_row = &map.depth.at(0, y);
        // Signed, as processors convert; a mask of all ones or none keeps invalid pixels at 0.
        const auto kept = [&](std::uint32_t steps, std::size_t x)
        { return static_cast<float>(static_cast<std::int32_t>(steps & (0U - valid[x]))); };
        for (std::size_t x = 0; x < columns; ++x)
        {
            uv_row[2 * x] = kept(us[x], x) / last_uv;
            uv_row[2 * x + 1] = kept(vs[x], x) / last_uv;
        }
        for (std::size_t x = 0; x < columns; ++x)
            cosine_row[x] = kept(cosines[x], x) / last_cosine;
        for (std::size_t x = 0; x < columns; ++x)
            depth_row[x] = kept(depths[x], x) / header.depth_steps_per_meter;
    }
    return map;
}

PackedUvMapBytes packed_uv_map_bytes(std::span<const std::byte> bytes, std::string_view source)
{
    const PackedUvMapHeader header = PackedUvMapHeader::read(bytes, source);
    const auto sum = [&](std::size_t i)
    { return std::size_t{header.parts[i].low} + header.parts[i].extra + header.parts[i].large; };
    return {PackedUvMapHeader::bytes, header.mask, sum(detail::packed_u) + sum(detail::packed_v), sum(detail::packed_cosine),
            sum(detail::packed_depth)};
}

}  // namespace fresco
