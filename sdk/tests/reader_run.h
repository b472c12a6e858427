#pragma once

#include "raw_images.h"

#include <fresco/error.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

#include <filesystem>
#include <memory>
#include <string>

/// \file Runs a reader of recordings as the host would, with a codec that needs no picture library.

namespace fresco::testing
{

/// What a reader made, saved and loaded again.
struct ReadScan
{
    std::shared_ptr<Frames> frames;
    std::shared_ptr<Mesh> mesh;  ///< Null where the reader has no such port.
};

/// A reader of the type `type` from the library `plugin`, configured for the recording at `path`, with a codec that says of
/// pictures what `images` says; its artifacts are to be written below `out`.
inline std::unique_ptr<Configurable> make_reader(const std::filesystem::path& plugin, const std::string& type,
                                                 const std::filesystem::path& path, const RawImages& images,
                                                 const std::filesystem::path& out, Value options)
{
    TestFactory factory;
    factory.add("image.raw",
                [orientation = images.orientation]
                {
                    auto codec = std::make_shared<RawImages>();
                    codec->orientation = orientation;
                    return codec;
                });
    options.set("path", path.string());
    options.set("images", Value::Map{{"type", "image.raw"}});
    auto made = make_from_plugin(plugin, type);
    auto& stage = dynamic_cast<Stage&>(*made);
    stage.configure(options, factory);
    for (OutputPort* port : stage.outputs())
    {
        std::filesystem::create_directories(out / port->name());
        port->set_folder({out / port->name(), out});
    }
    return made;
}

/// Runs a reader. Parameters as make_reader's. Throws what the stage throws.
inline ReadScan run_reader(const std::filesystem::path& plugin, const std::string& type, const std::filesystem::path& path,
                           const RawImages& images, const std::filesystem::path& out, TestRun& run, const Value& options)
{
    const auto made = make_reader(plugin, type, path, images, out, options);
    auto& stage = dynamic_cast<Stage&>(*made);
    stage.run(run);
    for (const OutputPort* port : stage.outputs())
        port->save();
    ReadScan result{Frames::load({out / "frames", out}), nullptr};
    if (std::filesystem::exists(out / "mesh"))
        result.mesh = Mesh::load({out / "mesh", out});
    return result;
}

/// The same without saving what it made, which waits for the disk.
inline ReadScan run_reader_unsaved(const std::filesystem::path& plugin, const std::string& type,
                                   const std::filesystem::path& path, const RawImages& images, const std::filesystem::path& out,
                                   TestRun& run, const Value& options)
{
    const auto made = make_reader(plugin, type, path, images, out, options);
    auto& stage = dynamic_cast<Stage&>(*made);
    stage.run(run);
    ReadScan result;
    for (const OutputPort* port : stage.outputs())
        if (port->name() == "frames")
            result.frames = std::make_shared<Frames>(dynamic_cast<const Frames&>(*port->value()));
        else
            result.mesh = std::make_shared<Mesh>(dynamic_cast<const Mesh&>(*port->value()));
    return result;
}

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

/// The same of `read(run)`, which reads a recording.
template <class Read>
std::string reading_error(const Read& read)
{
    return error_text(
        [&]
        {
            TestRun run;
            read(run);
        });
}

}  // namespace fresco::testing
