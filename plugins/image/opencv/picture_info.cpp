#include "picture_bytes.h"

#include <fresco/files_io.h>
#include <fresco/image_io.h>

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <vector>

namespace image_opencv
{
namespace
{

constexpr unsigned orientation_tag = 0x0112;
constexpr unsigned type_short = 3;
constexpr std::size_t entry_bytes = 12;

/// Numbers of the block's own byte order; 0 beyond its end.
struct Tiff
{
    std::span<const std::byte> bytes;
    bool big_endian;

    std::uint32_t number(std::size_t at, std::size_t size) const
    {
        if (at > bytes.size() || size > bytes.size() - at)
            return 0;
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < size; ++i)
            value = value << 8U | std::to_integer<std::uint32_t>(bytes[at + (big_endian ? i : size - 1 - i)]);
        return value;
    }
};

}  // namespace

int exif_orientation(std::span<const std::byte> bytes)
{
    if (bytes.size() < 8)
        return 1;
    const Tiff tiff{bytes, bytes[0] == std::byte{'M'}};
    const std::byte mark{static_cast<unsigned char>(tiff.big_endian ? 'M' : 'I')};
    if (bytes[0] != mark || bytes[1] != mark || tiff.number(2, 2) != 42)
        return 1;
    const std::size_t directory = tiff.number(4, 4);
    const std::size_t entries = tiff.number(directory, 2);
    for (std::size_t i = 0; i < entries; ++i)
    {
        const std::size_t entry = directory + 2 + i * entry_bytes;
        if (tiff.number(entry, 2) != orientation_tag)
            continue;
        const auto value = tiff.number(entry + 8, 2);
        return tiff.number(entry + 2, 2) == type_short && value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
    }
    return 1;
}

namespace
{

constexpr std::array<unsigned, 8> signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr std::uint32_t max_chunk_bytes = 0x7FFFFFFF;
/// Profiles of printers have some; a few bytes of zlib may claim any number.
constexpr std::size_t max_profile_bytes = std::size_t{1} << 24U;

constexpr std::uint32_t name(const char (&text)[5])
{
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i)
        value = value << 8U | static_cast<unsigned char>(text[i]);
    return value;
}

enum ColorType : unsigned
{
    gray = 0,
    palette = 3,
    with_alpha = 4  ///< Bit that is set in color types 4 and 6.
};

bool depth_allowed(unsigned color_type, unsigned bits)
{
    // By color type, the sum of the numbers of bits that it may have, all powers of two.
    constexpr std::array<unsigned, 7> allowed{1 + 2 + 4 + 8 + 16, 0, 8 + 16, 1 + 2 + 4 + 8, 8 + 16, 0, 8 + 16};
    return color_type < allowed.size() && std::has_single_bit(bits) && (allowed[color_type] & bits) != 0;
}

/// The profile in an iCCP chunk: a name, a 0, the method 0, zlib's data. `at`: where it stands, for errors.
std::vector<std::byte> inflated_profile(const PictureBytes& file, std::size_t at, std::span<const std::byte> chunk)
{
    const auto name_end = std::ranges::find(chunk, std::byte{0});
    const auto begin = static_cast<std::size_t>(name_end - chunk.begin()) + 2;
    if (begin > chunk.size() || name_end[1] != std::byte{0})
        file.fail(at, "the color profile (iCCP) has no name or an unknown compression: the file is damaged");
    constexpr std::size_t step = std::size_t{1} << 16U;
    std::vector<std::byte> profile;
    z_stream stream{};
    if (inflateInit(&stream) != Z_OK)
        file.fail(at, "no memory for the color profile");
    // zlib reads through a pointer that is not const; it does not write to it.
    stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(chunk.data() + begin));
    stream.avail_in = static_cast<uInt>(chunk.size() - begin);
    int state = Z_OK;
    while (state == Z_OK && profile.size() <= max_profile_bytes)
    {
        profile.resize(profile.size() + step);
        stream.next_out = reinterpret_cast<Bytef*>(profile.data() + profile.size() - step);
        stream.avail_out = step;
        state = inflate(&stream, Z_NO_FLUSH);
    }
    profile.resize(stream.total_out);
    inflateEnd(&stream);
    if (state != Z_STREAM_END)
        file.fail(at, profile.size() > max_profile_bytes ? "a color profile (iCCP) of more than 16 MiB"
                                                         : "the color profile (iCCP) is damaged; copy the file again");
    return profile;
}

