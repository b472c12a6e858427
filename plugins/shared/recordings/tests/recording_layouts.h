#pragma once

#include "catch.h"
#include "stored_png.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/testing_scenes.h>
#include <fresco/value.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

/// \file For the tests of layouts: a tiny recording, and the layouts that recorders write.

namespace fresco::testing
{

/// Writes pictures of the cameras' sizes that differ by `number`.
inline void write_pictures(const Frame& frame, const ImageIo& images, int number)
{
    const auto &c = frame.color.intrinsics, &d = frame.depth.intrinsics;
    const auto color = [&](int x, int y, int channel) { return (7 * x + 3 * y + 40 * channel + number) % 256; };
    write_file(frame.color_picture.path, images.encode_png(picture(c.width, c.height, color)));
    Raster16 depth(d.width, d.height);
    for (int y = 0; y < depth.height; ++y)
        for (int x = 1; x < depth.width; ++x)
            depth.at(x, y) = static_cast<std::uint16_t>(1000 + 10 * x + 100 * y + number);
    write_file(frame.depth_picture.path, images.encode_png(depth));
}

/// A recording of one camera whose pictures differ from frame to frame: color 32x24, depth 16x12, millimeters; the camera walks
/// a quarter of a circle and looks inward and down.
inline Frames tiny_recording(const std::filesystem::path& folder, const ImageIo& images)
{
    Frames recording;
    for (int i = 0; i < 3; ++i)
    {
        Frame frame;
        frame.sequence = "seq-01";
        frame.name = "frame-00000" + std::to_string(i);
        frame.number = i;
        const double yaw = 0.4 * i, pitch = 0.3 + 0.05 * i;
        const Vec3d right{std::cos(yaw), std::sin(yaw), 0};
        const Vec3d forward{-std::sin(yaw) * std::cos(pitch), std::cos(yaw) * std::cos(pitch), -std::sin(pitch)};
        const Vec3d down = cross(forward, right);
        frame.color.world_from_camera.rotation.m = {right.x,   down.x,  forward.x, right.y,  down.y,
                                                    forward.y, right.z, down.z,    forward.z};
        frame.color.world_from_camera.translation = {0.5 + 0.1 * i, -2.25, 1.0 / 3 + i};
        frame.color.intrinsics = {32, 24, 30.5, 31.25, 15.75, 12.5};
        frame.depth = frame.color;
        frame.depth.intrinsics = frame.color.intrinsics.scaled_to(16, 12);
        frame.color_picture.path = folder / (frame.name + ".color.png");
        frame.depth_picture.path = folder / (frame.name + ".depth.png");
        write_pictures(frame, images, i);
        recording.frames.push_back(std::move(frame));
    }
    return recording;
}

/// Turns the pictures into 360° ones at the same poses: color 64x32, depth 32x16; the intrinsics have only the size.
inline void make_panoramas(Frames& recording, const ImageIo& images)
{
    for (std::size_t i = 0; i < recording.frames.size(); ++i)
    {
        auto& frame = recording.frames[i];
        frame.color.intrinsics = {.width = 64, .height = 32};
        frame.depth.intrinsics = {.width = 32, .height = 16};
        write_pictures(frame, images, static_cast<int>(i));
    }
}

/// Row-major 4x4.
inline std::vector<double> matrix_of(const RigidTransform& t)
{
    const auto& r = t.rotation;
    return {r(0, 0), r(0, 1), r(0, 2), t.translation.x, r(1, 0), r(1, 1), r(1, 2), t.translation.y,
            r(2, 0), r(2, 1), r(2, 2), t.translation.z, 0,       0,       0,       1};
}

/// Matrix of a pose with OpenGL's camera axes: y up, z backward.
inline std::vector<double> opengl_matrix_of(const RigidTransform& t)
{
    auto m = matrix_of(t);
    for (const std::size_t entry : {1U, 2U, 5U, 6U, 9U, 10U})
        m[entry] = -m[entry];
    return m;
}

/// w, x, y, z of a rotation of less than half a turn.
inline std::array<double, 4> quaternion_of(const Mat3& r)
{
    const auto half_root = [](double square) { return std::sqrt(std::max(square, 0.0)) / 2; };
    return {half_root(1 + r(0, 0) + r(1, 1) + r(2, 2)),
            std::copysign(half_root(1 + r(0, 0) - r(1, 1) - r(2, 2)), r(2, 1) - r(1, 2)),
            std::copysign(half_root(1 - r(0, 0) + r(1, 1) - r(2, 2)), r(0, 2) - r(2, 0)),
            std::copysign(half_root(1 - r(0, 0) - r(1, 1) + r(2, 2)), r(1, 0) - r(0, 1))};
}

inline std::string joined(const std::vector<double>& numbers)
{
    std::string text;
    for (const double number : numbers)
        text += (text.empty() ? "" : " ") + to_json(number);
    return text;
}

/// A row-major matrix, a row per line.
inline std::string rows_of(const std::vector<double>& matrix, std::size_t columns)
{
    std::string text;
    for (auto row = matrix.begin(); row != matrix.end(); row += static_cast<std::ptrdiff_t>(columns))
        text += joined({row, row + static_cast<std::ptrdiff_t>(columns)}) + "\n";
    return text;
}

inline std::string numbered(const std::string& prefix, std::size_t number, const std::string& ending, std::size_t digits = 6)
{
    const auto text = std::to_string(number);
    return prefix + std::string(text.size() < digits ? digits - text.size() : 0, '0') + text + ending;
}

inline void copy_picture(const std::filesystem::path& from, const std::filesystem::path& to)
{
    std::filesystem::create_directories(to.parent_path());
    std::filesystem::copy_file(from, to, std::filesystem::copy_options::overwrite_existing);
}

/// nerfstudio: transforms.json, images/, depth/.
inline void write_nerfstudio(const Frames& frames, const std::filesystem::path& folder, Value head = Value::Map{})
{
    Value::List list;
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const auto& frame = frames.frames[i];
        const std::string color = numbered("images/frame_", i + 1, frame.color_picture.path.extension().string(), 5);
        const std::string depth = numbered("depth/frame_", i + 1, ".png", 5);
        copy_picture(frame.color_picture.path, folder / color);
        copy_picture(frame.depth_picture.path, folder / depth);
        const auto m = opengl_matrix_of(frame.color.world_from_camera);
        Value::List rows;
        for (std::size_t row = 0; row < 4; ++row)
            rows.emplace_back(Value::List{m[row * 4], m[row * 4 + 1], m[row * 4 + 2], m[row * 4 + 3]});
        list.emplace_back(Value::Map{{"file_path", color}, {"depth_file_path", depth}, {"transform_matrix", std::move(rows)}});
    }
    const auto& k = frames.frames.front().color.intrinsics;
    const Value::Map camera{{"w", k.width}, {"h", k.height}, {"fl_x", k.fx}, {"fl_y", k.fy}, {"cx", k.cx}, {"cy", k.cy}};
    for (const auto& [key, value] : camera)
        if (head.find(key) == nullptr)
            head.set(key, value);
    head.set("frames", std::move(list));
    write_file(folder / "transforms.json", to_json(head, 1) + "\n");
}

