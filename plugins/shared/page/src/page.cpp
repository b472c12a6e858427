#include <fresco/page/page.h>

#include "packed_mesh.h"

#include <fresco/camera.h>
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/images/filters.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <utility>

namespace fresco::page
{
namespace
{

constexpr int jpeg_quality = 82;
constexpr std::uintmax_t most_video_bytes = 8'000'000;

std::string base64(std::span<const std::byte> bytes)
{
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3)
    {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        unsigned bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8U | (k < count ? std::to_integer<unsigned>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k)
            text += k <= count ? digits[bits >> (18 - 6 * k) & 63U] : '=';
    }
    return text;
}

std::string megabytes(std::uintmax_t bytes)
{
    const std::uintmax_t tenths = (bytes + 50'000) / 100'000;
    return fmt::format("{}.{} MB", tenths / 10, tenths % 10);
}

Value triple(Vec3d v)
{
    return Value::List{v.x, v.y, v.z};
}

}  // namespace

std::string data_uri(std::string_view media_type, std::span<const std::byte> bytes)
{
    return "data:" + std::string(media_type) + ";base64," + base64(bytes);
}

void add_picture(PageEntry& entry, const ImageIo& images, const std::string& name, const Raster8& pixels, Value::Map more)
{
    const auto jpeg = images.encode_jpeg(small_copy(pixels, entry.longest_px), jpeg_quality);
    Value::Map picture{{"name", name}, {"uri", data_uri("image/jpeg", jpeg)}};
    std::ranges::move(more, std::back_inserter(picture));
    entry.append("pictures", std::move(picture));
}

void add_video(PageEntry& entry, const std::string& name, const std::filesystem::path& file)
{
    const std::uintmax_t bytes = std::filesystem::file_size(file);
    if (bytes > std::min(most_video_bytes, entry.video_bytes))
        throw Error(
            name + ": a video of " + megabytes(bytes) + " is not put into the page, which takes " +
            (bytes > most_video_bytes ? megabytes(most_video_bytes) + " at most" : megabytes(entry.video_bytes) + " more") +
            "; open the file");
    const std::string media_type = "video/" + file.extension().string().substr(1);
    entry.append("pictures", Value::Map{{"name", name}, {"uri", data_uri(media_type, read_file(file))}});
    entry.video_bytes -= bytes;
}

Raster8 small_copy(const Raster8& pixels, int longest_px)
{
    if (pixels.channels == 4)
        return small_copy(on_gray(pixels, 255), longest_px);
    const double scale = static_cast<double>(longest_px) / std::max(pixels.width, pixels.height);
    const auto side = [&](int px) { return std::max(1, static_cast<int>(std::lround(px * scale))); };
    return scale < 1 ? resized(pixels, side(pixels.width), side(pixels.height)) : pixels;
}

Value::Map pose(const Camera& camera)
{
    const RigidTransform& world_from_camera = camera.world_from_camera;
    return {{"position", triple(world_from_camera.translation)},
            {"forward", triple(world_from_camera.direction({0, 0, 1}))},
            {"up", triple(world_from_camera.direction({0, -1, 0}))}};
}

Value cameras(const Frames& frames)
{
    std::vector<RigidTransform> poses;
    Vec3d looking;
    for (const Frame& frame : frames.frames)
    {
        poses.push_back(frame.color.world_from_camera);
        looking += poses.back().direction({0, 0, 1}) * (1.0 / static_cast<double>(frames.frames.size()));
    }
    Value::Map entry = pose(frames.frames.at(0).color);
    entry[2].second = triple(cameras_up(poses).value_or(Vec3d{0, 0, 1}));
    entry.emplace_back("looking", triple(looking));
    return entry;
}

Value room(const Mesh& mesh, std::span<const std::byte> texture)
{
    const auto numbers = [](const std::array<double, 3>& values) { return Value(Value::List(values.begin(), values.end())); };
    const PackedMesh packed = pack_mesh(mesh);
    return Value::Map{{"atlas", atlas_id(mesh)},
                      {"vertices", packed.vertices},
                      {"triangles", packed.triangles},
                      {"low", numbers(packed.low)},
                      {"extent", numbers(packed.extent)},
                      {"geometry", base64(packed.bytes)},
                      {"texture", data_uri("image/jpeg", texture)}};
}

Value relief(const std::string& atlas, std::span<const std::byte> normals, std::span<const std::byte> roughness)
{
    return Value::Map{
        {"atlas", atlas}, {"normals", data_uri("image/jpeg", normals)}, {"roughness", data_uri("image/jpeg", roughness)}};
}

}  // namespace fresco::page
