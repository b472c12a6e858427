#include "zip_archive.h"

#include <array>

namespace fresco::weights::detail
{
namespace
{

using Table = std::array<std::uint32_t, 256>;

/// tables[k][b]: byte b followed by k zero bytes, so that eight bytes are taken at once.
constexpr std::array<Table, 8> make_tables()
{
    std::array<Table, 8> tables{};
    for (std::uint32_t b = 0; b < 256; ++b)
    {
        std::uint32_t value = b;
        for (int bit = 0; bit < 8; ++bit)
            value = (value & 1U) != 0 ? 0xedb88320U ^ (value >> 1U) : value >> 1U;
        tables[0][b] = value;
    }
    for (std::size_t k = 1; k < 8; ++k)
        for (std::size_t b = 0; b < 256; ++b)
            tables[k][b] = tables[0][tables[k - 1][b] & 0xffU] ^ (tables[k - 1][b] >> 8U);
    return tables;
}
constexpr std::array<Table, 8> tables = make_tables();

}  // namespace

std::uint32_t crc32(std::span<const std::byte> bytes)
{
    std::uint32_t value = 0xffffffffU;
    std::size_t i = 0;
    for (; i + 8 <= bytes.size(); i += 8)
    {
        std::uint32_t next = 0;
        for (std::size_t k = 0; k < 8; ++k)
        {
            const auto carried = k < 4 ? (value >> (8 * k)) & 0xffU : 0U;
            next ^= tables[7 - k][std::to_integer<std::uint32_t>(bytes[i + k]) ^ carried];
        }
        value = next;
    }
    for (; i < bytes.size(); ++i)
        value = tables[0][(value ^ std::to_integer<std::uint32_t>(bytes[i])) & 0xffU] ^ (value >> 8U);
    return value ^ 0xffffffffU;
}

}  // namespace fresco::weights::detail