class PngWalk
{
  public:
    PngWalk(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes, source) {}

    PictureInfo read(Walk walk)
    {
        for (std::size_t i = 0; i < signature.size(); ++i)
            if (bytes_.u8(i) != signature[i])
                bytes_.fail(i, "not a PNG file: its signature is damaged");
        header();
        if (walk == Walk::whole)
            while (!ended_)
                chunk();
        return info_;
    }

  private:
    /// Reads one chunk's frame, checks it and moves behind it.
    std::span<const std::byte> frame(std::uint32_t& type)
    {
        begin_ = next_;
        const std::uint32_t length = bytes_.u32(begin_);
        if (length > max_chunk_bytes)
            bytes_.fail(begin_, fmt::format("a chunk of {} bytes: the file is damaged", length));
        type = bytes_.u32(begin_ + 4);
        const auto checked = bytes_.part(begin_ + 4, std::size_t{length} + 4);
        next_ = begin_ + 12 + length;
        if (bytes_.u32(next_ - 4) != crc32_z(0, reinterpret_cast<const Bytef*>(checked.data()), checked.size()))
            bytes_.fail(begin_, "the chunk's checksum is wrong: the file is damaged; copy it again");
        return checked.subspan(4);
    }

    void header()
    {
        std::uint32_t type = 0;
        const auto data = frame(type);
        if (type != name("IHDR") || data.size() != 13)
            bytes_.fail(begin_, "expected an IHDR chunk of 13 bytes");
        const std::size_t at = begin_ + 8;
        bytes_.take_size(info_, at, bytes_.u32(at), bytes_.u32(at + 4));
        info_.bits = static_cast<int>(bytes_.u8(at + 8));
        color_type_ = bytes_.u8(at + 9);
        info_.is_gray = color_type_ == gray;
        info_.has_alpha = (color_type_ & with_alpha) != 0;
        if (!depth_allowed(color_type_, bytes_.u8(at + 8)))
            bytes_.fail(at + 8, fmt::format("color type {} with {} bits is not defined by PNG", color_type_, info_.bits));
        if (bytes_.u8(at + 10) != 0 || bytes_.u8(at + 11) != 0 || bytes_.u8(at + 12) > 1)
            bytes_.fail(at + 10, "unknown compression, filter or interlace method");
    }

    void chunk()
    {
        std::uint32_t type = 0;
        const auto data = frame(type);
        if (type == name("IHDR"))
            bytes_.fail(begin_, "a second IHDR chunk");
        if (type == name("IDAT"))
        {
            if (data_ended_)
                bytes_.fail(begin_, "the IDAT chunks are not consecutive");
            if (color_type_ == palette && !has_palette_)
                bytes_.fail(begin_, "the PLTE chunk is missing");
            has_data_ = true;
            return;
        }
        data_ended_ = has_data_;
        if (type == name("PLTE"))
            has_palette_ = true;
        else if (type == name("tRNS"))
        {
            info_.has_alpha = true;
            if (color_type_ == gray && data.size() == 2)
                info_.transparent_gray = static_cast<std::uint16_t>(bytes_.u16(begin_ + 8));
        }
        else if (type == name("eXIf"))
            info_.orientation = exif_orientation(data);
        else if (type == name("iCCP"))
            info_.profile = inflated_profile(bytes_, begin_, data);
        else if (type == name("IEND"))
        {
            if (!has_data_)
                bytes_.fail(begin_, "the picture has no IDAT chunk");
            ended_ = true;
        }
    }

    PictureBytes bytes_;
    PictureInfo info_;
    std::size_t begin_ = 0;
    std::size_t next_ = signature.size();
    unsigned color_type_ = 0;
    bool has_palette_ = false;
    bool has_data_ = false;
    bool data_ended_ = false;
    bool ended_ = false;
};

}  // namespace

PictureInfo check_png(std::span<const std::byte> bytes, std::string_view source, Walk walk)
{
    return PngWalk(bytes, source).read(walk);
}

