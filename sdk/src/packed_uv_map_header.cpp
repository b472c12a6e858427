#include "packed_uv_map_header.h"

#include <fresco/error.h>

#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <string>

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

}  // namespace fresco::detail