/// COLMAP: sparse/0/{cameras,images}.{txt or bin}, images/, and depth/ beside it. Without a focal length, a panorama.
inline void write_colmap(const Frames& frames, const std::filesystem::path& folder, bool binary)
{
    const auto& k = frames.frames.front().color.intrinsics;
    const bool is_panorama = k.fx == 0;
    const auto parameters = is_panorama ? std::vector<double>{static_cast<double>(k.width), static_cast<double>(k.height)}
                                        : std::vector<double>{k.fx, k.fy, k.cx, k.cy};
    std::string cameras, images;
    const auto put = [](std::string& to, auto value) { to.append(reinterpret_cast<const char*>(&value), sizeof value); };
    const std::uint64_t count = frames.frames.size();
    if (binary)
    {
        put(cameras, std::uint64_t{1});
        put(cameras, std::uint32_t{7});
        put(cameras, std::int32_t{is_panorama ? 17 : 1});
        put(cameras, static_cast<std::uint64_t>(k.width));
        put(cameras, static_cast<std::uint64_t>(k.height));
        for (const double value : parameters)
            put(cameras, value);
        put(images, count);
    }
    else
    {
        cameras = std::string("# Camera list\n# Number of cameras: 1\n7 ") + (is_panorama ? "EQUIRECTANGULAR " : "PINHOLE ") +
                  std::to_string(k.width) + " " + std::to_string(k.height) + " " + joined(parameters) + "\n";
        images = "# Image list\n# Number of images: " + std::to_string(count) + ", mean observations per image: 1\n";
    }
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const auto& frame = frames.frames[i];
        const std::string name = numbered("view ", i, frame.color_picture.path.extension().string(), 3);
        copy_picture(frame.color_picture.path, folder / "images" / name);
        copy_picture(frame.depth_picture.path, (folder / "depth" / name).replace_extension(".png"));
        const auto camera_from_world = frame.color.world_from_camera.inverse();
        const auto q = quaternion_of(camera_from_world.rotation);
        const auto& t = camera_from_world.translation;
        if (binary)
        {
            put(images, static_cast<std::uint32_t>(40 + i));
            for (const double value : {q[0], q[1], q[2], q[3], t.x, t.y, t.z})
                put(images, value);
            put(images, std::uint32_t{7});
            images.append(name.c_str(), name.size() + 1);
            put(images, static_cast<std::uint64_t>(i));
            for (std::size_t point = 0; point < i; ++point)
                for (const double value : {1.0, 2.0, 3.0})
                    put(images, value);
        }
        else
        {
            images += std::to_string(40 + i) + " " + joined({q[0], q[1], q[2], q[3], t.x, t.y, t.z}) + " 7 " + name + "\n";
            images += (i == 0 ? "" : "1.5 2.5 -1 3.5 4.5 12") + std::string("\n");
        }
    }
    std::filesystem::create_directories(folder / "sparse/0");
    const std::string ending = binary ? ".bin" : ".txt";
    write_file(folder / "sparse/0" / ("cameras" + ending), cameras);
    write_file(folder / "sparse/0" / ("images" + ending), images);
}