namespace
{

// Marker codes of ITU-T T.81, table B.1.
enum Marker : unsigned
{
    tem = 0x01,
    sof_baseline = 0xC0,
    sof_extended = 0xC1,
    sof_progressive = 0xC2,
    dht = 0xC4,
    jpg = 0xC8,
    dac = 0xCC,
    sof_last = 0xCF,
    rst_first = 0xD0,
    rst_last = 0xD7,
    soi = 0xD8,
    eoi = 0xD9,
    sos = 0xDA,
    app1 = 0xE1,
    app2 = 0xE2,
    app14 = 0xEE
};

bool is_frame(unsigned marker)
{
    return marker >= sof_baseline && marker <= sof_last && marker != dht && marker != jpg && marker != dac;
}

constexpr int most_scans = 100;
constexpr std::string_view icc_mark("ICC_PROFILE\0", 12);

bool begins_with(std::span<const std::byte> bytes, std::string_view text)
{
    return bytes.size() >= text.size() && std::memcmp(bytes.data(), text.data(), text.size()) == 0;
}

class JpegWalk
{
  public:
    JpegWalk(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes, source) {}

    PictureInfo read(Walk walk)
    {
        if (bytes_.u16(0) != (0xFF00U | soi))
            bytes_.fail(0, "not a JPEG file: expected the marker SOI");
        next_ = 2;
        while (walk == Walk::whole ? !ended_ : !has_frame_)
            segment();
        if (walk == Walk::whole && components_ == 4 && !has_adobe_)
            bytes_.fail(frame_at_,
                        "a CMYK picture without an Adobe marker, so whether 0 means no ink is unknown; convert it to RGB");
        join_profile();
        return info_;
    }

  private:
    unsigned marker()
    {
        if (bytes_.u8(next_) != 0xFF)
            bytes_.fail(next_, "expected a marker: the file is damaged");
        // Any number of fill bytes may stand before the code.
        while (bytes_.u8(next_) == 0xFF)
            ++next_;
        return bytes_.u8(next_++);
    }

    void segment()
    {
        const std::size_t begin = next_;
        const unsigned code = marker();
        if (code == eoi)
        {
            if (scans_ == 0)
                bytes_.fail(begin, "the picture has no data: the file is damaged");
            ended_ = true;
            return;
        }
        if (code <= tem || code == soi || (code >= rst_first && code <= rst_last))
            bytes_.fail(begin, "unexpected marker: the file is damaged");
        const std::size_t length = bytes_.u16(next_);
        if (length < 2)
            bytes_.fail(next_, fmt::format("a segment of {} bytes: the file is damaged", length));
        const std::size_t at = next_ + 2;
        const auto data = bytes_.part(at, length - 2);
        next_ += length;
        if (is_frame(code))
            frame(code, at, data.size());
        else if (code == sos)
            scan(begin);
        else if (code == app1 && begins_with(data, std::string_view("Exif\0\0", 6)))
            info_.orientation = exif_orientation(data.subspan(6));
        else if (code == app2 && begins_with(data, icc_mark) && data.size() > icc_mark.size() + 2)
            take_profile_piece(at + icc_mark.size(), data.subspan(icc_mark.size() + 2));
        else if (code == app14 && begins_with(data, "Adobe"))
            has_adobe_ = true;
    }

    /// A profile larger than a segment comes in numbered pieces, in any order (ICC.1:2010, B.4).
    void join_profile()
    {
        for (std::size_t i = 0; i < profile_pieces_.size(); ++i)
        {
            const auto& piece = profile_pieces_[i];
            if (piece.empty())
                bytes_.fail(profile_at_,
                            fmt::format("piece {} of {} of the color profile is missing: the file is damaged; copy it "
                                        "again",
                                        i + 1, profile_pieces_.size()));
            info_.profile.insert(info_.profile.end(), piece.begin(), piece.end());
        }
    }

    void take_profile_piece(std::size_t at, std::span<const std::byte> data)
    {
        const std::size_t number = bytes_.u8(at);
        const std::size_t count = bytes_.u8(at + 1);
        if (profile_pieces_.empty())
            profile_pieces_.resize(count);
        if (number < 1 || number > count || count != profile_pieces_.size())
            bytes_.fail(at, fmt::format("piece {} of {} of a color profile of {}: the file is damaged", number, count,
                                        profile_pieces_.size()));
        profile_pieces_[number - 1] = data;
        profile_at_ = at;
    }

