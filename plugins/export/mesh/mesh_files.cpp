#include "mesh_files.h"

#include <fresco/geometry/topology.h>
#include <fresco/numerics/numerics.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
/// Appends numbers, a character before each, without regard to the locale; floats as the shortest text that reads back exactly.
template <class... Numbers>
void append(std::string& text, char before, Numbers... numbers)
{
    const auto append_one = [&](auto number)
    {
        std::array<char, 32> digits;
        const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
        text += before;
        text.append(digits.data(), error == std::errc{} ? end : digits.data());
    };
    (append_one(numbers), ...);
}

/// 3F: equal texcoords share a number, counted from 0 by first use.
std::vector<std::uint32_t> number_texcoords(const std::vector<Vec2f>& texcoords, std::vector<Vec2f>& unique)
{
    std::vector<std::uint32_t> number =
        numerics::first_equal(texcoords.size(), [&](std::uint32_t i) { return std::tuple(texcoords[i].x, texcoords[i].y); });
    for (const std::uint32_t corner : numerics::number_by_first(number, number.size()))
        unique.push_back(texcoords[corner]);
    return number;
}
}  // namespace

std::string obj_text(const Mesh& mesh, std::string_view material_file, std::string_view material, bool in_world)
{
    const bool is_double = in_world && mesh.offset_m != Vec3d{};
    const std::vector<Vec3d> world = is_double ? world_positions(mesh) : std::vector<Vec3d>{};
    std::vector<Vec2f> unique;
    const std::vector<std::uint32_t> number = number_texcoords(mesh.texcoords, unique);
    const bool has_material = !material_file.empty();
    const bool has_colors = !has_material && !mesh.colors.empty();
    std::string text = has_material ? "mtllib " + std::string(material_file) + "\n" : "";
    text += "o room\n";
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    {
        const auto append_point = [&text](auto p) { append(text, ' ', p.x, p.y, p.z); };
        text += 'v';
        is_double ? append_point(world[v]) : append_point(mesh.positions[v]);
        for (std::size_t c = 0; c < 3 && has_colors; ++c)
            append(text, ' ', static_cast<float>(mesh.colors[v][c]) / 255);
        text += '\n';
    }
    for (const Vec2f uv : unique)
    {
        text += "vt";
        append(text, ' ', uv.x, uv.y);
        text += '\n';
    }
    if (has_material)
        text += "usemtl " + std::string(material) + '\n';
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        text += 'f';
        for (std::size_t i = 0; i < 3; ++i)
        {
            append(text, ' ', mesh.triangles[face][i] + std::uint64_t{1});
            if (!number.empty())
                append(text, '/', number[3 * face + i] + std::uint64_t{1});
        }
        text += '\n';
    }
    return text;
}

std::string mtl_text(std::string_view material, std::string_view picture_file)
{
    return "newmtl " + std::string(material) + "\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nillum 0\nmap_Kd " + std::string(picture_file) +
           '\n';
}

namespace
{
constexpr int most_steps = 256;
constexpr Rgb8 gray{128, 128, 128};

using Corners = std::array<Vec2d, 3>;

/// The color at a place in texels.
const std::uint8_t* color_at(const Raster8& picture, Vec2d place)
{
    const auto texel = [&](double along) { return static_cast<int>(std::clamp(std::floor(along), 0.0, picture.width - 1.0)); };
    return &picture.values[picture.index(texel(place.x), texel(place.y))];
}

struct Sum
{
    Vec3d light;
    double weight = 0;
};

Corners texel_corners(const TexturedMesh& textured, std::size_t face)
{
    const double size = textured.image.pixels.width;
    Corners corners;
    for (std::size_t i = 0; i < 3; ++i)
    {
        const Vec2f uv = textured.mesh.texcoords[3 * face + i];
        corners[i] = {double{uv.x} * size, (1 - double{uv.y}) * size};
    }
    return corners;
}

/// Adds a face's texels to its corners: at the middles of n x n triangles of equal size, a texel wide at most.
void add_face(const Corners& corners, double area, const Raster8& picture, const std::array<Sum*, 3>& sums)
{
    const double longest =
        std::max({length(corners[1] - corners[0]), length(corners[2] - corners[1]), length(corners[0] - corners[2])});
    const int n = static_cast<int>(std::clamp(std::ceil(longest), 1.0, double{most_steps}));
    const auto add = [&](double first, double second)
    {
        const std::array<double, 3> shares{1 - (first + second) / n, first / n, second / n};
        const Vec2d place = corners[0] * shares[0] + corners[1] * shares[1] + corners[2] * shares[2];
        const std::uint8_t* const rgb = color_at(picture, place);
        const Vec3d light{to_linear(rgb[0]), to_linear(rgb[1]), to_linear(rgb[2])};
        for (std::size_t i = 0; i < 3; ++i)
        {
            const double weight = area / (double{1} * n * n) * shares[i];
            sums[i]->light += light * weight;
            sums[i]->weight += weight;
        }
    };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n - i; ++j)
        {
            add(i + 1.0 / 3, j + 1.0 / 3);
            if (j + 1 < n - i)
                add(i + 2.0 / 3, j + 2.0 / 3);
        }
}
}  // namespace

std::vector<Rgb8> vertex_colors(const TexturedMesh& textured, const Progress& progress)
{
    const Mesh& mesh = textured.mesh;
    const Raster8& picture = textured.image.pixels;
    std::vector<Sum> sums(mesh.positions.size());
    std::vector<Rgb8> result(mesh.positions.size(), gray);
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        if (face % 1024 == 0)
            progress.check_canceled();
        const Triangle& t = mesh.triangles[face];
        const Corners corners = texel_corners(textured, face);
        if (const double area = length(geometry::area_vector(mesh, face)) / 2; area > 0)
            add_face(corners, area, picture, {&sums[t[0]], &sums[t[1]], &sums[t[2]]});
        for (std::size_t i = 0; i < 3; ++i)
            std::copy_n(color_at(picture, corners[i]), 3, result[t[i]].begin());
    }
    for (std::size_t v = 0; v < sums.size(); ++v)
        if (sums[v].weight > 0)
        {
            const Vec3d light = sums[v].light * (1 / sums[v].weight);
            result[v] = {from_linear(light.x), from_linear(light.y), from_linear(light.z)};
        }
    return result;
}
