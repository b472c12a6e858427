#include "components.h"
#include "forked_case.h"
#include "loop_options.h"
#include "method_tables.h"
#include "scene.h"

#include <fresco/npy.h>
#include <fresco/torch/tensor.h>

namespace bench
{
namespace
{

using namespace fresco::optimize;
using Map = fresco::Value::Map;

constexpr int height_px = 256;

/// A recording on disk: every view is the same one, under a name of its own and with files of its own name.
struct Recording
{
    std::shared_ptr<const fresco::UvMaps> maps;
    fresco::Frames frames;

    Recording(const std::filesystem::path& folder, std::size_t views)
    {
        std::filesystem::create_directories(folder);
        const fresco::UvMap map = generated_view(height_px);
        const int width = map.valid.width;
        const auto picture = fresco::to_raster8(fresco::to_tensor(generated_camera_picture(width, height_px)));
        const auto picture_file = folder / "picture.npy";
        const std::vector<std::size_t> shape{static_cast<std::size_t>(height_px), static_cast<std::size_t>(width), 3};
        fresco::write_npy(picture_file, shape, std::span<const std::uint8_t>(picture.values));

        fresco::UvMaps index;
        index.heights_px = {height_px};
        std::int64_t valid = 0;
        for (const auto v : map.valid.values)
            valid += v;
        fresco::UvMaps::write_map({folder, {}}, 0, height_px, map);
        for (std::size_t i = 0; i < views; ++i)
        {
            fresco::Frame frame;
            frame.sequence = "walk";
            frame.name = "frame-" + std::to_string(i);
            frame.number = static_cast<long>(i);
            const double focal = 0.9 * width;
            frame.color.intrinsics = {width, height_px, focal, focal, 0.5 * width, 0.5 * height_px};
            frame.depth = frame.color;
            frame.color_picture.path = picture_file;
            frames.frames.push_back(frame);
            index.views.push_back({frame.sequence, frame.name, frame.color, {valid}});
            if (i > 0)
                link_files(folder, i);
        }
        index.save({folder, {}});
        maps = fresco::UvMaps::load({folder, {}});
    }

  private:
    static void link_files(const std::filesystem::path& folder, std::size_t view)
    {
        const std::string first = "000000_" + std::to_string(height_px);
        std::string number = std::to_string(view);
        number.insert(0, 6 - number.size(), '0');
        std::filesystem::create_hard_link(folder / (first + ".uvmap"),
                                          folder / (number + "_" + std::to_string(height_px) + ".uvmap"));
    }
};

struct Case
{
    int size_px;
    std::size_t frames;
};

fresco::Value measured(const Case& one, const std::filesystem::path& folder, const std::filesystem::path& vgg19, int threads,
                       Measure& measure)
{
    const Recording recording(folder / (std::to_string(one.size_px) + "_" + std::to_string(one.frames)), one.frames);
    Components components;
    const fresco::Value features = Map{{"type", "features.vgg19"}, {"weights", vgg19.string()}};
    const std::map<std::string, std::shared_ptr<fresco::Loss>> losses{
        {"style", components.make<fresco::Loss>(Map{{"type", "loss.gram"}, {"features", features}})},
        {"content", components.make<fresco::Loss>(Map{{"type", "loss.content"}, {"features", features}})}};
    const auto texture = components.make<fresco::TextureRepresentation>(Map{{"type", "texture.laplacian"}});
    const auto rule = components.make<fresco::OptimizerRule>(Map{{"type", "optimizer.adam"}, {"mode", "visible"}});
    const auto style = fresco::to_raster8(fresco::to_tensor(generated_style(400, 300)));
    LoopOptions options = short_loop(one.size_px, 1);
    options.schedule.max_steps = 24;
    fresco::testing::TestRun run(threads);
    measure.times(
        1,
        [&] {
            optimized_texture({*recording.maps, recording.frames, style}, {losses, *texture, *rule, nullptr}, options, run);
        });
    return Map{
        {"size_px", one.size_px}, {"frames", one.frames}, {"ms_per_step", 1e3 * run.reported.at("seconds_per_step").as_double()}};
}

}  // namespace

Table run_table(const MethodSettings& settings, const std::filesystem::path& folder, const std::filesystem::path& vgg19)
{
    Table table("runs", "texture.optimize from end to end with visible Adam at 256 px: larger textures, longer recordings",
                {{"size_px", "size px"},
                 {"frames", "frames"},
                 {"ms_per_step", "ms/step"},
                 {"times_first", "x first time", 2},
                 {"peak_mb", "peak MB", 0},
                 {"times_first_memory", "x first memory", 2}});
    std::vector<Case> cases;
    for (const int size : {1024, 4096, 8192, 16384})
        cases.push_back({size, 20});
    cases.push_back({1024, 100});
    cases.push_back({1024, 1000});
    fresco::Value first;
    for (const auto& one : cases)
    {
        // Values, both moments and counts of all layers, and the copy that is the result.
        const double needed_mb = 1.34 * one.size_px * one.size_px * (4.0 * 12 + 4) / 1e6;
        if (needed_mb > available_memory_mb())
        {
            table.add(Map{{"size_px", one.size_px}, {"note", "left out: it needs more memory than is free"}});
            continue;
        }
        auto row = run_case([&](Measure& measure) { return measured(one, folder, vgg19, settings.threads, measure); });
        if (first.is_null() || (one.size_px == 1024 && one.frames == 100))
            first = row;
        row.set("times_first", ratio(entry(row, "ms_per_step"), entry(first, "ms_per_step")));
        row.set("times_first_memory", ratio(entry(row, "peak_mb"), entry(first, "peak_mb")));
        table.add(std::move(row));
    }
    return table;
}

}  // namespace bench
