#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/npy.h>

#include <fmt/format.h>
#include <limits>
#include <utility>

namespace fresco::detail
{

template <class T>
void write_raster(const std::filesystem::path& file, const Raster<T>& raster)
{
    std::vector<std::size_t> shape{static_cast<std::size_t>(raster.height), static_cast<std::size_t>(raster.width)};
    if (raster.channels != 1)
        shape.push_back(static_cast<std::size_t>(raster.channels));
    write_npy(file, shape, std::span<const T>(raster.values));
}

template <class T>
Raster<T> read_raster(const std::filesystem::path& file, int channels)
{
    const NpyArray array = read_npy(file);
    const auto fail = [&](const std::string& what) { throw Error(file.string() + ": " + what); };
    if (array.shape.size() != 2 && array.shape.size() != 3)
        fail("expected an array H x W or H x W x C");
    constexpr std::size_t max_extent = 1U << 20U;
    if (array.shape[0] > max_extent || array.shape[1] > max_extent)
        fail("larger than 1048576 pixels along a side");
    const std::size_t found = array.shape.size() == 3 ? array.shape[2] : 1;
    if (channels == 0 ? found < 1 || found > 4 : found != static_cast<std::size_t>(channels))
        fail(fmt::format("{} channels; expected {}", found, channels == 0 ? "1 to 4" : std::to_string(channels)));
    Raster<T> raster;
    raster.height = static_cast<int>(array.shape[0]);
    raster.width = static_cast<int>(array.shape[1]);
    raster.channels = static_cast<int>(found);
    try
    {
        const auto values = array.as<T>();
        raster.values.assign(values.begin(), values.end());
    }
    catch (const Error& error)
    {
        fail(error.what());
    }
    return raster;
}

Value to_value(const Camera& camera)
{
    const Intrinsics& k = camera.intrinsics;
    Value::List pose;
    const RigidTransform& t = camera.world_from_camera;
    const double translation[] = {t.translation.x, t.translation.y, t.translation.z};
    for (int row = 0; row < 3; ++row)
    {
        for (int column = 0; column < 3; ++column)
            pose.emplace_back(t.rotation(row, column));
        pose.emplace_back(translation[row]);
    }
    return Value::Map{{"width", k.width},
                      {"height", k.height},
                      {"fx", k.fx},
                      {"fy", k.fy},
                      {"cx", k.cx},
                      {"cy", k.cy},
                      {"world_from_camera", std::move(pose)}};
}

Camera camera_from(const JsonPlace& place)
{
    place.has_only({"width", "height", "fx", "fy", "cx", "cy", "world_from_camera"});
    Camera camera;
    camera.intrinsics = {place["width"].size(), place["height"].size(), place["fx"].number(),
                         place["fy"].number(),  place["cx"].number(),   place["cy"].number()};
    // 3 x 4, row-major.
    const auto pose = place["world_from_camera"].numbers(12);
    RigidTransform& t = camera.world_from_camera;
    t.rotation.m = {pose[0], pose[1], pose[2], pose[4], pose[5], pose[6], pose[8], pose[9], pose[10]};
    t.translation = {pose[3], pose[7], pose[11]};
    check_camera(camera, place.place());
    return camera;
}

Value read_json_file(const std::filesystem::path& file)
{
    return parse_json(read_text_file(file, std::size_t{1} << 30U), file.string());
}

template void write_raster(const std::filesystem::path& file, const Raster8& raster);
template void write_raster(const std::filesystem::path& file, const Raster16& raster);
template void write_raster(const std::filesystem::path& file, const RasterF& raster);
template Raster8 read_raster(const std::filesystem::path& file, int channels);
template Raster16 read_raster(const std::filesystem::path& file, int channels);
template RasterF read_raster(const std::filesystem::path& file, int channels);

}  // namespace fresco::detail
