#include "transforms.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>
#include <fresco/recordings/recorded_view.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <set>

namespace nerfstudio
{
namespace
{

namespace fs = std::filesystem;
using fresco::Value;
using fresco::recordings::JsonRecord;
using fresco::recordings::RecordedView;

fresco::Intrinsics intrinsics_of(const Value& frame, const JsonRecord& record)
{
    fresco::Intrinsics k;
    k.width = record.pixels("w");
    k.height = record.pixels("h");
    // A frame's own angle goes before the file's focal lengths.
    const JsonRecord own(frame, record.place());
    const bool own_angle = own.find("fl_x") == nullptr && own.find("camera_angle_x") != nullptr;
    const JsonRecord& focals = own_angle ? own : record;
    const auto focal = [&](const char* key, const char* angle, double fallback, int size)
    {
        if (focals.find(key) == nullptr && focals.find(angle) != nullptr)
        {
            const double radians = focals.number(angle);
            if (!(radians > 0 && radians < std::numbers::pi))
                focals.fail(angle, "must be a field of view in radians, above 0 and below pi");
            return size / (2 * std::tan(radians / 2));
        }
        return fallback > 0 ? focals.number(key, fallback) : focals.number(key);
    };
    k.fx = focal("fl_x", "camera_angle_x", 0, k.width);
    k.fy = focal("fl_y", "camera_angle_y", k.fx, k.height);
    k.cx = record.number("cx", k.width / 2.0);
    k.cy = record.number("cy", k.height / 2.0);
    return k;
}

fresco::recordings::Lens lens_of(const JsonRecord& record)
{
    std::string model = record.find("camera_model") == nullptr ? "OPENCV" : record.text("camera_model");
    constexpr std::array known{"PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "FULL_OPENCV", "OPENCV_FISHEYE"};
    if (std::find(known.begin(), known.end(), model) == known.end())
        record.fail("camera_model", "is " + model +
                                        "; PINHOLE, SIMPLE_PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV and "
                                        "OPENCV_FISHEYE are supported: undistort the pictures to PINHOLE first");
    // instant-ngp's word for the same.
    if (const Value* fisheye = record.find("is_fisheye"); fisheye != nullptr && !(fisheye->is_bool() && !fisheye->as_bool()))
        model = "OPENCV_FISHEYE";
    const auto get = [&](const char* key) { return record.number(key, 0); };
    fresco::recordings::Lens lens{.k1 = get("k1"), .k2 = get("k2"), .k3 = get("k3")};
    if (model == "OPENCV_FISHEYE")
    {
        lens.k4 = get("k4");
        lens.is_fisheye = true;
        return lens;
    }
    lens.p1 = get("p1");
    lens.p2 = get("p2");
    if (model == "FULL_OPENCV")
    {
        lens.k4 = get("k4");
        lens.k5 = get("k5");
        lens.k6 = get("k6");
    }
    else if (get("k4") != 0)
        record.fail("k4", "is not 0, which only FULL_OPENCV and OPENCV_FISHEYE support: undistort the pictures to PINHOLE first");
    if (model.ends_with("PINHOLE") && lens.distorts())
        record.fail("camera_model", "is " + model + ", but k1 … p2 are not 0: set OPENCV, or remove them");
    return lens;
}

/// The recorder's world from that of the file: saved = scale * applied(original).
struct WorldChange
{
    fresco::RigidTransform original_from_saved;
    double scale = 1;  ///< Meters per saved unit.

    fresco::RigidTransform operator()(const fresco::RigidTransform& saved, double applied_scale) const
    {
        auto moved = saved;
        moved.translation = moved.translation * (1 / applied_scale);
        moved = original_from_saved * moved;
        moved.translation = moved.translation * scale;
        return moved;
    }
};

double applied_scale_of(const JsonRecord& whole)
{
    const double scale = whole.number("applied_scale", 1);
    if (!(scale > 0))
        whole.fail("applied_scale", "must be positive");
    return scale;
}

double depth_unit_of(const JsonRecord& record, double given)
{
    const double unit = given > 0 ? given : record.number("depth_unit_scale_factor", 0.001);
    if (!(unit > 0 && unit <= 1))
        record.fail("depth_unit_scale_factor", "must be meters per step of the depth pictures, above 0, at most 1");
    return unit;
}

const Value::List& list_of(const JsonRecord& whole, const std::string& key)
{
    const Value* list = whole.find(key);
    if (list == nullptr || !list->is_list() || list->as_list().empty())
        whole.fail(key, "must be a list, not empty; expected nerfstudio's transforms.json");
    return list->as_list();
}

/// The names that a split lists, without "./" and the like.
std::set<fs::path> listed_names(const JsonRecord& whole, const std::string& key)
{
    std::set<fs::path> names;
    for (const Value& name : list_of(whole, key))
    {
        if (!name.is_string())
            whole.fail(key, "must be a list of file names");
        names.insert(fs::path(name.as_string()).lexically_normal());
    }
    return names;
}

/// Which frames are wanted: a list of the file, and those of it that are named.
struct Chosen
{
    std::string key = "frames";
    std::optional<std::set<fs::path>> names{};
};

Chosen chosen_frames(const JsonRecord& whole, const std::string& split)
{
    if (split == "all")
        return {};
    const std::string key = split + "_filenames";
    if (whole.find(key) != nullptr)
        return {.names = listed_names(whole, key)};
    // ScanNet++ has the other frames in a list of their own.
    if (whole.find("test_frames") != nullptr && split != "val")
        return {.key = split == "test" ? "test_frames" : "frames"};
    whole.fail(key, "is missing; set split: all, and divide the frames with frames.hold_out");
}

}  // namespace

std::vector<RecordedView> parse_transforms(std::string_view text, const fs::path& file, const Reading& reading)
{
    const Value root = fresco::parse_json(text, file.string());
    const JsonRecord whole(root, file.string());
    auto chosen = chosen_frames(whole, reading.split);
    const Value::List& frames = list_of(whole, chosen.key);
    WorldChange world{{}, reading.unit_m};
    double applied_scale = 1;
    if (reading.world == World::original)
    {
        if (root.find("applied_transform") == nullptr && root.find("applied_scale") == nullptr)
            whole.fail("applied_transform", "is missing, so the recorder's own world is unknown; set world: saved, and transform "
                                            "the mesh with scan.mesh if it is in another world");
        if (root.find("applied_transform") != nullptr)
            world.original_from_saved =
                fresco::recordings::rigid_transform(whole.matrix("applied_transform"), whole.place_of("applied_transform"))
                    .inverse();
        applied_scale = applied_scale_of(whole);
    }

    std::vector<RecordedView> views;
    std::size_t with_depth = 0;
    for (std::size_t i = 0; i < frames.size(); ++i)
    {
        const Value& own = frames[i];
        const JsonRecord record(own, root,
                                fmt::format("{}: {} {}", file.string(), chosen.key == "frames" ? "frame" : "test frame", i));
        if (chosen.names && chosen.names->erase(fs::path(record.text("file_path")).lexically_normal()) == 0)
            continue;
        RecordedView view;
        view.source = record.place();
        const fs::path listed = record.text("file_path");
        fresco::recordings::name_by_picture(view, listed);
        view.color = (reading.pictures.empty() ? file.parent_path() : reading.pictures) / listed;
        // The "transforms" of synthetic scenes name pictures without their ending.
        if (listed.extension().empty())
            view.color += ".png";
        if (own.find("depth_file_path") != nullptr)
        {
            view.depth = file.parent_path() / record.text("depth_file_path");
            if (view.depth.extension() != ".png")
                record.fail("depth_file_path", "is " + view.depth.filename().string() +
                                                   "; expected a 16-bit PNG: convert it, or remove the key from every frame");
            view.depth_unit_m = depth_unit_of(record, reading.depth_unit_m);
            ++with_depth;
        }
        if (own.find("mask_path") != nullptr)
            view.mask = (reading.masks.empty() ? file.parent_path() : reading.masks) / record.text("mask_path");
        view.camera = intrinsics_of(own, record);
        view.lens = lens_of(record);
        view.world_from_camera =
            world(fresco::recordings::opencv_pose(record.matrix("transform_matrix"), record.place_of("transform_matrix")),
                  applied_scale);
        views.push_back(std::move(view));
    }
    if (chosen.names && !chosen.names->empty())
        whole.fail(reading.split + "_filenames",
                   "lists " + chosen.names->begin()->string() + ", which no frame has as file_path");
    if (with_depth != 0 && with_depth != views.size())
        throw fresco::Error(fmt::format("{}: {} of {} frames have a depth_file_path; expected all of them or none", file.string(),
                                        with_depth, views.size()));
    fresco::recordings::order_by_name(views);
    return views;
}

}  // namespace nerfstudio
