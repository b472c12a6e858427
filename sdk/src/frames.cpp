#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/run_context.h>
#include <fresco/value.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <optional>
#include <set>
#include <utility>

namespace fresco
{
namespace
{

namespace fs = std::filesystem;

constexpr double farthest_m = 1e7;
/// How many times the focal length a picture's longer side may be: it then spans 177.7 degrees, and pixels at its border see 2500
/// times less than in its middle.
constexpr double widest_sides = 100;
/// How many times its longer side a picture's focal length may be, which then spans 20 arc seconds, as a telescope does; and how
/// far off its principal point.
constexpr double longest_sides = 1e4;

Value picture_to_value(const PictureFile& picture, const ArtifactFolder& folder)
{
    if (picture.empty())
        return {};
    return Value::Map{{"ref", reference_to(picture.path, folder)}, {"hash", picture.hash}};
}

PictureFile picture_from(const JsonPlace& place, const ArtifactFolder& folder)
{
    if (place.value().is_null())
        return {};
    place.has_only({"ref", "hash"});
    PictureFile picture;
    const std::string reference = place["ref"].text();
    try
    {
        picture.path = referred_file(reference, folder);
    }
    catch (const Error& error)
    {
        place.fail(error.what());
    }
    if (const auto hash = place.find("hash"))
        picture.hash = hash->text();
    return picture;
}

std::string safe_name_from(const JsonPlace& place)
{
    const std::string& name = place.text();
    const auto is_safe = [](char c)
    { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.'; };
    if (name.empty() || name.front() == '.' || !std::ranges::all_of(name, is_safe))
        place.fail("\"" + name + "\" cannot be part of a file's name; expected letters, digits and -_., not a dot first");
    return name;
}

Frame frame_from(const JsonPlace& place, const ArtifactFolder& folder)
{
    place.has_only(
        {"sequence", "name", "number", "color_camera", "depth_camera", "color_picture", "depth_picture", "depth_unit_m", "mask"});
    Frame frame;
    frame.sequence = safe_name_from(place["sequence"]);
    frame.name = safe_name_from(place["name"]);
    frame.number = place["number"].integer();
    frame.color = camera_from(place["color_camera"]);
    frame.depth = camera_from(place["depth_camera"]);
    frame.color_picture = picture_from(place["color_picture"], folder);
    frame.depth_picture = picture_from(place["depth_picture"], folder);
    frame.depth_unit_m = place["depth_unit_m"].number();
    if (!(frame.depth_unit_m > 0 && frame.depth_unit_m <= 1))
        place.fail("depth_unit_m", "expected meters per step of the depth picture, above 0, at most 1");
    if (const auto mask = place.find("mask"))
        frame.mask = picture_from(*mask, folder);
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
    if (!is_file(picture.path))
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

/// The picture that was listed, of its camera's size: an NPY array, or what `decode` reads by `images` (null: NPY only).
template <class T>
Raster<T> load_picture(const PictureFile& picture, const Camera& camera, int channels, const ImageIo* images,
                       const std::function<Raster<T>(const fs::path&)>& decode)
{
    const fs::path& file = picture.path;
    if (!picture.hash.empty() && file_hash(file) != picture.hash)
        throw Error(file.string() + ": changed since the scan was read; run again to read it again");
    const bool is_npy = decode == nullptr || file.extension() == ".npy";
    if (!is_npy && images == nullptr)
        throw Error(file.string() + ": no picture codec (option \"images\"); only NPY pictures can be read without one");
    Raster<T> raster = is_npy ? detail::read_raster<T>(file, channels) : decode(file);
    const Intrinsics& k = camera.intrinsics;
    if (raster.width != k.width || raster.height != k.height)
        throw Error(fmt::format("{}: is {}x{} pixels; its intrinsics say {}x{}", file.string(), raster.width, raster.height,
                                k.width, k.height));
    return raster;
}

}  // namespace

void Frames::save(const ArtifactFolder& folder) const
{
    Value::List list;
    for (const Frame& frame : frames)
        list.emplace_back(Value::Map{{"sequence", frame.sequence},
                                     {"name", frame.name},
                                     {"number", static_cast<std::int64_t>(frame.number)},
                                     {"color_camera", to_value(frame.color)},
                                     {"depth_camera", to_value(frame.depth)},
                                     {"color_picture", picture_to_value(frame.color_picture, folder)},
                                     {"depth_picture", picture_to_value(frame.depth_picture, folder)},
                                     {"depth_unit_m", frame.depth_unit_m},
                                     {"mask", picture_to_value(frame.mask, folder)}});
    Value index = Value::Map{{"frames", std::move(list)}};
    if (offset_m != Vec3d{})
        index.set("offset_m", Value::List{offset_m.x, offset_m.y, offset_m.z});
    write_file(folder.path / "frames.json", to_json(index, 1));
}

std::shared_ptr<Frames> Frames::load(const ArtifactFolder& folder)
{
    const detail::JsonFile file(folder.path / "frames.json");
    file->has_only({"frames", "offset_m"});
    auto result = std::make_shared<Frames>();
    if (const auto offset = file->find("offset_m"))
    {
        const auto numbers = offset->numbers(3);
        result->offset_m = {numbers[0], numbers[1], numbers[2]};
    }
    std::set<std::pair<std::string, std::string>> names;
    for (const JsonPlace& place : file["frames"].list())
    {
        const Frame& frame = result->frames.emplace_back(frame_from(place, folder));
        if (!names.emplace(frame.sequence, frame.name).second)
            place.fail(frame.sequence + "/" + frame.name + " appears twice; a name must be unique in its sequence");
    }
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
        for (PictureFile* picture : {&frame.color_picture, &frame.depth_picture, &frame.mask})
        {
            from.run.check_canceled();
            if (!picture->empty())
                settle_picture(*picture, from.folder, list + ": " + frame.sequence + "/" + frame.name, from.run);
        }
    return result;
}

namespace
{

/// Throws Error if stages would take a transparent pixel of the frame's picture for the surface.
void check_transparent_are_masked(const Raster8& picture, const Frame& frame)
{
    const Raster8 mask = load_mask(frame);
    if (!mask.empty() && (mask.width != picture.width || mask.height != picture.height))
        return;  // The caller refuses the picture by its size.
    for (std::size_t i = 0; i < picture.values.size() / 4; ++i)
        if (picture.values[4 * i + 3] < least_opaque_alpha && (mask.empty() || mask.values[i] != 0))
            throw Error(
                frame.color_picture.path.string() +
                ": has transparent pixels that the frame's mask does not ignore; read the frames with scan.recording, which "
                "masks them, or save the picture without transparency");
}

}  // namespace

Raster8 load_color(const Frame& frame, const ImageIo* images)
{
    if (frame.color_picture.empty())
        throw Error(frame.sequence + "/" + frame.name + ": has no color picture");
    return load_picture<std::uint8_t>(frame.color_picture, frame.color, 3, images,
                                      [&](const fs::path& file)
                                      {
                                          Raster8 picture = read_picture(*images, file);
                                          if (picture.channels != 4)
                                              return picture;
                                          check_transparent_are_masked(picture, frame);
                                          return images->read_rgb(file);
                                      });
}

Raster16 load_depth_steps(const Frame& frame, const ImageIo* images)
{
    if (frame.depth_picture.empty())
        throw Error(frame.sequence + "/" + frame.name + ": has no depth picture");
    return load_picture<std::uint16_t>(frame.depth_picture, frame.depth, 1, images,
                                       [images](const fs::path& file) { return images->read_depth(file); });
}

RasterF depth_in_meters(const Raster16& steps, double unit_m)
{
    RasterF depth(steps.width, steps.height);
    std::ranges::transform(steps.values, depth.values.begin(),
                           [&](std::uint16_t step)
                           { return step == 0 || step == 65535 ? 0.0F : static_cast<float>(step * unit_m); });
    return depth;
}

RasterF load_depth(const Frame& frame, const ImageIo* images)
{
    return depth_in_meters(load_depth_steps(frame, images), frame.depth_unit_m);
}

Raster8 load_mask(const Frame& frame)
{
    if (frame.mask.empty())
        return {};
    return load_picture<std::uint8_t>(frame.mask, frame.color, 1, nullptr, nullptr);
}

Raster8 mask_at(const Raster8& mask, int width, int height)
{
    if (mask.empty())
        return {};
    Raster8 result(width, height, 1, 255);
    // The pixels, of `from`, that pixel i of `to` covers.
    const auto span = [](int i, int from, int to)
    {
        const auto first = static_cast<std::int64_t>(i) * from;
        return std::pair(static_cast<int>(first / to), static_cast<int>((first + from + to - 1) / to));
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const auto [left, right] = span(x, mask.width, width);
            const auto [top, bottom] = span(y, mask.height, height);
            for (int row = top; row < bottom; ++row)
                if (const auto* pixels = &mask.at(0, row); std::find(pixels + left, pixels + right, 0) != pixels + right)
                    result.at(x, y) = 0;
        }
    return result;
}

void check_camera(const Camera& camera, std::string_view source)
{
    const Intrinsics& k = camera.intrinsics;
    const auto fail = [&](const std::string& what) { throw Error(std::string(source) + ": " + what); };
    if (k.width < 1 || k.height < 1 || k.width > 65536 || k.height > 65536)
        fail(fmt::format("camera of {}x{} pixels; 1 to 65536 are accepted", k.width, k.height));
    if (!std::isfinite(k.fx) || !std::isfinite(k.fy) || k.fx <= 0 || k.fy <= 0)
        fail("focal lengths must be positive numbers");
    const double side = std::max(k.width, k.height);
    for (const double focal : {k.fx, k.fy})
        if (focal < side / widest_sides || focal > side * longest_sides)
            fail(fmt::format("a focal length of {} pixels for a picture of {}x{}; from {} to {} are accepted, a hundredth to "
                             "10 000 times its longer side",
                             to_json(focal), k.width, k.height, to_json(side / widest_sides), to_json(side * longest_sides)));
    if (!std::isfinite(k.cx) || !std::isfinite(k.cy))
        fail("the principal point is not finite");
    if (std::abs(k.cx) > side * longest_sides || std::abs(k.cy) > side * longest_sides)
        fail("the principal point (" + to_json(k.cx) + ", " + to_json(k.cy) +
             ") is more than 10 000 times the picture's longer side away");
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

void check_offset(const Frames& frames, const Mesh& mesh)
{
    const auto text = [](Vec3d v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); };
    if (frames.offset_m != mesh.offset_m)
        throw Error("coordinates of the frames are stored less " + text(frames.offset_m) + " m, those of the mesh less " +
                    text(mesh.offset_m) +
                    " m: if both are in one world, wire the frames to port 'frames' of the scan.mesh stage; if only one is in "
                    "a map's coordinates, such as UTM, move the mesh by the option transform of scan.mesh");
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

}  // namespace fresco
