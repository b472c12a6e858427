#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/html.h>
#include <fresco/preview.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <utility>

namespace fresco
{
namespace
{

constexpr int jpeg_quality = 82;
constexpr std::uintmax_t most_video_bytes = 8'000'000;

Raster8 without_alpha(const Raster8& pixels)
{
    Raster8 opaque(pixels.width, pixels.height, 3);
    for (std::size_t i = 0; i < opaque.values.size() / 3; ++i)
        for (std::size_t c = 0; c < 3; ++c)
        {
            const int alpha = pixels.values[4 * i + 3];
            opaque.values[3 * i + c] =
                static_cast<std::uint8_t>((pixels.values[4 * i + c] * alpha + 255 * (255 - alpha) + 127) / 255);
        }
    return opaque;
}

std::string megabytes(std::uintmax_t bytes)
{
    const std::uintmax_t tenths = (bytes + 50'000) / 100'000;
    return fmt::format("{}.{} MB", tenths / 10, tenths % 10);
}

}  // namespace

void Artifact::preview(Preview&) const {}

void Preview::append(std::string_view list, Value entry)
{
    if (value_.find(list) == nullptr)
        value_.set(list, Value::List{});
    value_.find(list)->as_list().push_back(std::move(entry));
}

void Preview::picture(const std::string& name, const Raster8& pixels, Value::Map more)
{
    Value::Map entry{{"name", name},
                     {"uri", data_uri("image/jpeg", images.encode_jpeg(small_copy(pixels, longest_px), jpeg_quality))}};
    std::ranges::move(more, std::back_inserter(entry));
    append("pictures", std::move(entry));
}

void Preview::video(const std::string& name, const std::filesystem::path& file)
{
    const std::uintmax_t bytes = std::filesystem::file_size(file);
    if (bytes > std::min(most_video_bytes, video_bytes))
        throw Error(name + ": a video of " + megabytes(bytes) + " is not put into the page, which takes " +
                    (bytes > most_video_bytes ? megabytes(most_video_bytes) + " at most" : megabytes(video_bytes) + " more") +
                    "; open the file");
    append("pictures",
           Value::Map{{"name", name}, {"uri", data_uri("video/" + file.extension().string().substr(1), read_file(file))}});
    video_bytes -= bytes;
}

void Preview::note(const std::string& text)
{
    append("notes", text);
}

Raster8 small_copy(const Raster8& pixels, int longest_px)
{
    if (pixels.channels == 4)
        return small_copy(without_alpha(pixels), longest_px);
    const double scale = static_cast<double>(longest_px) / std::max(pixels.width, pixels.height);
    const auto side = [&](int px) { return std::max(1, static_cast<int>(std::lround(px * scale))); };
    return scale < 1 ? resized(pixels, side(pixels.width), side(pixels.height)) : pixels;
}

std::vector<std::size_t> evenly_spread(std::size_t size, std::size_t count)
{
    std::vector<std::size_t> chosen;
    const std::size_t taken = std::min(size, count);
    for (std::size_t i = 0; i < taken; ++i)
        chosen.push_back((2 * i + 1) * size / (2 * taken));
    return chosen;
}

bool is_picture(const std::filesystem::path& file)
{
    const std::string extension = file.extension().string();
    return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

}  // namespace fresco
