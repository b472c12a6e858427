#include <fresco/error.h>
#include <fresco/zip.h>

#include <fmt/format.h>
#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

namespace fresco
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

std::uint32_t checksum_of(std::span<const std::byte> bytes, std::uint32_t before = 0)
{
    return static_cast<std::uint32_t>(crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace

ZipReader::ZipReader(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes), source_(source)
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
}

const ZipReader::Entry& ZipReader::entry(const std::string& name) const
{
    const auto found = entries_.find(name);
    if (found == entries_.end())
        throw Error(source_ + ": the archive lacks the entry '" + name + "'");
    return found->second;
}

std::span<const std::byte> ZipReader::contents(const std::string& name) const
{
    const Entry& found = entry(name);
    if (found.is_deflated)
        throw Error(source_ + ": the entry '" + name + "' is compressed; expected it stored");
    const auto data = bytes_.subspan(found.data, found.size);
    if (checksum_of(data) != found.checksum)
        fail(found.data, "the entry '" + name + "' is damaged: its checksum is wrong");
    return data;
}

std::vector<std::byte> ZipReader::unpacked(const std::string& name, std::size_t most_bytes) const
{
    const Entry& found = entry(name);
    if (found.unpacked_size > most_bytes)
        throw Error(
            fmt::format("{}: the entry '{}' has {} bytes; expected at most {}", source_, name, found.unpacked_size, most_bytes));
    constexpr std::size_t most_ratio = 1100;  // Deflate gives at most 1032 times its bytes.
    if (found.is_deflated && found.unpacked_size / most_ratio > found.size)
        fail(found.header, "the entry '" + name + "' is damaged: it claims more than its data can hold");
    if (!found.is_deflated)
    {
        const auto stored = contents(name);
        return {stored.begin(), stored.end()};
    }
    // zlib wants a place to write to, also for nothing.
    std::vector<std::byte> result(found.unpacked_size + 1);
    const auto packed = bytes_.subspan(found.data, found.size);
    z_stream stream{};
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(result.data());
    stream.avail_out = static_cast<uInt>(found.unpacked_size);
    const bool is_open = inflateInit2(&stream, -MAX_WBITS) == Z_OK;
    const bool is_whole = is_open && inflate(&stream, Z_FINISH) == Z_STREAM_END && stream.avail_out == 0 && stream.avail_in == 0;
    inflateEnd(&stream);
    result.pop_back();
    if (!is_whole || checksum_of(result) != found.checksum)
        fail(found.data, "the entry '" + name + "' is damaged");
    return result;
}

std::vector<std::string> ZipReader::names() const
{
    std::vector<std::string> result;
    for (const auto& [name, entry] : entries_)
        result.push_back(name);
    return result;
}

void ZipReader::fail(std::size_t offset, const std::string& what) const
{
    throw Error(fmt::format("{}: byte {}: {}; not a whole zip archive", source_, offset, what));
}

std::uint64_t ZipReader::number(std::size_t offset, std::size_t bytes) const
{
    std::uint64_t value = 0;
    std::memcpy(&value, bytes_.data() + offset, bytes);
    return value;
}

std::size_t ZipReader::find_end() const
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

std::size_t ZipReader::read_entry(std::size_t offset, std::size_t end)
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
    if ((flags & encrypted) != 0 || (method != 0 && method != Z_DEFLATED))
        fail(offset, "an entry that is encrypted, or compressed in another way than by deflate");
    if (saturated(size) || saturated(header) || (method == 0 && packed != size))
        fail(offset, "an entry of more than 4 GiB or with two sizes");
    Entry entry{static_cast<std::size_t>(header),
                0,
                static_cast<std::size_t>(packed),
                static_cast<std::size_t>(size),
                static_cast<std::uint32_t>(number(offset + 16, 4)),
                method != 0};
    check_header(name, entry);
    if (!entries_.emplace(name, entry).second)
        fail(offset, "two entries of the same name");
    return offset + static_cast<std::size_t>(length);
}

