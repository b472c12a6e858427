#pragma once

#include "raw_images.h"
#include "recording_checks.h"

#include <fresco/error.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

/// \file A recording in the layout of a reader under test, and how the reader is run on it.

namespace fresco::testing
{

namespace fs = std::filesystem;

/// A reader, and how a recording is written in its layout.
struct ReaderUnderTest
{
    fs::path plugin{FRESCO_PLUGIN_FILE};
    std::string type{};
    /// Writes the frames below `folder`, an empty one, and returns what the option `path` is to be.
    std::function<fs::path(const Frames& frames, const fs::path& folder, const ImageIo& images)> write;
    /// Files of the second view, below `path`; empty: they are within another file.
    fs::path color{};
    fs::path depth{};
    std::string pose_source{};        ///< What errors call the source of the second view's pose.
    std::vector<fs::path> damaged{};  ///< Files to be damaged, other than those pictures.
    std::function<Value(const Frames& frames, const fs::path& path)> options{};
    double depth_step_m = 0.001;
    bool has_depth_camera = false;  ///< The layout has a depth camera of its own.
};

/// What a reader made.
struct ReadScan
{
    std::shared_ptr<Frames> frames;
    std::shared_ptr<Mesh> mesh;  ///< Null where the reader has no such port, or left it out.
};

/// The text of the fresco::Error that `work` throws, "no error" if it throws none.
template <class Work>
std::string error_text(const Work& work)
{
    try
    {
        work();
    }
    catch (const Error& error)
    {
        return error.what();
    }
    return "no error";
}

/// The tiny recording in a reader's layout. `edit` may change its frames before they are written.
class WrittenRecording
{
    TemporaryFolder folder_;
    const ReaderUnderTest& reader_;

  public:
    RawImages images;
    Frames frames;
    fs::path path;

    explicit WrittenRecording(const ReaderUnderTest& reader, const std::function<void(Frames&)>& edit = {})
        : reader_(reader), frames(tiny_recording(folder_.path(), images))
    {
        if (reader.has_depth_camera)
            for (auto& frame : frames.frames)
                frame.depth.world_from_camera = frame.color.world_from_camera * RigidTransform{{}, {0.03, 0.001, -0.002}};
        if (edit)
            edit(frames);
        path = reader.write(frames, folder_.path() / "recording", images);
    }

    fs::path out() const { return folder_.path() / "out"; }

    /// Runs the reader. What it made is saved and loaded again, unless `saved` is false: saving waits for the disk.
    ReadScan read(TestRun& run, const Value& more = Value::Map{}, bool saved = true) const
    {
        TestFactory factory;
        factory.add("image.raw",
                    [this]
                    {
                        auto codec = std::make_shared<RawImages>();
                        codec->orientation = images.orientation;
                        return codec;
                    });
        Value options = reader_.options ? reader_.options(frames, path) : Value::Map{};
        options.set("path", path.string());
        options.set("image_io", Value::Map{{"type", "image.raw"}});
        for (const auto& [key, value] : more.as_map())
            options.set(key, value);
        const auto made = make_from_plugin(reader_.plugin, reader_.type);
        auto& stage = dynamic_cast<Stage&>(*made);
        stage.configure(options, factory);
        for (OutputPort* port : stage.outputs())
        {
            fs::create_directories(out() / port->name());
            port->set_folder({out() / port->name(), out()});
        }
        stage.run(run);
        ReadScan result;
        for (const OutputPort* port : stage.outputs())
        {
            if (port->is_left_out())
                continue;
            if (saved)
                port->save();
            if (port->name() == "frames")
                result.frames = saved ? Frames::load({out() / "frames", out()})
                                      : std::make_shared<Frames>(dynamic_cast<const Frames&>(*port->value()));
            else
                result.mesh = saved ? Mesh::load({out() / "mesh", out()})
                                    : std::make_shared<Mesh>(dynamic_cast<const Mesh&>(*port->value()));
        }
        return result;
    }
    ReadScan read(const Value& more = Value::Map{}) const
    {
        TestRun run;
        return read(run, more);
    }
    std::string error(const Value& more = Value::Map{}) const
    {
        return error_text([&] { read(more); });
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
