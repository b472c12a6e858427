#pragma once

#include "raw_images.h"
#include "shared_data.h"

#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

/// \file The recordings on which mistakes are made on purpose.

namespace recordings
{

using namespace fresco;

struct Recording
{
    testing::TemporaryFolder folder;
    std::shared_ptr<ImageIo> images;
    std::shared_ptr<Frames> frames;
    std::shared_ptr<Mesh> mesh;
    std::function<RasterF(const Frame&)> depth = [this](const Frame& frame) { return load_depth(frame, images.get()); };
};

/// Another plugin of this build.
inline std::filesystem::path library_of(const std::string& name)
{
    return std::filesystem::path(FRESCO_PLUGIN_FILE).parent_path() / (name + ".so");
}

/// Reads a scan by another plugin; null, with a line that says so, where that is not built.
inline std::shared_ptr<const Recording> record(const std::string& type, const std::string& library, Value options,
                                               std::shared_ptr<ImageIo> images, std::shared_ptr<Component> layout = nullptr)
{
    const auto file = library_of(library);
    if (!std::filesystem::exists(file))
    {
        skipped("the test on " + type + ": " + library + " is not built");
        return nullptr;
    }
    auto result = std::make_shared<Recording>();
    result->images = images;
    testing::TestRun run;
    testing::run_stage(file, type, options, {}, result->folder.path(), run, {{"image_io", images}, {"layout", layout}});
    result->frames = Frames::load({result->folder.path() / "frames", {}});
    if (std::filesystem::exists(result->folder.path() / "mesh"))
        result->mesh = Mesh::load({result->folder.path() / "mesh", {}});
    return result;
}

/// A generated room in small pictures, with further options of scan.synthetic_room.
inline std::shared_ptr<const Recording> generated(int frames_count, int color_width_px, double edge_m, Value::Map more = {})
{
    Value options = std::move(more);
    options.set("frames_count", frames_count);
    options.set("color_width_px", color_width_px);
    options.set("color_height_px", color_width_px * 3 / 4);
    options.set("depth_px", Value::List{120, 90});
    options.set("edge_m", edge_m);
    return record("scan.synthetic_room", "scan_synthetic_room", options, std::make_shared<testing::RawImages>());
}

/// A small room, made once.
inline const Recording* room()
{
    static const auto made = generated(12, 320, 0.05);
    return made.get();
}

/// A hall of 12 m, of which a mesh may hold one object only.
inline const Recording* hall()
{
    static const auto made = generated(8, 160, 0.1, {{"size_m", Value::List{12, 8, 4}}});
    return made.get();
}

/// The room as a hand that walks records it: views of a group overlap.
inline const Recording* walk()
{
    static const auto made = generated(60, 160, 0.1);
    return made.get();
}

/// A real recording among the shared data; null where it is missing.
inline std::shared_ptr<const Recording> real(const std::string& layout, const std::string& folder, const Value::Map& options = {})
{
    const auto path = shared_data(folder, "the test on a real recording");
    const auto codec = library_of("image_opencv"), reader = library_of("layout_" + layout);
    if (path.empty() || !std::filesystem::exists(codec) || !std::filesystem::exists(reader))
        return nullptr;
    const std::shared_ptr<Component> known = testing::make_from_plugin<Component>(reader, "layout." + layout);
    testing::TestFactory none;
    known->configure(options, none);
    return record("scan.recording", "scan_recording", Value::Map{{"path", path.string()}},
                  testing::make_from_plugin<ImageIo>(codec, "image.opencv"), known);
}

inline const Recording* kitchen()
{
    static const auto made = real("seven_scenes", "kitchen");
    return made.get();
}

inline const Recording* hololens()
{
    static const auto made = real("folder", "recordings/hololens");
    return made.get();
}

inline const Recording* teddy()
{
    static const auto made = real("tum", "recordings/tum_teddy", {{"camera", "freiburg3"}});
    return made.get();
}

}  // namespace recordings
