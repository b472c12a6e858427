#pragma once

#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/relief.h>
#include <fresco/testing.h>

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// \file For the tests of stages that export textured meshes: their files, and reliefs.

namespace exported_files
{

using namespace fresco;

/// Encodes JPEG as PNG; a test looks at sizes and colors.
struct Codec final : stored_png::Codec
{
    std::vector<std::byte> encode_jpeg(const Raster8& image, int) const override { return encode_png(image); }
};

struct Exported
{
    std::string file;  ///< Contents of the first file.
    std::vector<std::string> names;
    Value report;
    std::vector<std::string> messages;
    std::shared_ptr<testing::TemporaryFolder> folder = std::make_shared<testing::TemporaryFolder>();

    std::filesystem::path path(const std::string& name) const { return folder->path() / "files" / name; }
};

inline Exported exported_by(const char* type, const Value& options, const testing::Inputs& inputs,
                            const Value& origin = Value::Map{})
{
    Exported result;
    const auto folder = result.folder->path();
    testing::TestRun run;
    run.origin_given = origin;
    testing::run_stage(FRESCO_PLUGIN_FILE, type, options, inputs, folder, run, {{"image_io", std::make_shared<Codec>()}});
    result.names = Files::load({folder / "files", folder})->names;
    result.file = read_text_file(result.path(result.names.at(0)));
    result.report = run.reported;
    result.messages = run.messages;
    return result;
}

/// A relief of 8 x 8 texels with one normal everywhere.
inline std::shared_ptr<Relief> even_relief(const Mesh& mesh, Vec3f normal)
{
    auto relief = std::make_shared<Relief>();
    relief->atlas = atlas_id(mesh);
    relief->normals = Raster16(8, 8, 3);
    relief->roughness = Raster8(8, 8, 1, 99);
    for (std::size_t texel = 0; texel < 64; ++texel)
        relief->set_normal(texel, normalized(normal));
    return relief;
}

inline bool holds_png(const std::string& bytes, const Raster8& picture)
{
    return std::ranges::equal(std::as_bytes(std::span(bytes)), stored_png::Codec().encode_png(picture));
}

}  // namespace exported_files
