#pragma once

#include "recording_layouts.h"

#include <fresco/recordings/panorama.h>

/// \file For the tests of layouts: what their frames are checked for.

namespace fresco::testing
{

/// The cameras, depth and names that a layout gives back for a recording that was written out.
inline void check_same_recording(const Frames& read, const Frames& written, const ImageIo& images, double depth_step_m = 0.001)
{
    REQUIRE(read.frames.size() == written.frames.size());
    for (std::size_t i = 0; i < read.frames.size(); ++i)
    {
        INFO("frame " << i);
        const auto& a = read.frames[i];
        const auto& b = written.frames[i];
        for (const auto& [one, other] : {std::pair{a.color, b.color}, std::pair{a.depth, b.depth}})
        {
            const auto m = matrix_of(one.world_from_camera), n = matrix_of(other.world_from_camera);
            for (std::size_t j = 0; j < m.size(); ++j)
                CHECK(std::abs(m[j] - n[j]) < 1e-6);
            const auto &k = one.intrinsics, &l = other.intrinsics;
            CHECK((k.width == l.width && k.height == l.height));
            for (const double difference : {k.fx - l.fx, k.fy - l.fy, k.cx - l.cx, k.cy - l.cy})
                CHECK(std::abs(difference) < 1e-4);
        }
        CHECK(load_color(a, &images) == load_color(b, &images));
        const auto depth = load_depth(a, &images), expected = load_depth(b, &images);
        REQUIRE(depth.values.size() == expected.values.size());
        double worst = 0;
        bool same_holes = true;
        for (std::size_t j = 0; j < depth.values.size(); ++j)
        {
            worst = std::max(worst, std::abs(static_cast<double>(depth.values[j]) - static_cast<double>(expected.values[j])));
            same_holes = same_holes && (depth.values[j] == 0) == (expected.values[j] == 0);
        }
        CHECK(worst <= depth_step_m);
        CHECK(same_holes);
    }
}

/// The views that are cut out of panoramas that were written out, as make_panoramas makes them.
inline void check_panoramas(const Frames& read, const Frames& written, const ImageIo& images)
{
    const auto faces = recordings::panorama_faces(64), depth_faces = recordings::panorama_faces(32);
    REQUIRE(read.frames.size() == written.frames.size() * faces.size());
    for (std::size_t i = 0; i < read.frames.size(); ++i)
    {
        INFO("frame " << i);
        const auto face = i / written.frames.size(), place = i % written.frames.size();
        const auto& frame = read.frames[i];
        const auto& panorama = written.frames[place];
        CHECK(frame.sequence.ends_with(std::array{"_front", "_right", "_back", "_left", "_up", "_down"}[face]));
        CHECK(frame.name == read.frames[place].name);
        CHECK(frame.number == read.frames[place].number);
        CHECK(frame.color.intrinsics == faces[face].camera);
        CHECK(frame.depth.intrinsics == depth_faces[face].camera);
        const auto& from = panorama.color.world_from_camera;
        const auto expected = matrix_of(from * RigidTransform{faces[face].panorama_from_face, {}});
        for (const auto* camera : {&frame.color, &frame.depth})
            for (std::size_t j = 0; j < expected.size(); ++j)
                CHECK(std::abs(matrix_of(camera->world_from_camera)[j] - expected[j]) < 1e-6);
        auto color = images.read_rgb(panorama.color_picture.path);
        recordings::widen_at_poles(color);
        CHECK(load_color(frame, &images) == recordings::face_of(color, faces[face]));
        CHECK(load_depth_steps(frame, &images) ==
              recordings::depth_face_of(images.read_depth(panorama.depth_picture.path), depth_faces[face]));
    }
}

}  // namespace fresco::testing
