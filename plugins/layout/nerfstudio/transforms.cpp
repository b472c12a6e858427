#include "transforms.h"

#include <fresco/error.h>
#include <fresco/recordings/listed_files.h>
#include <fresco/recordings/parsing.h>
#include <fresco/recordings/recorded_view.h>
#include <fresco/value.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>
#include <optional>
#include <set>

namespace nerfstudio
{
namespace
{

namespace fs = std::filesystem;
using fresco::JsonPlace;
using fresco::Value;
using fresco::recordings::RecordedView;

constexpr std::string_view panorama_model = "EQUIRECTANGULAR";

double number(const JsonPlace& record, std::string_view key, double fallback)
{
    const auto found = record.find(key);
    return found ? found->number() : fallback;
}

std::string path_text(const JsonPlace& place)
{
    if (place.text().empty())
        place.fail("expected a path");
    return place.text();
}

/// A list of 3 or 4 rows of 4 numbers; row-major, the fourth row 0 0 0 1 where it is not there.
std::vector<double> matrix(const JsonPlace& place)
{
    std::vector<double> entries;
    for (const JsonPlace& row : place.list())
    {
        const auto numbers = row.numbers(4);
        entries.insert(entries.end(), numbers.begin(), numbers.end());
    }
    if (entries.size() == 12)
        entries.insert(entries.end(), {0, 0, 0, 1});
    return entries;
}

std::string model_of(const JsonPlace& record)
{
    const auto model = record.find("camera_model");
    return model ? model->text() : "OPENCV";
}

/// world_from_camera of a frame; beyond all bounds where an entry is not finite: the recorder had lost track.
fresco::RigidTransform pose_of(const JsonPlace& place)
{
    for (const JsonPlace& row : place.list())
        for (const JsonPlace& entry : row.list())
            if (entry.value().is_null())
                return {{}, {std::numeric_limits<double>::quiet_NaN(), 0, 0}};
    return fresco::recordings::opencv_pose(matrix(place), place.place());
}

/// A number of pixels; some programs write it as text.
int pixels_of(const JsonPlace& place)
{
    return place.value().is_string() ? static_cast<int>(fresco::recordings::integer_of(place.text(), 1, 65536, place.place()))
                                     : place.size();
}

fresco::Intrinsics intrinsics_of(const Value& frame, const JsonPlace& record, const RecordedView& view, const Reading& reading)
{
    fresco::Intrinsics k;
    if (reading.size_of && (!record.find("w") || !record.find("h")))
    {
        const auto size = reading.size_of(view.color);
        k.width = size.width;
        k.height = size.height;
    }
    else
    {
        k.width = pixels_of(record["w"]);
        k.height = pixels_of(record["h"]);
    }
    // Its fl_x … cy say nothing more: nerfstudio sets them to w / 2, h, and the middle.
    if (model_of(record) == panorama_model)
        return k;
    for (const char* key : {"camera_intrinsics", "intrinsic_matrix", "K"})
        if (const auto found = record.find(key); found && !record.find("fl_x"))
        {
            std::vector<double> entries;
            for (const JsonPlace& row : found->list(3))
                for (const double entry : row.numbers(3))
                    entries.push_back(entry);
            return fresco::recordings::intrinsics_from_matrix(entries, fresco::recordings::PixelCenter::half, k.width, k.height,
                                                              found->place());
        }
    // A frame's own angle goes before the file's focal lengths.
    const JsonPlace own(frame, record.place());
    const bool own_angle = !own.find("fl_x") && own.find("camera_angle_x");
    const JsonPlace& focals = own_angle ? own : record;
    const auto focal = [&](const char* key, const char* angle, double fallback, int size)
    {
        if (!focals.find(key) && focals.find(angle))
        {
            const double radians = focals[angle].number();
            if (!(radians > 0 && radians < std::numbers::pi))
                focals.fail(angle, "must be a field of view in radians, above 0 and below pi");
            return size / (2 * std::tan(radians / 2));
        }
        return fallback > 0 ? number(focals, key, fallback) : focals[key].number();
    };
    k.fx = focal("fl_x", "camera_angle_x", 0, k.width);
    k.fy = focal("fl_y", "camera_angle_y", k.fx, k.height);
    k.cx = number(record, "cx", k.width / 2.0);
    k.cy = number(record, "cy", k.height / 2.0);
    return k;
}

fresco::recordings::Lens lens_of(const JsonPlace& record)
{
    std::string model = model_of(record);
    if (model == panorama_model)
        return {};
    constexpr std::array known{"PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "FULL_OPENCV", "OPENCV_FISHEYE"};
    if (std::ranges::find(known, model) == known.end())
        record.fail("camera_model",
                    "is " + model +
                        "; PINHOLE, SIMPLE_PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, "
                        "OPENCV_FISHEYE and EQUIRECTANGULAR are supported: undistort the pictures to PINHOLE first");
    // instant-ngp's word for the same.
    if (const auto fisheye = record.find("is_fisheye"); fisheye && fisheye->value() != Value(false))
        model = "OPENCV_FISHEYE";
    const auto get = [&](const char* key) { return number(record, key, 0); };
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
    double applied_scale = 1;

    fresco::RigidTransform operator()(fresco::RigidTransform pose) const
    {
        pose.translation = pose.translation * (1 / applied_scale);
        return original_from_saved * pose;
    }
};

double applied_scale_of(const JsonPlace& whole)
{
    const double scale = number(whole, "applied_scale", 1);
    if (!(scale > 0))
        whole.fail("applied_scale", "must be positive");
    return scale;
}

double depth_unit_of(const JsonPlace& record)
{
    const double unit = number(record, "depth_unit_scale_factor", 0.001);
    if (!(unit > 0 && unit <= 1))
        record.fail("depth_unit_scale_factor",
                    "must be meters per step of the depth pictures, above 0, at most 1; for steps of a millimeter, 0.001");
    return unit;
}

std::vector<JsonPlace> list_of(const JsonPlace& whole, const std::string& key)
{
    const auto list = whole.find(key);
    if (!list || !list->value().is_list() || list->value().as_list().empty())
        whole.fail(key, "must be a list, not empty; expected nerfstudio's transforms.json");
    return list->list();
}

/// The names that a split lists, without "./" and the like.
std::set<fs::path> listed_names(const JsonPlace& whole, const std::string& key)
{
    std::set<fs::path> names;
    for (const JsonPlace& name : list_of(whole, key))
        names.insert(fs::path(name.text()).lexically_normal());
    return names;
}

/// Chosen frames: a list of the file, and the named ones in it.
struct Chosen
{
    std::string key = "frames";
    std::optional<std::set<fs::path>> names{};
};

Chosen chosen_frames(const JsonPlace& whole, const std::string& split)
{
    if (split == "all")
        return {};
    const std::string key = split + "_filenames";
    if (whole.find(key))
        return {.names = listed_names(whole, key)};
    // ScanNet++ has the other frames in a list of their own.
    if (whole.find("test_frames") && split != "val")
        return {.key = split == "test" ? "test_frames" : "frames"};
    whole.fail(key, "is missing; set split: all, and divide the frames with hold_out_every of frames.sharpest");
}

}  // namespace

std::vector<RecordedView> parse_transforms(std::string_view text, const fs::path& file, const Reading& reading,
                                           fresco::RunContext& run)
{
    const Value root = fresco::recordings::parse_recorded_json(text, file.string());
    const JsonPlace whole(root, file.string());
    auto chosen = chosen_frames(whole, reading.split);
    const std::vector<JsonPlace> frames = list_of(whole, chosen.key);
    WorldChange world;
    if (reading.original_world)
    {
        if (root.find("applied_transform") == nullptr && root.find("applied_scale") == nullptr)
            whole.fail("applied_transform", "is missing, so the recorder's own world is unknown; set world: saved, and transform "
                                            "the mesh with scan.mesh if it is in another world");
        if (root.find("applied_transform") != nullptr)
            world.original_from_saved =
                fresco::recordings::rigid_transform(matrix(whole["applied_transform"]), whole["applied_transform"].place())
                    .inverse();
        world.applied_scale = applied_scale_of(whole);
    }

    std::vector<JsonPlace> records;
    for (std::size_t i = 0; i < frames.size(); ++i)
    {
        const JsonPlace record(frames[i].value(), root,
                               fmt::format("{}: {} {}", file.string(), chosen.key == "frames" ? "frame" : "test frame", i));
        if (!chosen.names || chosen.names->erase(fs::path(path_text(record["file_path"])).lexically_normal()) > 0)
            records.push_back(record);
    }
    if (chosen.names && !chosen.names->empty())
        whole.fail(reading.split + "_filenames",
                   "lists " + chosen.names->begin()->string() + ", which no frame has as file_path");
    std::vector<RecordedView> views(records.size());
    std::vector<fresco::recordings::ListedFile> files;
    const auto folder_or = [&](const fs::path& folder) { return folder.empty() ? file.parent_path() : folder; };
    for (std::size_t i = 0; i < records.size(); ++i)
    {
        const JsonPlace& record = records[i];
        const auto own = [&](const char* key) { return record.value().find(key) != nullptr; };
        files.push_back({folder_or(reading.pictures), path_text(record["file_path"]), &views[i].color});
        if (own("depth_file_path"))
        {
            const std::string name = path_text(record["depth_file_path"]);
            if (!name.ends_with(".png"))
                record.fail("depth_file_path", "is " + fs::path(name).filename().string() +
                                                   "; expected a 16-bit PNG: convert it, or remove the key from every frame");
            files.push_back({file.parent_path(), name, &views[i].depth});
            views[i].depth_unit_m = depth_unit_of(record);
        }
        if (own("mask_path"))
            files.push_back({folder_or(reading.masks), path_text(record["mask_path"]), &views[i].mask});
    }
    fresco::recordings::find_listed_files(files, file.parent_path(), run);
    for (std::size_t i = 0; i < records.size(); ++i)
    {
        RecordedView& view = views[i];
        const JsonPlace& record = records[i];
        view.source = record.place();
        std::string listed = record["file_path"].text();
        std::ranges::replace(listed, '\\', '/');
        fresco::recordings::name_by_picture(view, listed);
        view.is_panorama = model_of(record) == panorama_model;
        view.camera = intrinsics_of(record.value(), record, view, reading);
        view.lens = lens_of(record);
        view.world_from_camera = world(pose_of(record["transform_matrix"]));
    }
    fresco::recordings::order_by_name(views);
    return views;
}

}  // namespace nerfstudio
