#include "sens_file.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/recordings/parsing.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <bit>
#include <limits>

namespace sens
{

fresco::Raster16 unpack_depth(std::span<const std::byte> packed, int width, int height, const std::string& place)
{
    static_assert(std::endian::native == std::endian::little);
    const std::size_t expected = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * sizeof(std::uint16_t);
    const auto fail = [&](const std::string& what)
    {
        throw fresco::Error(
            fmt::format("{}: {}; expected a zlib-compressed depth picture of {} bytes: the file is damaged; copy it again", place,
                        what, expected));
    };
    if (packed.size() > std::numeric_limits<uInt>::max() || expected > std::numeric_limits<uInt>::max())
        fail("more than 4 GiB");
    // Deflate makes nothing more than 1032 times smaller: what cannot be whole takes no memory.
    if (packed.size() < expected / 1032)
        fail(fmt::format("{} packed bytes", packed.size()));
    fresco::Raster16 depth(width, height);
    z_stream stream = {};
    if (::inflateInit(&stream) != Z_OK)
        throw fresco::Error(place + ": zlib cannot start: out of memory");
    // zlib's interface is not const; it does not write there.
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(depth.values.data());
    stream.avail_out = static_cast<uInt>(expected);
    const int code = ::inflate(&stream, Z_FINISH);
    const std::size_t made = expected - stream.avail_out;
    ::inflateEnd(&stream);
    if (code != Z_STREAM_END)
        fail(code == Z_BUF_ERROR && made == expected ? "more" : "damaged data");
    if (made != expected)
        fail(fmt::format("{} bytes", made));
    return depth;
}

namespace
{

using fresco::recordings::ByteCursor;

constexpr std::uint32_t read_version = 4;
constexpr std::uint64_t longest_name = 4096;
constexpr std::uint64_t most_pixels = 200'000'000;
constexpr std::size_t matrix_bytes = 16 * sizeof(float);
constexpr std::size_t head_bytes = 4 * matrix_bytes + 2 * 4 + 4 * 4 + 4 + 8;  // From the matrices to the count of frames.
constexpr std::size_t frame_head_bytes = matrix_bytes + 4 * 8;

/// Walks the file; every read names what it was for.
class Walk
{
  public:
    explicit Walk(const SensFile& file) : file_(file) {}
    std::uint64_t offset() const { return offset_; }
    std::uint64_t left() const { return file_.size() - offset_; }
    std::vector<std::byte> take(std::uint64_t count, const std::string& what)
    {
        auto bytes = file_.read_at(offset_, count, what);
        offset_ += count;
        return bytes;
    }
    void pass(std::uint64_t count, const std::string& what)
    {
        if (count > left())
            fail(fmt::format(
                "{} has a declared length of {} bytes, but {} remain: the file is truncated or damaged; copy it again", what,
                count, left()));
        offset_ += count;
    }
    [[noreturn]] void fail(const std::string& text) const
    {
        throw fresco::Error(fmt::format("{}: byte {}: {}", file_.path().string(), offset_, text));
    }

  private:
    const SensFile& file_;
    std::uint64_t offset_ = 0;
};

std::vector<double> matrix_of(ByteCursor& cursor)
{
    std::vector<double> matrix(16);
    for (double& entry : matrix)
        entry = static_cast<double>(cursor.read<float>("a matrix"));
    return matrix;
}

ColorForm color_form_of(std::int32_t code, const Walk& walk)
{
    if (code < 0 || code > 2)
        walk.fail(fmt::format("compression {} of the color pictures; expected 0 (raw), 1 (PNG) or 2 (JPEG)", code));
    return static_cast<ColorForm>(code);
}

DepthForm depth_form_of(std::int32_t code, const Walk& walk)
{
    if (code != 0 && code != 1)
        walk.fail(fmt::format(
            "compression {} of the depth pictures; expected 0 (raw) or 1 (zlib){}", code,
            code == 2 ? ", not occi: export the scene with ScanNet's own reader and use the folder that it makes" : ""));
    return static_cast<DepthForm>(code);
}

void read_size(ByteCursor& cursor, const Walk& walk, const char* name, SensCamera& camera)
{
    const std::uint64_t width = cursor.read<std::uint32_t>("a size"), height = cursor.read<std::uint32_t>("a size");
    if (width < 1 || height < 1 || width > 65536 || height > 65536 || width * height > most_pixels)
        walk.fail(fmt::format("{} pictures of {}x{}; expected at most 65536 pixels per side and 200 million in all", name, width,
                              height));
    camera.width = static_cast<int>(width);
    camera.height = static_cast<int>(height);
}

}  // namespace

SensFile::SensFile(std::filesystem::path path) : path_(std::move(path))
{
    descriptor_ = fresco::uninterrupted([&] { return ::open(path_.c_str(), O_RDONLY | O_CLOEXEC); });
    struct stat state = {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &state) != 0 || !S_ISREG(state.st_mode))
    {
        if (descriptor_ >= 0)
            ::close(descriptor_);
        throw fresco::MissingInput(path_.string() + ": cannot open the file; expected a recording scene….sens");
    }
    size_ = static_cast<std::uint64_t>(state.st_size);
}

