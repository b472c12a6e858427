#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/npy.h>

#include <fmt/format.h>
#include <utility>

namespace fresco::detail
{

template <class T>
Raster<T> read_raster(const std::filesystem::path& file, int channels)
{
    Raster<T> raster = to_raster<T>(read_npy(file), file.string());
    if (channels == 0 ? raster.channels < 1 || raster.channels > 4 : raster.channels != channels)
        throw Error(fmt::format("{}: {} channels; expected {}", file.string(), raster.channels,
                                channels == 0 ? "1 to 4" : std::to_string(channels)));
    return raster;
}

Value to_value(const Camera& camera)
{
    const Intrinsics& k = camera.intrinsics;
    const auto& r = camera.world_from_camera.rotation.m;
    const Vec3d& at = camera.world_from_camera.translation;
    Value::List pose{r[0], r[1], r[2], at.x, r[3], r[4], r[5], at.y, r[6], r[7], r[8], at.z};
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

JsonFile::JsonFile(const std::filesystem::path& file)
    : value_(parse_json(read_text_file(file, std::size_t{1} << 30U), file.string())), root_(value_, file.string())
{
}

template Raster8 read_raster(const std::filesystem::path& file, int channels);
template Raster16 read_raster(const std::filesystem::path& file, int channels);
template RasterF read_raster(const std::filesystem::path& file, int channels);

}  // namespace fresco::detail
