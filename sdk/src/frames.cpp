#include "artifact_files.h"
#include "reference.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/hash.h>
#include <fresco/image_io.h>
#include <fresco/run_context.h>
#include <fresco/value.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>

namespace fresco
{
namespace
{

namespace fs = std::filesystem;

constexpr double farthest_m = 1e7;
/// How many times its longer side a focal length or the principal point of a picture may be, or the other way.
constexpr double most_sides = 1e6;

Value picture_to_value(const PictureFile& picture, const ArtifactFolder& folder)
{
    if (picture.empty())
        return {};
    return Value::Map{{"ref", reference_to(picture.path, folder)}, {"hash", picture.hash}};
}

PictureFile picture_from(const Value& value, const ArtifactFolder& folder, const std::string& source)
{
    if (value.is_null())
        return {};
    try
    {
        return {referred_file(value.at("ref").as_string(), folder), value.at("hash").as_string()};
    }
    catch (const Error& error)
    {
        throw Error(source + ": " + error.what());
    }
}

Frame frame_from(const Value& value, const ArtifactFolder& folder, const std::string& source)
{
    Frame frame;
    frame.sequence = value.at("sequence").as_string();
    frame.name = value.at("name").as_string();
    frame.number = value.at("number").as_int();
    const std::string where = source + ": " + frame.sequence + "/" + frame.name;
    frame.color = detail::camera_from(value.at("color_camera"), where);
    frame.depth = detail::camera_from(value.at("depth_camera"), where);
    frame.color_picture = picture_from(value.at("color_picture"), folder, where);
    frame.depth_picture = picture_from(value.at("depth_picture"), folder, where);
    frame.depth_unit_m = value.at("depth_unit_m").as_double();
    return frame;
}

/// The part of `path` below `base`, whichever way each is written.
std::optional<std::string> really_below(const fs::path& path, const fs::path& base)
{
    const auto plain = detail::below(path, base);
    return plain ? plain : detail::below(fs::weakly_canonical(path), fs::weakly_canonical(base));
}

/// A picture that a program refers to, as the folder refers to it. The user's own files are part of what the result was made
/// from.
void settle_picture(PictureFile& picture, const ArtifactFolder& folder, const std::string& where, RunContext& run)
{
    picture.path = picture.path.lexically_normal();
    if (!fs::is_regular_file(picture.path))
        throw Error(where + ": no such picture: " + picture.path.string());
    if (const auto own = really_below(picture.path, folder.path))
        picture.path = folder.path / *own;
    else if (const auto stored = really_below(picture.path, folder.store / "objects"))
        picture.path = folder.store / "objects" / *stored;
    else if (really_below(picture.path, folder.store))
        throw Error(where + ": the picture " + picture.path.string() +
                    " will be gone when the program has ended: write it into the folder of this output");
    else
    {
        run.reads_file(picture.path);
        if (picture.hash.empty())
            picture.hash = file_hash(picture.path);
    }
}

void check_unchanged(const PictureFile& picture)
{
    if (!picture.hash.empty() && file_hash(picture.path) != picture.hash)
        throw Error(picture.path.string() + ": changed since the scan was read; run again to read it again");
}

const ImageIo& codec(const ImageIo* images, const fs::path& file)
{
    if (images == nullptr)
        throw Error(file.string() + ": no picture codec (option \"images\"); only NPY pictures can be read without one");
    return *images;
}

template <class T>
void check_size(const Raster<T>& picture, const Intrinsics& intrinsics, const fs::path& file)
{
    if (picture.width != intrinsics.width || picture.height != intrinsics.height)
        throw Error(fmt::format("{}: is {}x{} pixels; its intrinsics say {}x{}", file.string(), picture.width, picture.height,
                                intrinsics.width, intrinsics.height));
}

}  // namespace

Frames::~Frames() = default;

void Frames::save(const ArtifactFolder& folder) const
{
    Value::List list;
    for (const Frame& frame : frames)
        list.emplace_back(Value::Map{{"sequence", frame.sequence},
                                     {"name", frame.name},
                                     {"number", static_cast<std::int64_t>(frame.number)},
                                     {"color_camera", detail::to_value(frame.color)},
                                     {"depth_camera", detail::to_value(frame.depth)},
                                     {"color_picture", picture_to_value(frame.color_picture, folder)},
                                     {"depth_picture", picture_to_value(frame.depth_picture, folder)},
                                     {"depth_unit_m", frame.depth_unit_m}});
    write_file(folder.path / "frames.json", to_json(Value::Map{{"frames", std::move(list)}}, 1));
}

std::shared_ptr<Frames> Frames::load(const ArtifactFolder& folder)
{
    const fs::path file = folder.path / "frames.json";
    const Value root = detail::read_json_file(file);
    auto result = std::make_shared<Frames>();
    for (const Value& value : root.at("frames").as_list())
        result->frames.push_back(frame_from(value, folder, file.string()));
    return result;
}

std::vector<ExchangeForm> Frames::exchange_forms()
{
    return {{.files = {"frames.json"}, .taken_in_place = false}};
}

void Frames::write_exchange(const Exchange& to) const
{
    save({to.folder.path, {}});
}

std::shared_ptr<Frames> Frames::from_exchange(const Exchange& from)
{
    const std::string list = (from.folder.path / "frames.json").string();
    auto result = load(from.folder);
    if (result->frames.empty())
        throw Error(list + ": no frames in it");
    for (Frame& frame : result->frames)
        for (PictureFile* picture : {&frame.color_picture, &frame.depth_picture})
        {
            from.run.check_canceled();
            if (!picture->empty())
                settle_picture(*picture, from.folder, list + ": " + frame.sequence + "/" + frame.name, from.run);
        }
    return result;
}

Raster8 load_color(const Frame& frame, const ImageIo* images)
{
    if (frame.color_picture.empty())
        throw Error(frame.sequence + "/" + frame.name + ": has no color picture");
    const fs::path& file = frame.color_picture.path;
    check_unchanged(frame.color_picture);
    Raster8 picture = file.extension() == ".npy" ? detail::read_raster8(file, 3) : codec(images, file).read_rgb(file);
    check_size(picture, frame.color.intrinsics, file);
    return picture;
}

Raster16 load_depth_steps(const Frame& frame, const ImageIo* images)
{
    if (frame.depth_picture.empty())
        throw Error(frame.sequence + "/" + frame.name + ": has no depth picture");
    const fs::path& file = frame.depth_picture.path;
    check_unchanged(frame.depth_picture);
    Raster16 steps = file.extension() == ".npy" ? detail::read_raster16(file, 1) : codec(images, file).read_depth(file);
    check_size(steps, frame.depth.intrinsics, file);
    return steps;
}

RasterF load_depth(const Frame& frame, const ImageIo* images)
{
    const Raster16 steps = load_depth_steps(frame, images);
    RasterF depth(steps.width, steps.height);
    std::ranges::transform(steps.values, depth.values.begin(),
                           [&](std::uint16_t step)
                           { return step == 0 || step == 65535 ? 0.0F : static_cast<float>(step * frame.depth_unit_m); });
    return depth;
}

void check_camera(const Camera& camera, std::string_view source)
{
    const Intrinsics& k = camera.intrinsics;
    const auto fail = [&](const std::string& what) { throw Error(std::string(source) + ": " + what); };
    if (k.width < 1 || k.height < 1 || k.width > 65536 || k.height > 65536)
        fail(fmt::format("camera of {}x{} pixels; 1 to 65536 are accepted", k.width, k.height));
    if (!std::isfinite(k.fx) || !std::isfinite(k.fy) || k.fx <= 0 || k.fy <= 0)
        fail("focal lengths must be positive numbers");
    // Beyond, rays have no direction in the single precision of ray casters.
    const double side = std::max(k.width, k.height);
    for (const double focal : {k.fx, k.fy})
        if (focal < side / most_sides || focal > side * most_sides)
            fail(fmt::format("a focal length of {} pixels for a picture of {}x{}; from a millionth to a million times its longer "
                             "side are accepted",
                             to_json(focal), k.width, k.height));
    if (!std::isfinite(k.cx) || !std::isfinite(k.cy))
        fail("the principal point is not finite");
    if (std::abs(k.cx) > side * most_sides || std::abs(k.cy) > side * most_sides)
        fail("the principal point (" + to_json(k.cx) + ", " + to_json(k.cy) +
             ") is more than a million times the picture's longer side away");
    const double error = camera.world_from_camera.rotation_error();
    if (error > 1e-2)
        fail(std::isinf(error) ? "the pose has an entry that is not finite, or its rotation mirrors"
                               : "the pose's upper left 3x3 is not a rotation (it deviates by " +
                                     to_json(std::round(error * 1e4) / 1e4) + " from one; 0.01 is accepted)");
    const Vec3d& at = camera.world_from_camera.translation;
    for (const double along : {at.x, at.y, at.z})
        if (!(std::abs(along) <= farthest_m))
            fail("the camera is more than 1e7 m from the world's origin; the pose is damaged, or of another unit");
}

}  // namespace fresco