    void frame(unsigned code, std::size_t at, std::size_t size)
    {
        if (has_frame_)
            bytes_.fail(at, "a second frame header");
        if (code != sof_baseline && code != sof_extended && code != sof_progressive)
            bytes_.fail(at, "a lossless, hierarchical or arithmetic-coded JPEG; expected baseline or progressive");
        if (size < 6 || size != 6 + 3 * std::size_t{bytes_.u8(at + 5)})
            bytes_.fail(at, "a frame header of the wrong length: the file is damaged");
        if (const unsigned precision = bytes_.u8(at); precision != 8)
            bytes_.fail(at, fmt::format("{} bits per sample; expected 8", precision));
        bytes_.take_size(info_, at + 1, bytes_.u16(at + 3), bytes_.u16(at + 1));
        components_ = bytes_.u8(at + 5);
        if (components_ != 1 && components_ != 3 && components_ != 4)
            bytes_.fail(at + 5, fmt::format("{} color components; expected 1, 3 or 4", components_));
        info_.is_gray = components_ == 1;
        frame_at_ = at;
        has_frame_ = true;
    }

    /// Moves behind the entropy-coded data: to the next FF that is neither stuffing, nor a restart marker, nor a fill byte.
    void scan(std::size_t begin)
    {
        if (!has_frame_)
            bytes_.fail(begin, "picture data before the frame header");
        // Each scan passes over the whole picture, so that a small file with many of them keeps the decoder busy for minutes.
        if (++scans_ > most_scans)
            bytes_.fail(begin, fmt::format("the picture is stored in more than {} scans, where progressive JPEGs have about ten; "
                                           "save it again with another program",
                                           most_scans));
        for (;;)
        {
            const auto rest = bytes_.part(next_, bytes_.size() - next_);
            const auto found = std::find(rest.begin(), rest.end(), std::byte{0xFF});
            next_ += static_cast<std::size_t>(found - rest.begin());
            const unsigned code = bytes_.u8(next_ + 1);
            if (code == 0xFF)
                next_ += 1;
            else if (code == 0 || (code >= rst_first && code <= rst_last))
                next_ += 2;
            else
                return;
        }
    }

    PictureBytes bytes_;
    PictureInfo info_;
    std::size_t next_ = 0;
    std::size_t frame_at_ = 0;
    std::vector<std::span<const std::byte>> profile_pieces_;
    std::size_t profile_at_ = 0;
    unsigned components_ = 0;
    bool has_adobe_ = false;
    bool has_frame_ = false;
    int scans_ = 0;
    bool ended_ = false;
};

}  // namespace

PictureInfo check_jpeg(std::span<const std::byte> bytes, std::string_view source, Walk walk)
{
    return JpegWalk(bytes, source).read(walk);
}

namespace
{

// Holds the size of any PNG and WebP, and of all JPEGs but those with large thumbnails before it.
constexpr std::size_t prefix_bytes = std::size_t{1} << 16U;

std::vector<std::byte> read_prefix(const std::filesystem::path& file)
{
    std::vector<std::byte> bytes(prefix_bytes);
    std::ifstream stream(file, std::ios::binary);
    if (!stream || std::filesystem::is_directory(file))
        throw fresco::MissingInput(file.string() + ": the picture cannot be opened");
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(stream.gcount()));
    return bytes;
}

}  // namespace

PictureInfo check_picture(std::span<const std::byte> bytes, std::string_view source, Walk walk)
{
    const PictureBytes picture(bytes, source);
    if (picture.u8(0) == 0x89)
        return check_png(bytes, source, walk);
    if (picture.u8(0) == 0xFF)
        return check_jpeg(bytes, source, walk);
    if (picture.has(0, "RIFF") && picture.has(8, "WEBP"))
        return check_webp(bytes, source, walk);
    if (picture.has(4, "ftyp"))
        return check_heif(bytes, source, walk);
    if (picture.has(0, "BM"))
        return check_bmp(bytes, source, walk);
    for (const auto& format : fresco::picture_formats())
        if (format.extensions.empty() && picture.has(format.begins_at, format.begins.front()))
            picture.fail(0, format.name);
    picture.fail(0, "not a PNG, JPEG, WebP, HEIC, AVIF or BMP file; ImageMagick makes one of most others: convert FILE FILE.png");
}

PictureInfo picture_size(const std::filesystem::path& file)
{
    const auto prefix = read_prefix(file);
    try
    {
        return check_picture(prefix, file.string(), Walk::size);
    }
    catch (const CutPicture&)
    {
        if (prefix.size() < prefix_bytes)
            throw;
        return check_picture(fresco::read_file(file), file.string(), Walk::size);
    }
}

}  // namespace image_opencv
