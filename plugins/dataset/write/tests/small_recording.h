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

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

/// Three frames of 40 x 30 with noise for pictures and uv maps at 12 and 45 px, on disk; the last has no depth picture. A tenth
/// of the maps' pixels is invalid.
class SmallRecording
{
  public:
    explicit SmallRecording(int threads = 2) : run(threads)
    {
        for (int i = 0; i < 3; ++i)
            frames->frames.push_back(frame(i));
        std::uint64_t seed = 0;
        maps = written_uv_maps(folder.path() / "maps", *frames, {12, 45},
                               [&](std::size_t, int width, int height) { return noise_uv_map(width, height, 0.9, seed++); });
        mesh->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0.3F}};
        // The second face is degenerate: it must survive, for faces are counted.
        mesh->triangles = {{0, 1, 2}, {1, 1, 3}};
        mesh->texcoords = {{0, 0}, {1, 0}, {0, 1}, {0.1F, 0.2F}, {0.3F, 0.4F}, {0.5F, 0.6F}};
        mesh->charts = {0, 1};
        inputs = {{"uvmaps", maps}, {"frames", frames}, {"mesh", mesh}};
    }

    /// Runs the stage: the names of its files, below `out`/files.
    std::vector<std::string>
    write(const fresco::Value& options = fresco::Value::Map{},
          const std::shared_ptr<fresco::testing::RawImages>& codec = std::make_shared<fresco::testing::RawImages>())
    {
        fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "dataset.write", options, inputs, out, run, {{"image_io", codec}});
        return fresco::Files::load({out / "files", out})->names;
    }

    fresco::testing::TemporaryFolder folder;
    fresco::testing::TestRun run;
    std::filesystem::path out = folder.path() / "out";
    std::shared_ptr<fresco::Frames> frames = std::make_shared<fresco::Frames>();
    std::shared_ptr<fresco::UvMaps> maps;
    std::shared_ptr<fresco::Mesh> mesh = std::make_shared<fresco::Mesh>();
    fresco::testing::Inputs inputs;

  private:
    fresco::Frame frame(int i)
    {
        fresco::Frame frame =
            fresco::testing::frame("frame-" + std::to_string(10 * i), {{40, 30, 33.25, 34, 20, 15.5}, {}}, 10 * i);
        frame.color.world_from_camera.translation = {0.1 * i, 1.0 / 3, -2};
        frame.depth = frame.color;
        frame.depth.intrinsics = {20, 14, 16, 16, 10, 7};
        frame.depth_unit_m = 0.002;
        fresco::testing::set_color_picture(frame, folder.path(),
                                           fresco::testing::noise_picture(40, 30, static_cast<std::uint64_t>(i)));
        if (i == 2)
            return frame;
        fresco::Raster16 steps(20, 14);
        for (auto& value : steps.values)
            value = static_cast<std::uint16_t>(random_.below(65536));
        frame.depth_picture.path = folder.path() / (frame.name + ".depth.npy");
        fresco::write_npy(frame.depth_picture.path, steps);
        return frame;
    }

    fresco::Random random_{5};
};

struct Recorded
{
    SmallRecording recording;
};
