#include "keyframes.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>
#include <fresco/recordings/recorded_view.h>
#include <fresco/value.h>

#include <fmt/format.h>

namespace polycam
{

using fresco::recordings::RecordedView;

void parse_camera(std::string_view text, RecordedView& view)
{
    view.source = view.pose.string();
    const auto root = fresco::parse_json(text, view.source);
    const fresco::JsonPlace record(root, view.source);
    const auto size = [&](const char* key) { return record.find(key) ? record[key].size() : 0; };
    view.camera = {size("width"),         size("height"),        record["fx"].number(),
                   record["fy"].number(), record["cx"].number(), record["cy"].number()};
    std::vector<double> matrix{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    for (std::size_t entry = 0; entry < 12; ++entry)
        matrix[entry] = record[fmt::format("t_{}{}", entry / 4, entry % 4)].number();
    view.world_from_camera = fresco::recordings::opencv_pose(matrix, view.source + ": t_00 to t_23");
}

fresco::RigidTransform parse_alignment(std::string_view text, std::string_view source)
{
    const auto root = fresco::parse_json(text, source);
    const auto place = fresco::JsonPlace(root, std::string(source))["alignmentTransform"];
    const auto columns = place.numbers(16);
    std::vector<double> matrix(16);
    for (std::size_t i = 0; i < 16; ++i)
        matrix[4 * (i % 4) + i / 4] = columns[i];
    return fresco::recordings::rigid_transform(matrix, place.place());
}

}  // namespace polycam