/// TUM RGB-D: rgb.txt, depth.txt, groundtruth.txt, rgb/, depth/. Depth pictures 4 ms after color, poses 3 ms before.
inline std::filesystem::path write_tum(const Frames& frames, const std::filesystem::path& folder, const ImageIo&)
{
    std::string rgb = "# color images\n# timestamp filename\n", depth = "# depth maps\n",
                poses = "# timestamp tx ty tz qx qy qz qw\n";
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const auto& frame = frames.frames[i];
        const auto time = [&](std::size_t milliseconds)
        {
            const std::size_t since = 97 + 33 * i + milliseconds;
            return std::to_string(1305031102 + since / 1000) + "." + numbered("", since % 1000, "", 3);
        };
        const auto stamp = [&](std::size_t milliseconds) { return time(milliseconds) + "000"; };
        const std::string color_name = "rgb/" + stamp(3) + frame.color_picture.path.extension().string();
        const std::string depth_name = "depth/" + stamp(7) + ".png";
        copy_picture(frame.color_picture.path, folder / color_name);
        copy_picture(frame.depth_picture.path, folder / depth_name);
        const auto q = quaternion_of(frame.color.world_from_camera.rotation);
        const auto& t = frame.color.world_from_camera.translation;
        rgb += stamp(3) + " " + color_name + "\n";
        depth += stamp(7) + " " + depth_name + "\n";
        poses += time(0) + "0 " + joined({t.x, t.y, t.z, q[1], q[2], q[3], q[0]}) + "\n";
    }
    write_file(folder / "rgb.txt", rgb);
    write_file(folder / "depth.txt", depth);
    write_file(folder / "groundtruth.txt", poses);
    return folder;
}

/// Matterport3D: undistorted_camera_parameters/tiny.conf, the two picture folders, and the room that each picture was taken in:
/// frame i in region i % 2. The depth pictures are converted to steps of 0.25 mm.
inline void write_matterport3d(const Frames& frames, const std::filesystem::path& folder, const ImageIo& images)
{
    const auto count = std::to_string(frames.frames.size());
    std::string cameras = "dataset matterport\nn_images " + count +
                          "\ndepth_directory undistorted_depth_images\ncolor_directory undistorted_color_images\n";
    std::string house = "ASCII 1.1\nH tiny - " + count + " " + count + " 0 0 0 0 0 2 0 1 0 0 0 0 0 0 0 0 1 1 1 0 0 0 0 0\n";
    house += "P 0 0 1 - 0 0 0 1 1 1 0 0 0 0\n";
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const auto& frame = frames.frames[i];
        const auto& k = frame.color.intrinsics;
        const std::string panorama = numbered("03a8325e", i, "");
        const std::string color = panorama + "_i1_0.jpg", depth = panorama + "_d1_0.png";
        copy_picture(frame.color_picture.path, folder / "undistorted_color_images" / color);
        auto steps = load_depth_steps(frame, &images);
        for (auto& step : steps.values)
            step = static_cast<std::uint16_t>(std::lround(step * frame.depth_unit_m * 4000));
        std::filesystem::create_directories(folder / "undistorted_depth_images");
        write_file(folder / "undistorted_depth_images" / depth, images.encode_png(steps));
        const auto m = opengl_matrix_of(frame.color.world_from_camera);
        cameras += "\nintrinsics_matrix " + joined({k.fx, 0, k.cx - 0.5, 0, k.fy, k.height - k.cy - 0.5, 0, 0, 1}) + "\nscan " +
                   depth + " " + color + " " + joined(m) + "\n";
        house += "P " + panorama + " " + std::to_string(i) + " " + std::to_string(i % 2) + " 0 1 2 3 0 0 0 0 0\n";
    }
    std::filesystem::create_directories(folder / "undistorted_camera_parameters");
    std::filesystem::create_directories(folder / "house_segmentations");
    write_file(folder / "undistorted_camera_parameters/tiny.conf", cameras);
    write_file(folder / "house_segmentations/tiny.house", house);
}

