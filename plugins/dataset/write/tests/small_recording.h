#pragma once

#include "raw_images.h"
#include "uv_map_samples.h"

#include <fresco/files.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

/// Three frames of 40 x 30 with noise for pictures and uv maps at 12 and 45 px, on disk below `folder`; the last has no depth
/// picture. A tenth of the maps' pixels is invalid.
class SmallRecording
{
  public:
    explicit SmallRecording(const std::filesystem::path& folder) : folder_(folder)
    {
        std::filesystem::create_directories(folder / "maps");
        fresco::UvMaps index;
        index.heights_px = {12, 45};
        for (int i = 0; i < 3; ++i)
        {
            frames->frames.push_back(frame(i));
            const fresco::Frame& made = frames->frames.back();
            fresco::UvMaps::View view{made.sequence, made.name, made.color, {}};
            for (const int height : index.heights_px)
            {
                const auto map = noise_uv_map(made.color.intrinsics.width_at(height), height, 0.9, maps_made_++);
                fresco::UvMaps::write_map({folder / "maps", {}}, static_cast<std::size_t>(i), height, map);
                view.valid_pixels.push_back(std::ranges::count(map.valid.values, 1));
            }
            index.views.push_back(view);
        }
        index.save({folder / "maps", {}});
        maps = fresco::UvMaps::load({folder / "maps", {}});
        mesh->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0.3F}};
        // The second face is degenerate: it must survive, for faces are counted.
        mesh->triangles = {{0, 1, 2}, {1, 1, 3}};
        mesh->texcoords = {{0, 0}, {1, 0}, {0, 1}, {0.1F, 0.2F}, {0.3F, 0.4F}, {0.5F, 0.6F}};
        mesh->charts = {0, 1};
    }

    fresco::testing::Inputs inputs() const { return {{"uvmaps", maps}, {"frames", frames}, {"mesh", mesh}}; }

    std::shared_ptr<fresco::Frames> frames = std::make_shared<fresco::Frames>();
    std::shared_ptr<fresco::UvMaps> maps;
    std::shared_ptr<fresco::Mesh> mesh = std::make_shared<fresco::Mesh>();

  private:
    fresco::Frame frame(int i)
    {
        fresco::Frame frame =
            fresco::testing::frame("frame-" + std::to_string(10 * i), {{40, 30, 33.25, 34, 20, 15.5}, {}}, 10 * i);
        frame.color.world_from_camera.translation = {0.1 * i, 1.0 / 3, -2};
        frame.depth = frame.color;
        frame.depth.intrinsics = {20, 14, 16, 16, 10, 7};
        frame.depth_unit_m = 0.002;
        fresco::testing::set_color_picture(frame, folder_, fresco::testing::noise_picture(40, 30, static_cast<std::uint64_t>(i)));
        if (i == 2)
            return frame;
        std::vector<std::uint16_t> steps(std::size_t{20} * 14);
        for (auto& value : steps)
            value = static_cast<std::uint16_t>(random_.below(65536));
        frame.depth_picture.path = folder_ / (frame.name + ".depth.npy");
        fresco::write_npy(frame.depth_picture.path, std::vector<std::size_t>{14, 20}, steps);
        return frame;
    }

    std::filesystem::path folder_;
    fresco::Random random_{5};
    std::uint64_t maps_made_ = 0;
};

/// Runs the stage: the names of its files, below `out`/files.
inline std::vector<std::string>
write_dataset(const std::filesystem::path& out, const fresco::testing::Inputs& inputs, fresco::testing::TestRun& run,
              const fresco::Value& options = fresco::Value::Map{},
              const std::shared_ptr<fresco::testing::RawImages>& codec = std::make_shared<fresco::testing::RawImages>())
{
    fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "dataset.write", options, inputs, out, run, {{"image_io", codec}});
    return fresco::Files::load({out / "files", out})->names;
}
