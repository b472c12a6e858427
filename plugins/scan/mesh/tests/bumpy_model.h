#pragma once

#include "catch.h"
#include "file_model.h"
#include "model_samples.h"

#include <fresco/testing.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace model_samples
{

/// A bumpy surface of 12 x 10 vertices with texture coordinates, plain: what the compressed forms are compared with.
struct BumpyModel : TriangleSample
{
    static constexpr std::uint32_t columns = 12;
    static constexpr std::uint32_t rows = 10;
    static constexpr std::size_t positions_view = 1;
    static constexpr std::size_t texcoords_view = 2;
    static constexpr std::size_t indices_view = 3;
    std::vector<float> positions;
    std::vector<float> texcoords;
    std::vector<std::uint32_t> indices;

    BumpyModel()
    {
        for (std::uint32_t y = 0; y < rows; ++y)
            for (std::uint32_t x = 0; x < columns; ++x)
            {
                const float u = static_cast<float>(x) / columns, v = static_cast<float>(y) / rows;
                positions.insert(positions.end(), {4 * u, std::sin(7 * u) * std::cos(5 * v), 3 * v});
                texcoords.insert(texcoords.end(), {u, v});
                if (x == 0 || y == 0)
                    continue;
                const std::uint32_t a = (y - 1) * columns + x - 1, b = a + 1, c = a + columns, d = c + 1;
                indices.insert(indices.end(), {a, c, b, b, c, d});
            }
        const std::size_t count = std::size_t{rows} * columns;
        attributes.set("POSITION", sample.add_accessor(positions, "VEC3", 5126, count));
        attributes.set("TEXCOORD_0", sample.add_accessor(texcoords, "VEC2", 5126, count));
        primitive.set("indices", sample.add_accessor(indices, "SCALAR", 5125, indices.size()));
    }
};

inline scan_mesh::FileModel read_sample(const GltfSample& sample, const fresco::testing::TemporaryFolder& folder,
                                        bool with_materials = true)
{
    fresco::write_file(folder.path() / "a.glb", sample.glb());
    return scan_mesh::read_file_model(folder.path() / "a.glb", with_materials);
}

/// Every triangle as three rows of position and texture coordinate in steps of 1/512, the least first, sorted: equal for models
/// whose vertices and triangles only stand in another order.
inline std::vector<std::array<std::array<int, 5>, 3>> surface_of(const scan_mesh::FileModel& model)
{
    std::vector<std::array<std::array<int, 5>, 3>> all;
    const auto step = [](float v) { return static_cast<int>(std::lround(512 * v)); };
    for (std::size_t f = 0; f < model.mesh.triangles.size(); ++f)
    {
        std::array<std::array<int, 5>, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k)
        {
            const fresco::Vec3f p = model.mesh.positions[model.mesh.triangles[f][k]];
            const fresco::Vec2f uv = model.mesh.texcoords.at(3 * f + k);
            corners[k] = {step(p.x), step(p.y), step(p.z), step(uv.x), step(uv.y)};
        }
        std::ranges::rotate(corners, std::ranges::min_element(corners));
        all.push_back(corners);
    }
    std::ranges::sort(all);
    return all;
}

/// Checks a model from another program, which quantizes: every corner fits the formula, to 1/500, and the faces face the same
/// side.
inline void check_bumpy(const scan_mesh::FileModel& model)
{
    CHECK(model.mesh.triangles.size() == 198);
    double most = 0;
    for (std::size_t corner = 0; corner < 3 * model.mesh.triangles.size(); ++corner)
    {
        const fresco::Vec3f p = model.mesh.positions[model.mesh.triangles[corner / 3][corner % 3]];
        const fresco::Vec2f uv = model.mesh.texcoords.at(corner);
        for (const float difference : {p.x / 4 - uv.x, p.z / 3 - (1 - uv.y), p.y - std::sin(7 * p.x / 4) * std::cos(5 * p.z / 3)})
            most = std::max(most, std::abs(double{difference}));
    }
    CHECK(most < 0.002);
    double facing = 0;
    for (const fresco::Vec3f normal : face_normals(model.mesh))
        facing += double{normal.y};
    CHECK(facing > 132);
}

inline std::filesystem::path foreign_files()
{
    return std::filesystem::path(FRESCO_SOURCE_FOLDER) / "tests/fuzz/corpus";
}

}  // namespace model_samples
