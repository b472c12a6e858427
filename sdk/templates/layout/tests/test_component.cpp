#include "layout_checks.h"

namespace
{

namespace fs = std::filesystem;
using namespace fresco::testing;
using fresco::Value;

/// Writes frames in the layout, for check_layout to read back.
fs::path write_recording(const fresco::Frames& frames, const fs::path& folder, const fresco::ImageIo& /*images*/)
{
    Value::List poses;
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const fresco::Frame& frame = frames.frames[i];
        copy_picture(frame.color_picture.path, folder / "color" / numbered("", i, ".png"));
        copy_picture(frame.depth_picture.path, folder / "depth" / numbered("", i, ".png"));
        poses.push_back(fresco::to_value(frame.color).at("world_from_camera"));
    }
    Value cameras = fresco::to_value(frames.frames.front().color);
    cameras.set("world_from_camera", std::move(poses));
    fresco::write_file(folder / "cameras.json", fresco::to_json(cameras, 1));
    return folder;
}

const LayoutUnderTest layout{.plugin = FRESCO_PLUGIN_FILE,
                             .type = "my.plugin",
                             .write = write_recording,
                             .color = "color/000001.png",
                             .depth = "depth/000001.png",
                             .pose_source = "cameras.json: world_from_camera[1]",
                             .damaged = {"cameras.json"}};

}  // namespace

TEST_CASE("the layout holds what every layout does")
{
    check_layout(layout);
}

TEST_CASE("damaged cameras are refused, and the error names the place")
{
    check_flaws(layout, {{replacing("cameras.json", "\"fx\"", "\"f\""), {"cameras.json: fx: missing"}},
                         {replacing("cameras.json", "\"world_from_camera\": [", "\"world_from_camera\": [\"\", "),
                          {"cameras.json: world_from_camera: expected a list of 3"}}});
}
