#include "exif.h"
#include "picture_info.h"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <string_view>

namespace image_opencv
{
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
    app14 = 0xEE
};

bool is_frame(unsigned marker)
{
    return marker >= sof_baseline && marker <= sof_last && marker != dht && marker != jpg && marker != dac;
}

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
            if (!has_scan_)
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
        else if (code == app14 && begins_with(data, "Adobe"))
            has_adobe_ = true;
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
        bytes_.check_size(at + 1, bytes_.u16(at + 3), bytes_.u16(at + 1));
        components_ = bytes_.u8(at + 5);
        if (components_ != 1 && components_ != 3 && components_ != 4)
            bytes_.fail(at + 5, fmt::format("{} color components; expected 1, 3 or 4", components_));
        info_.format = PictureFormat::jpeg;
        info_.height = static_cast<int>(bytes_.u16(at + 1));
        info_.width = static_cast<int>(bytes_.u16(at + 3));
        info_.is_gray = components_ == 1;
        frame_at_ = at;
        has_frame_ = true;
    }

    /// Moves behind the entropy-coded data: to the next FF that is neither stuffing, nor a restart marker, nor a fill byte.
    void scan(std::size_t begin)
    {
        if (!has_frame_)
            bytes_.fail(begin, "picture data before the frame header");
        has_scan_ = true;
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
    unsigned components_ = 0;
    bool has_adobe_ = false;
    bool has_frame_ = false;
    bool has_scan_ = false;
    bool ended_ = false;
};

}  // namespace

PictureInfo check_jpeg(std::span<const std::byte> bytes, std::string_view source, Walk walk)
{
    return JpegWalk(bytes, source).read(walk);
}

}  // namespace image_opencv
