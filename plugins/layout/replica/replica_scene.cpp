#include "replica_scene.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>
#include <fresco/value.h>

namespace replica
{

using namespace fresco::recordings;

SceneCamera parse_camera(std::string_view text, std::string_view source)
{
    const auto root = fresco::parse_json(text, source);
    const std::string name(source);
    const auto* camera = root.find("camera");
    if (camera == nullptr)
        throw fresco::Error(name + R"(: expected {"camera": {"w": …, "h": …, "fx": …, "fy": …, "cx": …, "cy": …, "scale": …}})");
    const auto record = fresco::JsonPlace(root, name)["camera"];
    const double scale = record["scale"].number();
    if (!(scale >= 1 && scale <= 1e6))
        record.fail("scale", "must be steps of depth per meter, from 1 to 1000000");
    return {{record["w"].size(), record["h"].size(), record["fx"].number(), record["fy"].number(), record["cx"].number() + 0.5,
             record["cy"].number() + 0.5},
            1 / scale};
}

std::vector<fresco::RigidTransform> parse_trajectory(std::string_view text, std::string_view source)
{
    LineReader lines(text, source);
    std::vector<fresco::RigidTransform> poses;
    while (const auto line = lines.next())
        poses.push_back(rigid_transform(parse_numbers(*line, 16, lines.place()), lines.place()));
    return poses;
}

}  // namespace replica
