#pragma once

#include <fresco/frames.h>
#include <fresco/random.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// \file Uv maps of every sort that packing must bring back, and those of a recording on disk.

/// Everything noise; `valid_share` of the pixels valid, what the others hold must not matter.
inline fresco::UvMap noise_uv_map(int width, int height, double valid_share, std::uint64_t seed)
{
    fresco::Random random(seed);
    const auto share = [&] { return static_cast<float>(random.uniform()); };
    fresco::UvMap map{{width, height, 2}, {width, height}, {width, height}, {width, height}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const bool valid = random.uniform() < valid_share;
            map.valid.at(x, y) = valid ? 1 : 0;
            map.uv.at(x, y, 0) = valid ? share() : std::numeric_limits<float>::quiet_NaN();
            map.uv.at(x, y, 1) = valid ? share() : -7;
            map.depth.at(x, y) = valid ? 0.05F + 9 * share() : std::numeric_limits<float>::infinity();
            map.cosine.at(x, y) = valid ? share() : 2;
        }
    return map;
}

/// A map as of a scan: faceted walls of several charts with seams between them, and a round hole.
inline fresco::UvMap charts_uv_map(int width, int height)
{
    fresco::UvMap map{{width, height, 2}, {width, height}, {width, height}, {width, height}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const double across = (x + 0.5) / width;
            const double down = (y + 0.5) / height;
            if (std::hypot(across - 0.6, down - 0.4) < 0.15)
                continue;
            const int chart = across + 0.3 * down < 0.5 ? 0 : down < 0.7 ? 1 : 2;
            const double depth = 2 + across + 0.5 * chart + 0.01 * std::abs(std::sin(40 * across) + std::sin(30 * down));
            map.valid.at(x, y) = 1;
            map.uv.at(x, y, 0) = static_cast<float>(0.3 * chart + 0.08 * depth * across);
            map.uv.at(x, y, 1) = static_cast<float>(0.9 - 0.4 * chart * 0.5 - 0.1 * depth * down);
            map.depth.at(x, y) = static_cast<float>(depth);
            map.cosine.at(x, y) = static_cast<float>(0.4 + 0.3 * across + 0.1 * chart);
        }
    return map;
}

/// The ends of every range, at random places.
inline fresco::UvMap extreme_uv_map(int width, int height)
{
    fresco::Random random(11);
    fresco::UvMap map = noise_uv_map(width, height, 0.9, 12);
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
        if (map.valid.values[i] != 0)
        {
            map.uv.values[2 * i] = random.below(2) == 0 ? -0.9e-5F : 1 + 0.9e-5F;
            map.uv.values[2 * i + 1] = static_cast<float>(random.below(2));
            map.cosine.values[i] = static_cast<float>(random.below(2));
            map.depth.values[i] = random.below(2) == 0 ? 0.0F : 65.535F;
        }
    return map;
}

inline fresco::UvMap deep_uv_map(int width, int height, float farthest_m)
{
    fresco::UvMap map = noise_uv_map(width, height, 0.8, 13);
    for (float& depth : map.depth.values)
        depth *= farthest_m / 10;
    map.valid.values.back() = 1;
    map.uv.values[map.uv.values.size() - 2] = map.uv.values.back() = map.cosine.values.back() = 0.5F;
    map.depth.values.back() = farthest_m;
    return map;
}

inline std::vector<std::pair<std::string, fresco::UvMap>> all_uv_maps()
{
    return {{"noise", noise_uv_map(37, 29, 0.7, 1)},     {"noise of sparse pixels", noise_uv_map(64, 48, 0.03, 2)},
            {"all valid", noise_uv_map(31, 17, 2, 3)},   {"all invalid", noise_uv_map(33, 16, 0, 4)},
            {"one column", noise_uv_map(1, 57, 0.6, 5)}, {"one row", noise_uv_map(57, 1, 0.6, 6)},
            {"one pixel", noise_uv_map(1, 1, 2, 7)},     {"charts", charts_uv_map(160, 120)},
            {"extremes", extreme_uv_map(40, 30)},        {"70 m", deep_uv_map(20, 15, 70)},
            {"3 km", deep_uv_map(20, 15, 3000)},         {"to the moon", deep_uv_map(20, 15, 3.844e8F)}};
}

/// Writes the maps map_of(frame's number, width, height) of all frames' color cameras into `folder`.
template <class MapOf>
std::shared_ptr<fresco::UvMaps> written_uv_maps(const std::filesystem::path& folder, const fresco::Frames& frames,
                                                const std::vector<int>& heights, const MapOf& map_of)
{
    std::filesystem::create_directories(folder);
    fresco::UvMaps index;
    index.heights_px = heights;
    for (const fresco::Frame& frame : frames.frames)
    {
        const std::size_t number = index.views.size();
        auto& view = index.views.emplace_back(fresco::UvMaps::View{frame.sequence, frame.name, frame.color, {}});
        for (const int height : heights)
        {
            const fresco::UvMap map = map_of(number, frame.color.intrinsics.width_at(height), height);
            fresco::UvMaps::write_map({folder, {}}, number, height, map);
            view.valid_pixels.push_back(std::ranges::count(map.valid.values, 1));
        }
    }
    index.save({folder, {}});
    return fresco::UvMaps::load({folder, {}});
}
