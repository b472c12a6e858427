#pragma once

#include "recording_layouts.h"

/// \file For the tests of readers: what their frames are checked for.

namespace fresco::testing
{

/// The cameras, depth and names that a reader gives back for a recording that was written out.
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

}  // namespace fresco::testing
