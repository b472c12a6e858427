#pragma once

#include "recording_layouts.h"

/// \file For the tests of readers: what their frames are checked for, and damage to their files.

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

/// Calls `read` after each of 200 cuts of a file (evenly spread, the empty file first) and each of 500 flips of 1 to 3 bytes, and
/// puts the file back. `read(cut)` must return or throw fresco::Error with a text that names something; any other exception
/// fails. Returns how often it threw.
struct DamageCounts
{
    int cuts_refused = 0;
    int flips_refused = 0;
};

inline DamageCounts damage_file(const std::filesystem::path& file, const std::function<void(bool cut)>& read)
{
    const auto good = read_file(file);
    DamageCounts counts;
    const auto attempt = [&](const std::vector<std::byte>& bytes, bool cut, int& refused)
    {
        // Neither write_file nor a new file of this name: both would wait for the disk 700 times.
        std::fstream(file, std::ios::binary | std::ios::in | std::ios::out)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        std::filesystem::resize_file(file, bytes.size());
        try
        {
            read(cut);
        }
        catch (const Error& error)
        {
            ++refused;
            CHECK(std::strlen(error.what()) > 10);
        }
    };
    for (std::size_t i = 0; i < 200; ++i)
    {
        const std::size_t size = i * good.size() / 200;
        INFO(file.filename() << " cut to " << size << " of " << good.size() << " bytes");
        attempt({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}, true, counts.cuts_refused);
    }
    std::uint64_t state = 88172645463325252ULL;
    const auto random = [&](std::size_t below)
    {
        state ^= state << 13U;
        state ^= state >> 7U;
        state ^= state << 17U;
        return static_cast<std::size_t>(state % below);
    };
    for (int i = 0; i < 500; ++i)
    {
        auto bytes = good;
        const auto changes = 1 + random(3);
        for (std::size_t change = 0; change < changes; ++change)
            bytes[random(bytes.size())] ^= static_cast<std::byte>(1 + random(255));
        INFO(file.filename() << " flip " << i);
        attempt(bytes, false, counts.flips_refused);
    }
    write_file(file, good);
    return counts;
}

/// What holds for any frames that a reader of damaged files may give.
inline void check_usable(const Frames& frames)
{
    for (const auto& frame : frames.frames)
    {
        check_camera(frame.color, frame.name);
        check_camera(frame.depth, frame.name);
        REQUIRE(std::isfinite(length(frame.color.world_from_camera.translation)));
        REQUIRE(frame.depth_unit_m > 0);
        REQUIRE(frame.name.find('/') == std::string::npos);
        REQUIRE(frame.sequence.find('/') == std::string::npos);
    }
}

/// What holds for frames read from a cut file: each is one of the whole recording, unchanged.
inline void check_subset(const Frames& read, const Frames& whole)
{
    for (const auto& frame : read.frames)
    {
        bool found = false;
        for (const auto& other : whole.frames)
            found = found || (frame.name == other.name && frame.color == other.color && frame.depth == other.depth);
        INFO(frame.name);
        REQUIRE(found);
    }
}

}  // namespace fresco::testing
