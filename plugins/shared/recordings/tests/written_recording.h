#pragma once

#include "raw_images.h"
#include "recording_checks.h"

#include <fresco/mesh.h>
#include <fresco/recordings/layout.h>
#include <fresco/testing.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

/// \file A recording in the layout under test, and how it is read.

namespace fresco::testing
{

namespace fs = std::filesystem;

/// A layout, and how a recording is written in it.
struct LayoutUnderTest
{
    fs::path plugin{FRESCO_PLUGIN_FILE};
    std::string type{};
    /// Writes the frames below `folder`, an empty one, and returns its path.
    std::function<fs::path(const Frames& frames, const fs::path& folder, const ImageIo& images)> write;
    /// Files of the second view, below `path`; empty: they are within another file.
    fs::path color{};
    fs::path depth{};
    std::string pose_source{};        ///< Name of the second view's pose source in errors.
    std::vector<fs::path> damaged{};  ///< Files to be damaged, other than those pictures.
    std::function<Value(const Frames& frames, const fs::path& path)> options{};
    double depth_step_m = 0.001;
    bool has_depth_camera = false;  ///< The layout has a depth camera of its own.
    bool may_lack_depth = false;    ///< A view without its depth picture is a view without depth.
    std::string third{};            ///< Sequence, name and number of the third view.
    std::size_t mesh_faces = 0;     ///< Zero: the layout writes no mesh.
    std::size_t files_read = 0;     ///< Zero: not counted.
};

/// The outputs of scan.recording.
struct ReadScan
{
    std::shared_ptr<Frames> frames;
    std::shared_ptr<Mesh> mesh;  ///< Null where there is none.
};

/// The tiny recording in a layout. `edit` may change its frames before they are written.
class WrittenRecording
{
    TemporaryFolder folder_;
    const LayoutUnderTest& layout_;

  public:
    RawImages images;
    Frames frames;
    fs::path path;

    explicit WrittenRecording(const LayoutUnderTest& layout, const std::function<void(Frames&)>& edit = {})
        : layout_(layout), frames(tiny_recording(folder_.path(), images))
    {
        if (layout.has_depth_camera)
            for (auto& frame : frames.frames)
                frame.depth.world_from_camera = frame.color.world_from_camera * RigidTransform{{}, {0.03, 0.001, -0.002}};
        if (edit)
            edit(frames);
        path = layout.write(frames, folder_.path() / "recording", images);
    }

    fs::path out() const { return folder_.path() / "out"; }

    /// Reads it, with options of the layout and of scan.recording. What was read is saved and loaded again, unless `saved` is
    /// false: saving waits for the disk.
    ReadScan read(TestRun& run, const Value& more = Value::Map{}, bool saved = true) const
    {
        Value options = layout_.options ? layout_.options(frames, path) : Value::Map{};
        for (const auto& [key, value] : more.as_map())
            options.set(key, value);
        recordings::ReadingOptions reading{.path = path};
        const auto take = [&](const char* key, const auto& set)
        {
            if (const Value* value = options.find(key))
                set(*value);
            std::erase_if(options.as_map(), [&](const Value::Entry& entry) { return entry.first == key; });
        };
        take("every", [&](const Value& value) { reading.every = static_cast<int>(value.as_int()); });
        take("mesh", [&](const Value& value) { reading.mesh.path = value.as_string(); });
        take("unit_m", [&](const Value& value) { reading.unit_m = value.as_double(); });
        take("depth_unit_m", [&](const Value& value) { reading.depth_unit_m = value.as_double(); });
        TestFactory none;
        const auto layout = make_from_plugin<recordings::Layout>(layout_.plugin, layout_.type);
        layout->configure(options, none);
        RawImages codec;
        codec.orientation = images.orientation;
        for (const char* port : {"frames", "mesh"})
            fs::create_directories(out() / port);
        auto found = recordings::read_recording(*layout, reading, codec, out() / "frames", run);
        ReadScan result{std::make_shared<Frames>(std::move(found.frames)), nullptr};
        if (found.mesh)
            result.mesh = std::make_shared<Mesh>(std::move(*found.mesh));
        if (!saved)
            return result;
        result.frames->save({out() / "frames", out()});
        result.frames = Frames::load({out() / "frames", out()});
        if (result.mesh)
        {
            result.mesh->save({out() / "mesh", out()});
            result.mesh = Mesh::load({out() / "mesh", out()});
        }
        return result;
    }
    ReadScan read(const Value& more = Value::Map{}) const
    {
        TestRun run;
        return read(run, more);
    }
    /// "no error" where it is read.
    std::string error(const Value& more = Value::Map{}) const
    {
        const std::string error = error_of([&] { read(more); });
        return error.empty() ? "no error" : error;
    }

    /// A file of the recording, by its path below `path`; an empty one for `path` itself.
    fs::path at(const fs::path& file) const { return file.empty() ? path : path / file; }
    std::string text(const fs::path& file) const { return read_text_file(at(file)); }
    void write(const fs::path& file, std::string_view text) const
    {
        fs::create_directories(at(file).parent_path());
        write_file(at(file), text);
    }
    /// The first `from` in a file replaced.
    void replace(const fs::path& file, std::string_view from, std::string_view to) const
    {
        auto content = text(file);
        const auto at = content.find(from);
        REQUIRE(at != std::string::npos);
        write(file, content.replace(at, from.size(), to));
    }
    Value json(const fs::path& file) const { return parse_json(text(file)); }
    /// The value of `key` in one of a JSON file's "frames".
    void set_in_frame(const fs::path& file, std::size_t frame, std::string_view key, Value value) const
    {
        auto root = json(file);
        root.find("frames")->as_list()[frame].set(key, std::move(value));
        write(file, to_json(root));
    }
    void remove(const fs::path& file) const { REQUIRE(fs::remove_all(path / file) > 0); }

    /// A mask of the color pictures' size in which the first `ignored` pixels behind (x, y) are black.
    void write_mask(const fs::path& file, int x = 0, int y = 0, std::size_t ignored = 1) const
    {
        Raster8 mask(32, 24, 3, 255);
        std::fill_n(mask.values.begin() + static_cast<std::ptrdiff_t>(mask.index(x, y)), 3 * ignored, std::uint8_t{0});
        fs::create_directories(at(file).parent_path());
        write_file(at(file), images.encode_png(mask));
    }
};

}  // namespace fresco::testing
