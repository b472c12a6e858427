#include <fresco/recordings/layout.h>
#include <fresco/value.h>

#include <filesystem>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

/// Reads color/NUMBER.png, depth/NUMBER.png (16 bits, millimeters) and cameras.json: {"width": …, "height": …, "fx": …, "fy": …,
/// "cx": …, "cy": …, "world_from_camera": […]}, with a pose for each pair of pictures in the order of their numbers.
class MyPlugin final : public Layout
{
  public:
    fresco::Marks marks() const override { return {.contains = {"color", "cameras.json"}}; }

  private:
    Recording list(fresco::RunContext& run) override
    {
        auto views = numbered_views({path() / "color", "", {".png"}}, {path() / "depth", "", {".png"}}, {}, run);
        const fs::path file = path() / "cameras.json";
        const auto root = fresco::parse_json(recorded_text(file, run), file.string());
        const fresco::JsonPlace cameras(root, file.string());
        const fresco::Intrinsics camera{cameras["width"].size(), cameras["height"].size(), cameras["fx"].number(),
                                        cameras["fy"].number(),  cameras["cx"].number(),   cameras["cy"].number()};
        const auto poses = cameras["world_from_camera"].list(views.size());
        for (std::size_t i = 0; i < views.size(); ++i)
        {
            const auto m = poses[i].numbers(12);  // 3 x 4, row by row
            views[i].sequence = "recording";
            views[i].camera = camera;
            views[i].world_from_camera = {{{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}}, {m[3], m[7], m[11]}};
            views[i].source = poses[i].place();
        }
        return {.views = std::move(views), .files = "color/NUMBER.png and depth/NUMBER.png"};
    }
};

}  // namespace

FRESCO_COMPONENT("my.plugin", MyPlugin, fresco::recordings::Layout, "Folders with cameras.json")
