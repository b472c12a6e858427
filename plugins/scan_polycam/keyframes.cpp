#include "keyframes.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>
#include <fresco/recordings/recorded_view.h>

#include <fmt/format.h>

namespace polycam
{

using fresco::recordings::RecordedView;

void parse_camera(std::string_view text, RecordedView& view)
{
    view.source = view.pose.string();
    const auto root = fresco::parse_json(text, view.source);
    const fresco::recordings::JsonRecord record(root, view.source);
    view.camera = {record.pixels("width"), record.pixels("height"), record.number("fx"),
                   record.number("fy"),    record.number("cx"),     record.number("cy")};
    std::vector<double> matrix{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    for (std::size_t entry = 0; entry < 12; ++entry)
        matrix[entry] = record.number(fmt::format("t_{}{}", entry / 4, entry % 4));
    view.world_from_camera = fresco::recordings::opencv_pose(matrix, view.source + ": t_00 to t_23");
}

fresco::RigidTransform parse_alignment(std::string_view text, std::string_view source)
{
    const auto root = fresco::parse_json(text, source);
    const auto* found = root.find("alignmentTransform");
    const std::string place = std::string(source) + ": alignmentTransform";
    if (found == nullptr || !found->is_list() || found->as_list().size() != 16)
        throw fresco::Error(place + ": expected 16 numbers");
    std::vector<double> matrix(16);
    for (std::size_t i = 0; i < 16; ++i)
    {
        const auto& value = found->as_list()[i];
        if (!value.is_number())
            throw fresco::Error(place + ": expected 16 numbers");
        matrix[4 * (i % 4) + i / 4] = value.as_double();
    }
    return fresco::recordings::rigid_transform(matrix, place);
}

}  // namespace polycam
