#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/source_map.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fresco
{
namespace
{

constexpr float steps = 65534;
constexpr float turn = 2 * std::numbers::pi_v<float>;

std::uint16_t rounded(float share)
{
    return static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0F, 1.0F) * steps));
}

}  // namespace

SourceMap::~SourceMap() = default;

std::optional<SourceMap::Place> SourceMap::place(int x, int y) const
{
    const std::uint16_t* value = &places.at(x, y);
    if (value[0] == none)
        return std::nullopt;
    const auto share = [&](int i) { return static_cast<float>(value[i]) / steps; };
    return Place{{share(0) * static_cast<float>(picture_width), share(1) * static_cast<float>(picture_height)}, share(2) * turn};
}

void SourceMap::set_place(int x, int y, const Place& place)
{
    std::uint16_t* value = &places.at(x, y);
    value[0] = rounded(place.at.x / static_cast<float>(picture_width));
    value[1] = rounded(place.at.y / static_cast<float>(picture_height));
    const float turns = place.angle / turn;
    value[2] = rounded(turns - std::floor(turns));
}

void SourceMap::save(const ArtifactFolder& folder) const
{
    write_file(folder.path / "source_map.json", to_json(Value::Map{{"atlas", atlas},
                                                                   {"picture_width", picture_width},
                                                                   {"picture_height", picture_height},
                                                                   {"pixels_per_texel", static_cast<double>(pixels_per_texel)}},
                                                        1));
    detail::write_raster(folder.path / "places.npy", places);
}

std::shared_ptr<SourceMap> SourceMap::load(const ArtifactFolder& folder)
{
    const auto file = folder.path / "source_map.json";
    const Value root = detail::read_json_file(file);
    auto result = std::make_shared<SourceMap>();
    result->atlas = root.at("atlas").as_string();
    result->picture_width = static_cast<int>(root.at("picture_width").as_int());
    result->picture_height = static_cast<int>(root.at("picture_height").as_int());
    result->pixels_per_texel = static_cast<float>(root.at("pixels_per_texel").as_double());
    if (result->picture_width < 1 || result->picture_height < 1 || !(result->pixels_per_texel > 0))
        throw Error(file.string() + ": expected positive numbers for the picture's size and pixels_per_texel");
    const auto places_file = folder.path / "places.npy";
    result->places = detail::read_raster16(places_file, 3);
    if (result->places.width != result->places.height)
        throw Error(places_file.string() + ": expected a square map");
    return result;
}

}  // namespace fresco
