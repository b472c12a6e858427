#include "zip_archive.h"

#include <fresco/error.h>

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <utility>
#include <vector>

namespace fresco::weights::detail
{
namespace
{

constexpr std::size_t end_size = 22;
constexpr std::size_t directory_entry_size = 46;
constexpr std::size_t header_size = 30;
constexpr std::uint64_t encrypted = 1;
constexpr std::uint64_t sizes_follow = 8;  ///< The sizes are after the data, not in the entry's header.

bool saturated(std::uint64_t number)
{
    return number == 0xffffffffU;
}

}  // namespace

void ZipArchive::fail(std::size_t offset, const std::string& what) const
{
    throw Error(fmt::format("{}: byte {}: {}; not a zip archive as torch.save writes it", source_, offset, what));
}

std::uint64_t ZipArchive::number(std::size_t offset, std::size_t bytes) const
{
    std::uint64_t value = 0;
    std::memcpy(&value, bytes_.data() + offset, bytes);
    return value;
}

ZipArchive::ZipArchive(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes), source_(source)
{
    const std::size_t end = find_end();
    const std::uint64_t count = number(end + 10, 2);
    const std::uint64_t size = number(end + 12, 4);
    const std::uint64_t begin = number(end + 16, 4);
    if (number(end + 4, 4) != 0 || number(end + 8, 2) != count)
        fail(end, "an archive in several parts");
    if (saturated(size) || saturated(begin) || begin > end || size > end - begin)
        fail(end, "a central directory beyond the end of the file");
    std::size_t offset = static_cast<std::size_t>(begin);
    for (std::uint64_t i = 0; i < count; ++i)
        offset = read_entry(offset, static_cast<std::size_t>(begin + size));
    if (offset != begin + size)
        fail(offset, "bytes in the central directory that belong to no entry");
    check_overlaps(static_cast<std::size_t>(begin));
}

std::size_t ZipArchive::find_end() const
{
    constexpr std::size_t longest_comment = 0xffff;
    const std::size_t size = bytes_.size();
    for (std::size_t comment = 0; comment <= longest_comment && comment + end_size <= size; ++comment)
    {
        const std::size_t at = size - end_size - comment;
        if (std::memcmp(bytes_.data() + at, "PK\5\6", 4) == 0 && number(at + 20, 2) == comment)
            return at;
    }
    fail(size, "the end of the central directory is missing: the file is cut off");
}

std::size_t ZipArchive::read_entry(std::size_t offset, std::size_t end)
{
    if (end - offset < directory_entry_size || std::memcmp(bytes_.data() + offset, "PK\1\2", 4) != 0)
        fail(offset, "an entry of the central directory is missing");
    const std::uint64_t flags = number(offset + 8, 2);
    const std::uint64_t method = number(offset + 10, 2);
    const std::uint64_t packed = number(offset + 20, 4);
    const std::uint64_t size = number(offset + 24, 4);
    const std::uint64_t name_length = number(offset + 28, 2);
    const std::uint64_t length = directory_entry_size + name_length + number(offset + 30, 2) + number(offset + 32, 2);
    const std::uint64_t header = number(offset + 42, 4);
    if (length > end - offset)
        fail(offset, "an entry of the central directory is cut off");
    const std::string name(reinterpret_cast<const char*>(bytes_.data()) + offset + directory_entry_size, name_length);
    if ((flags & encrypted) != 0 || method != 0)
        fail(offset, "an entry that is compressed or encrypted; PyTorch stores them as they are");
    if (saturated(size) || saturated(header) || packed != size)
        fail(offset, "an entry of more than 4 GiB or with two sizes");
    Entry entry{static_cast<std::size_t>(header), 0, static_cast<std::size_t>(size),
                static_cast<std::uint32_t>(number(offset + 16, 4))};
    check_header(name, entry);
    if (!entries_.emplace(name, entry).second)
        fail(offset, "two entries of the same name");
    return offset + static_cast<std::size_t>(length);
}

void ZipArchive::check_header(const std::string& name, Entry& entry) const
{
    const std::size_t at = entry.header;
    if (at > bytes_.size() || bytes_.size() - at < header_size || std::memcmp(bytes_.data() + at, "PK\3\4", 4) != 0)
        fail(at, "the header of an entry is missing");
    const std::uint64_t flags = number(at + 6, 2);
    const std::uint64_t name_length = number(at + 26, 2);
    const std::uint64_t length = header_size + name_length + number(at + 28, 2);
    if (length > bytes_.size() - at || entry.size > bytes_.size() - at - length)
        fail(at, "an entry beyond the end of the file");
    if (number(at + 8, 2) != 0 || name_length != name.size() ||
        std::memcmp(bytes_.data() + at + header_size, name.data(), name.size()) != 0)
        fail(at, "the header of an entry does not agree with the central directory");
    if ((flags & sizes_follow) == 0 && (number(at + 14, 4) != entry.checksum || number(at + 22, 4) != entry.size))
        fail(at, "the header of an entry does not agree with the central directory");
    entry.data = at + static_cast<std::size_t>(length);
}

void ZipArchive::check_overlaps(std::size_t directory) const
{
    std::vector<std::pair<std::size_t, std::size_t>> extents;
    for (const auto& [name, entry] : entries_)
        extents.emplace_back(entry.header, entry.data + entry.size);
    std::sort(extents.begin(), extents.end());
    std::size_t previous = 0;
    for (const auto& [begin, end] : extents)
    {
        if (begin < previous || end > directory)
            fail(begin, "entries that overlap");
        previous = end;
    }
}

std::span<const std::byte> ZipArchive::contents(const std::string& name) const
{
    const auto found = entries_.find(name);
    if (found == entries_.end())
        throw Error(source_ + ": the archive lacks the entry '" + name + "'");
    const auto data = bytes_.subspan(found->second.data, found->second.size);
    if (crc32_z(0, reinterpret_cast<const Bytef*>(data.data()), data.size()) != found->second.checksum)
        fail(found->second.data, "the entry '" + name + "' is damaged: its checksum is wrong");
    return data;
}

std::string ZipArchive::only_name_with_end(std::string_view end) const
{
    std::string result;
    for (const auto& [name, entry] : entries_)
        if (name.ends_with(end))
        {
            if (!result.empty())
                throw Error(source_ + ": two entries that end with '" + std::string(end) + "'");
            result = name;
        }
    if (result.empty())
        throw Error(source_ + ": no entry that ends with '" + std::string(end) + "'; not an archive as torch.save writes it");
    return result;
}

}  // namespace fresco::weights::detail
