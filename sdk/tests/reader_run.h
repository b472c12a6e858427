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

/// Runs `type` from the library `plugin` on the recording at `path`, with a codec that says of pictures what `images` says; its
/// artifacts are written below `out`. Throws what the stage throws.
inline ReadScan run_reader(const std::filesystem::path& plugin, const std::string& type, const std::filesystem::path& path,
                           const RawImages& images, const std::filesystem::path& out, TestRun& run, Value options)
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
    const auto made = make_from_plugin(plugin, type);
    run_stage(dynamic_cast<Stage&>(*made), options, {}, out, run, factory);
    ReadScan result{Frames::load({out / "frames", out}), nullptr};
    if (std::filesystem::exists(out / "mesh"))
        result.mesh = Mesh::load({out / "mesh", out});
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

}  // namespace fresco::testing