void ZipReader::check_header(const std::string& name, Entry& entry) const
{
    const std::size_t at = entry.header;
    if (at > bytes_.size() || bytes_.size() - at < header_size || std::memcmp(bytes_.data() + at, "PK\3\4", 4) != 0)
        fail(at, "the header of an entry is missing");
    const std::uint64_t flags = number(at + 6, 2);
    const std::uint64_t name_length = number(at + 26, 2);
    const std::uint64_t length = header_size + name_length + number(at + 28, 2);
    if (length > bytes_.size() - at || entry.size > bytes_.size() - at - length)
        fail(at, "an entry beyond the end of the file");
    const bool has_sizes = (flags & sizes_follow) == 0;
    if (number(at + 8, 2) != (entry.is_deflated ? Z_DEFLATED : 0U) || name_length != name.size() ||
        std::memcmp(bytes_.data() + at + header_size, name.data(), name.size()) != 0 ||
        (has_sizes && (number(at + 14, 4) != entry.checksum || number(at + 22, 4) != entry.unpacked_size)))
        fail(at, "the header of an entry does not agree with the central directory");
    entry.data = at + static_cast<std::size_t>(length);
}

namespace
{

/// The data of each file in a package begin at multiples of this, in bytes.
constexpr std::uint64_t zip_alignment = 64;

constexpr std::size_t crc_at = 14;
constexpr std::uint16_t padding_id = 0x1986;  ///< Id of the extra field for padding, the one that USD itself writes.
constexpr std::uint32_t first_of_1980 = 0x00210000;

std::string little(std::uint64_t number, int bytes)
{
    std::string text;
    for (int i = 0; i < bytes; ++i)
        text += static_cast<char>(number >> (8 * i) & 255U);
    return text;
}

/// Fills up to the next multiple of 64 from `offset`, and says so itself: 4 bytes and zeros.
std::string padding(std::uint64_t offset)
{
    constexpr std::uint64_t least = 4;
    const std::uint64_t bytes = least + (zip_alignment - (offset + least) % zip_alignment) % zip_alignment;
    return little(padding_id, 2) + little(bytes - least, 2) + std::string(bytes - least, '\0');
}

/// The bytes that headers and directory have in common, from the version needed to the length of the name.
std::string common(std::uint32_t crc, std::uint64_t bytes, std::size_t name_bytes)
{
    constexpr int version_needed = 10;
    return little(version_needed, 2) + little(0, 2) + little(0, 2) + little(first_of_1980, 4) + little(crc, 4) +
           little(bytes, 4) + little(bytes, 4) + little(name_bytes, 2);
}

}  // namespace

ZipWriter::ZipWriter(std::filesystem::path file) : file_(std::move(file)), stream_(file_, std::ios::binary | std::ios::trunc)
{
    check_written();
}

void ZipWriter::check_written() const
{
    if (!stream_)
        throw Error(file_.string() + ": cannot be written: " + std::generic_category().message(errno));
}

void ZipWriter::put(std::string_view bytes)
{
    stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    check_written();
    offset_ += bytes.size();
    constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max() - 65536;  // Leaves room for the directory.
    if (offset_ > most)
        throw Error(file_.string() + ": exceeds the 4 GiB of a zip archive: write less to it");
}

void ZipWriter::begin(std::string name)
{
    end_entry();
    Entry& entry = entries_.emplace_back();
    entry.name = std::move(name);
    entry.header = offset_;
    const std::string extra = padding(offset_ + header_size + entry.name.size());
    put("PK\3\4" + common(0, 0, entry.name.size()) + little(extra.size(), 2) + entry.name + extra);
    entry.data = offset_;
}

void ZipWriter::write(std::string_view bytes)
{
    put(bytes);
    Entry& entry = entries_.back();
    entry.crc = checksum_of(std::as_bytes(std::span(bytes)), entry.crc);
}

/// Fills in what was unknown when the header was written.
void ZipWriter::end_entry()
{
    if (entries_.empty())
        return;
    Entry& entry = entries_.back();
    entry.bytes = offset_ - entry.data;
    const std::uint64_t end = offset_;
    stream_.seekp(static_cast<std::streamoff>(entry.header + crc_at));
    put(little(entry.crc, 4) + little(entry.bytes, 4) + little(entry.bytes, 4));
    stream_.seekp(static_cast<std::streamoff>(end));
    offset_ = end;
}

void ZipWriter::finish()
{
    end_entry();
    const std::uint64_t directory = offset_;
    for (const Entry& entry : entries_)
        put("PK\1\2" + little(10, 2) + common(entry.crc, entry.bytes, entry.name.size()) + std::string(12, '\0') +
            little(entry.header, 4) + entry.name);
    const std::uint64_t bytes = offset_ - directory;
    put("PK\5\6" + std::string(4, '\0') + little(entries_.size(), 2) + little(entries_.size(), 2) + little(bytes, 4) +
        little(directory, 4) + little(0, 2));
    stream_.close();
    check_written();
}

}  // namespace fresco
