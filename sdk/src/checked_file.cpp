#include <fresco/checked_file.h>
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>
#include <fresco/write_pieces.h>

#include <algorithm>
#include <array>

namespace fresco
{
namespace
{

constexpr std::size_t checksum_digits = 32;

std::span<const std::byte> bytes_of(std::string_view text)
{
    return std::as_bytes(std::span(text.data(), text.size()));
}

}  // namespace

void write_checked(const std::filesystem::path& file, std::span<const std::byte> bytes)
{
    const std::string checksum = content_hash(bytes);
    const std::array pieces{bytes, bytes_of(checksum)};
    write_pieces(file, pieces);
}

void write_checked(const std::filesystem::path& file, std::string_view text)
{
    write_checked(file, bytes_of(text));
}

std::vector<std::byte> read_checked(const std::filesystem::path& file)
{
    std::vector<std::byte> bytes = read_file(file);
    const std::size_t size = bytes.size() - std::min(bytes.size(), checksum_digits);
    const std::span all(bytes);
    const std::string checksum = content_hash(all.first(size));
    if (!std::ranges::equal(all.subspan(size), bytes_of(checksum)))
        throw Error(file.string() + ": is damaged: its bytes do not fit its checksum");
    bytes.resize(size);
    return bytes;
}

std::string read_checked_text(const std::filesystem::path& file)
{
    const std::vector<std::byte> bytes = read_checked(file);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace fresco