SensFile::~SensFile()
{
    ::close(descriptor_);
}

std::vector<std::byte> SensFile::read_at(std::uint64_t offset, std::uint64_t count, const std::string& what) const
{
    const auto fail = [&](const std::string& why)
    { throw fresco::Error(fmt::format("{}: byte {}: {} {}", path_.string(), offset, what, why)); };
    if (offset > size_ || count > size_ - offset)
        fail(fmt::format("needs {} bytes, but the file ends earlier: it is truncated or damaged; copy it again", count));
    std::vector<std::byte> bytes(static_cast<std::size_t>(count));
    for (std::size_t done = 0; done < bytes.size();)
    {
        const auto got = fresco::uninterrupted(
            [&] { return ::pread(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done)); });
        if (got <= 0)
            fail("cannot be read: the file changed or the disk failed");
        done += static_cast<std::size_t>(got);
    }
    return bytes;
}

SensIndex read_index(const SensFile& file)
{
    Walk walk(file);
    SensIndex index;
    const auto start = walk.take(12, "the version and the length of the sensor's name");
    ByteCursor first(start, file.path().string());
    if (const auto version = first.read<std::uint32_t>("the version"); version != read_version)
        throw fresco::Error(fmt::format("{}: byte 0: version {}; expected version 4, ScanNet's", file.path().string(), version));
    const auto name_length = first.read<std::uint64_t>("the name's length");
    if (name_length > longest_name)
        throw fresco::Error(
            fmt::format("{}: byte 4: the sensor's name has {} bytes; expected at most 4096: the file is damaged; copy it again",
                        file.path().string(), name_length));
    walk.pass(name_length, "the sensor's name");

    const auto head = walk.take(head_bytes, "the head");
    ByteCursor cursor(head, file.path().string());
    index.color.intrinsics = matrix_of(cursor);
    index.color.extrinsics = matrix_of(cursor);
    index.depth.intrinsics = matrix_of(cursor);
    index.depth.extrinsics = matrix_of(cursor);
    index.color_form = color_form_of(cursor.read<std::int32_t>("compression"), walk);
    index.depth_form = depth_form_of(cursor.read<std::int32_t>("compression"), walk);
    read_size(cursor, walk, "color", index.color);
    read_size(cursor, walk, "depth", index.depth);
    const auto shift = static_cast<double>(cursor.read<float>("the depth shift"));
    if (!(shift >= 1 && shift <= 1e6))
        walk.fail("the depth shift (steps per meter) must be from 1 to 1000000: the file is damaged; copy it again");
    index.depth_unit_m = 1 / shift;

    const auto count = cursor.read<std::uint64_t>("the count of frames");
    if (count > walk.left() / frame_head_bytes)
        walk.fail(fmt::format("{} frames do not fit into the remaining {} bytes: the file is truncated or damaged; copy it again",
                              count, walk.left()));
    for (std::uint64_t i = 0; i < count; ++i)
    {
        const std::string name = fmt::format("frame {}", i);
        const auto frame_head = walk.take(frame_head_bytes, "the head of " + name);
        ByteCursor own(frame_head, file.path().string());
        SensFrame frame;
        frame.world_from_depth = matrix_of(own);
        own.read<std::uint64_t>("a time");
        own.read<std::uint64_t>("a time");
        frame.color_bytes = own.read<std::uint64_t>("a size");
        frame.depth_bytes = own.read<std::uint64_t>("a size");
        frame.color_offset = walk.offset();
        walk.pass(frame.color_bytes, "the color picture of " + name);
        frame.depth_offset = walk.offset();
        walk.pass(frame.depth_bytes, "the depth picture of " + name);
        index.frames.push_back(std::move(frame));
    }
    return index;
}

}  // namespace sens
