#include "zip.h"

#include <fresco/error.h>

#include <cerrno>
#include <limits>
#include <system_error>
#include <zlib.h>

using namespace fresco;

namespace
{
constexpr std::size_t local_header_bytes = 30;
constexpr std::size_t crc_at = 14;
constexpr std::uint16_t padding_id = 0x1986;  ///< Of the extra field that pads; the one that USD itself writes.
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

/// What local headers and the directory have in common, from the version needed to the length of the name.
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
        throw Error(file_.string() + ": exceeds the 4 GiB of a usdz file: decimate the mesh or set max_texture_px");
}

void ZipWriter::begin(std::string name)
{
    end_entry();
    Entry& entry = entries_.emplace_back();
    entry.name = std::move(name);
    entry.header = offset_;
    const std::string extra = padding(offset_ + local_header_bytes + entry.name.size());
    put("PK\3\4" + common(0, 0, entry.name.size()) + little(extra.size(), 2) + entry.name + extra);
    entry.data = offset_;
}

void ZipWriter::write(std::string_view bytes)
{
    put(bytes);
    Entry& entry = entries_.back();
    entry.crc = static_cast<std::uint32_t>(crc32_z(entry.crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// What was unknown when its header was written.
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
