#pragma once

#include "catch.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/testing.h>
#include <fresco/texture.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

/// \file Runs export.gltf and takes its file apart without the plugin's own reader.

/// The two chunks of a GLB file.
struct Glb
{
    nlohmann::json json;
    std::string binary;

    explicit Glb(const std::string& file)
    {
        REQUIRE(word(file, 0) == 0x46546C67U);
        REQUIRE(word(file, 4) == 2);
        REQUIRE(word(file, 8) == file.size());
        const std::size_t json_bytes = word(file, 12);
        REQUIRE(json_bytes % 4 == 0);
        REQUIRE(word(file, 16) == 0x4E4F534AU);
        json = nlohmann::json::parse(file.substr(20, json_bytes));
        REQUIRE(word(file, 24 + json_bytes) == 0x004E4942U);
        REQUIRE(word(file, 20 + json_bytes) == file.size() - 28 - json_bytes);
        binary = file.substr(28 + json_bytes);
    }

    static std::uint32_t word(const std::string& bytes, std::size_t at)
    {
        std::uint32_t v = 0;
        std::memcpy(&v, &bytes.at(at), 4);
        return v;
    }

    template <class T>
    std::vector<T> values(int accessor, std::size_t per_element) const
    {
        const auto& a = json.at("accessors").at(static_cast<std::size_t>(accessor));
        const auto& view = json.at("bufferViews").at(a.at("bufferView").get<std::size_t>());
        std::vector<T> result(a.at("count").get<std::size_t>() * per_element);
        std::memcpy(result.data(), binary.data() + view.value("byteOffset", std::size_t{0}), result.size() * sizeof(T));
        return result;
    }

    const nlohmann::json& primitive() const { return json.at("meshes").at(0).at("primitives").at(0); }
    const nlohmann::json& view_of(const char* attribute) const
    {
        const std::size_t accessor = primitive().at("attributes").at(attribute).get<std::size_t>();
        return json.at("bufferViews").at(json.at("accessors").at(accessor).at("bufferView").get<std::size_t>());
    }
};

inline fresco::TexturedMesh square()
{
    fresco::TexturedMesh textured;
    textured.mesh.positions = {{0.1F, 0.2F, 0.3F}, {1, 0, 0}, {1, 1, -2}, {0, 1, 0}};
    textured.mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 2, 2}};
    textured.mesh.texcoords = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 0.75F}, {1, 0}, {1, 1}, {1, 1}};
    textured.image = fresco::Image(fresco::Raster8(8, 8, 3, 77));
    textured.image.pixels.at(2, 1, 0) = 200;
    return textured;
}

struct Exported
{
    std::string file;
    std::vector<std::string> names;
    fresco::Value report;
    std::vector<std::string> messages;
};

inline Exported exported_from(const fresco::Value& options, const fresco::testing::Inputs& inputs,
                              const fresco::Value& origin = fresco::Value::Map{})
{
    fresco::testing::TemporaryFolder folder;
    fresco::testing::TestRun run;
    run.origin_given = origin;
    fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "export.gltf", options, inputs, folder.path(), run,
                               {{"image_io", std::make_shared<stored_png::Codec>()}});
    const auto files = fresco::Files::load({folder.path() / "files", folder.path()});
    return {fresco::read_text_file(folder.path() / "files" / files->names.at(0)), files->names, run.reported, run.messages};
}

/// A floor that looks along `up`, and a frame whose camera stands on it, looks level, and is 10 degrees off around its axis.
inline fresco::testing::Inputs leaning_floor(fresco::Vec3d up)
{
    using namespace fresco;
    const Vec3d right = normalized(cross(Vec3d{0.3, 0.5, 0.7}, up));
    const Vec3d ahead = cross(up, right);
    const auto textured = std::make_shared<TexturedMesh>(square());
    textured->mesh.positions = {{}, vec_cast<float>(right), vec_cast<float>(right + ahead), vec_cast<float>(ahead)};
    textured->mesh.triangles.pop_back();
    textured->mesh.texcoords.resize(6);
    const Vec3d x = right * std::cos(0.1745) + up * std::sin(0.1745);
    const Vec3d y = cross(ahead, x);
    const auto frames = std::make_shared<Frames>();
    frames->frames.emplace_back().color.world_from_camera.rotation.m = {x.x, y.x, ahead.x, x.y, y.y, ahead.y, x.z, y.z, ahead.z};
    return {{"textured_mesh", textured}, {"frames", frames}};
}

inline Exported exported(const fresco::Value& options, const fresco::TexturedMesh& textured = square())
{
    return exported_from(options, {{"textured_mesh", std::make_shared<fresco::TexturedMesh>(textured)}});
}