/// Polycam's raw data: keyframes/corrected_cameras, keyframes/corrected_images and keyframes/depth, at the times 998, 999, 1000,
/// …
inline std::filesystem::path write_polycam(const Frames& frames, const std::filesystem::path& folder, const ImageIo&)
{
    const auto keyframes = folder / "keyframes";
    std::filesystem::create_directories(keyframes / "corrected_cameras");
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const auto& frame = frames.frames[i];
        const auto& k = frame.color.intrinsics;
        const std::string time = std::to_string(998 + i);
        Value camera = Value::Map{{"width", k.width}, {"height", k.height}, {"fx", k.fx},         {"fy", k.fy},
                                  {"cx", k.cx},       {"cy", k.cy},         {"blur_score", 100.5}};
        const auto m = opengl_matrix_of(frame.color.world_from_camera);
        for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t column = 0; column < 4; ++column)
                camera.set("t_" + std::to_string(row) + std::to_string(column), m[4 * row + column]);
        write_file(keyframes / "corrected_cameras" / (time + ".json"), to_json(camera));
        copy_picture(frame.color_picture.path, keyframes / "corrected_images" / (time + ".jpg"));
        copy_picture(frame.depth_picture.path, keyframes / "depth" / (time + ".png"));
    }
    return folder;
}

/// Replica as NICE-SLAM has it: results/, traj.txt, and cam_params.json beside the scene's folder.
inline void write_replica(const Frames& frames, const std::filesystem::path& folder)
{
    const auto& k = frames.frames.front().color.intrinsics;
    std::string trajectory;
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const auto& frame = frames.frames[i];
        copy_picture(frame.color_picture.path, folder / "results" / numbered("frame", i, ".jpg"));
        copy_picture(frame.depth_picture.path, folder / "results" / numbered("depth", i, ".png"));
        trajectory += joined(matrix_of(frame.color.world_from_camera)) + "\n";
    }
    write_file(folder / "traj.txt", trajectory);
    // Pixel centers count from 0 there.
    const Value camera = Value::Map{{"w", k.width},     {"h", k.height},    {"fx", k.fx},   {"fy", k.fy},
                                    {"cx", k.cx - 0.5}, {"cy", k.cy - 0.5}, {"scale", 1000}};
    write_file(folder.parent_path() / "cam_params.json", to_json(Value::Map{{"camera", camera}}, 1));
}

/// ScanNet's .sens, version 4, in `folder`: color as the frames' files are, called JPEG; depth packed.
inline std::filesystem::path write_sens(const Frames& frames, const std::filesystem::path& folder, const ImageIo& images)
{
    std::string out;
    const auto put = [&](auto value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
    const auto put_matrix = [&](const std::vector<double>& matrix)
    {
        for (const double entry : matrix)
            put(static_cast<float>(entry));
    };
    const auto& first = frames.frames.front();
    const auto intrinsics = [](const Intrinsics& k)
    { return std::vector<double>{k.fx, 0, k.cx - 0.5, 0, 0, k.fy, k.cy - 0.5, 0, 0, 0, 1, 0, 0, 0, 0, 1}; };
    put(std::uint32_t{4});
    const std::string name = "a sensor";
    put(static_cast<std::uint64_t>(name.size()));
    out += name;
    put_matrix(intrinsics(first.color.intrinsics));
    put_matrix(matrix_of({}));
    put_matrix(intrinsics(first.depth.intrinsics));
    put_matrix(matrix_of(first.color.world_from_camera.inverse() * first.depth.world_from_camera));
    put(std::int32_t{2});
    put(std::int32_t{1});
    for (const auto& camera : {first.color, first.depth})
    {
        put(static_cast<std::uint32_t>(camera.intrinsics.width));
        put(static_cast<std::uint32_t>(camera.intrinsics.height));
    }
    put(static_cast<float>(1 / first.depth_unit_m));
    put(static_cast<std::uint64_t>(frames.frames.size()));
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const auto& frame = frames.frames[i];
        put_matrix(matrix_of(frame.depth.world_from_camera));
        put(std::uint64_t{1000 * i});
        put(std::uint64_t{1000 * i + 4});
        const auto steps = load_depth_steps(frame, &images);
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(steps.values.data());
        const auto depth = stored_png::zlib({bytes, bytes + steps.values.size() * sizeof(std::uint16_t)});
        const auto color = read_file(frame.color_picture.path);
        put(static_cast<std::uint64_t>(color.size()));
        put(static_cast<std::uint64_t>(depth.size()));
        out.append(reinterpret_cast<const char*>(color.data()), color.size());
        out.append(depth.begin(), depth.end());
    }
    put(std::uint64_t{0});
    auto file = folder / "scene0000_00.sens";
    std::filesystem::create_directories(folder);
    write_file(file, out);
    return file;
}

}  // namespace fresco::testing
