#include <fresco/recordings/picture_checks.h>

#include <fresco/error.h>
#include <fresco/value.h>

#include <algorithm>
#include <fmt/format.h>

namespace fresco::recordings
{
namespace
{

constexpr std::size_t files_named = 5;

}  // namespace

std::string size_text(int width, int height)
{
    return fmt::format("{}x{}", width, height);
}

void refuse_missing(const std::vector<std::string>& missing, std::string_view rule)
{
    if (missing.empty())
        return;
    const auto named = std::span(missing).first(std::min(missing.size(), files_named));
    throw MissingInput(fmt::format("{} {} missing: {}{}; {}", missing.size(), missing.size() == 1 ? "file is" : "files are",
                                   fmt::join(named, ", "), missing.size() > files_named ? ", …" : "", rule));
}

void check_center(const Intrinsics& k, const std::string& source, const std::filesystem::path& picture)
{
    if (k.cx <= 0 || k.cy <= 0 || k.cx >= k.width || k.cy >= k.height)
        throw Error(source + ": the principal point (" + to_json(k.cx) + ", " + to_json(k.cy) + ") is outside " +
                    picture.string() + ", which is " + size_text(k.width, k.height) +
                    "; use intrinsics for pictures of this size");
}

void check_not_turned(const std::filesystem::path& file, const ImageHeader& header, const std::string& source)
{
    if (header.orientation != 1)
        throw Error(fmt::format("{}: its EXIF data rotates it (orientation {}), but {} is for the pixels as stored; remove the "
                                "tag (exiftool -Orientation= FILE)",
                                file.string(), header.orientation, source));
}

void check_depth_kind(const std::filesystem::path& file, const ImageHeader& header)
{
    if (header.bits > 0 && (header.bits != 16 || !header.gray))
        throw Error(fmt::format("{}: expected a depth picture (PNG, one channel of 16 bits), found {} bits{}", file.string(),
                                header.bits, header.gray ? "" : " and colors"));
}

}  // namespace fresco::recordings
