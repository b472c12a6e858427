#include "model_colors.h"

#include <fresco/geometry/topology.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/numerics/numerics.h>
#include <fresco/texturing/face_frame.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace from_model
{

using fresco::Mesh;
using fresco::Raster8;
using fresco::Vec2d;
using fresco::Vec3d;
using fresco::texturing::to_linear;

namespace
{

// No two sides of a box look at the lamp at a similar angle.
constexpr Vec3d lamp_direction{0.22, 0.53, 0.82};
constexpr double lamp_diagonals = 2;
constexpr double middle_lightness = 55;
constexpr double lamp_range = 27;
constexpr double bend_range = 8;
const double crease_cosine = std::cos(40 * std::acos(-1.0) / 180);

Vec3d position(const Mesh& mesh, std::uint32_t vertex)
{
    return fresco::vec_cast<double>(mesh.positions[vertex]);
}

/// V: how far the neighbors lie below the tangent plane, as the mean sine of the angle; positive where the surface is convex.
std::vector<double> vertex_bends(const Mesh& mesh)
{
    const auto normals = fresco::vertex_normals(mesh);
    std::vector<double> sums(mesh.positions.size(), 0);
    std::vector<double> counts(mesh.positions.size(), 0);
    const auto add = [&](std::uint32_t v, std::uint32_t neighbor)
    {
        sums[v] += dot(fresco::vec_cast<double>(normals[v]), normalized(position(mesh, v) - position(mesh, neighbor)));
        ++counts[v];
    };
    for (const auto& t : mesh.triangles)
        for (std::size_t i = 0; i < 3; ++i)
        {
            add(t[i], t[(i + 1) % 3]);
            add(t[(i + 1) % 3], t[i]);
        }
    for (std::size_t v = 0; v < sums.size(); ++v)
        sums[v] = counts[v] > 0 ? sums[v] / counts[v] : 0;
    return sums;
}

Vec3d lamp_of(const Mesh& mesh)
{
    fresco::numerics::Bounds<double> box;
    for (const auto& t : mesh.triangles)
        for (const std::uint32_t v : t)
            box.add(position(mesh, v));
    return (box.low + box.high) * 0.5 + lamp_direction * (lamp_diagonals * length(box.high - box.low));
}

/// CIE 15: the light of a lightness L*.
double light_of(double lightness)
{
    const double root = (lightness + 16) / 116;
    return root * root * root;
}

}  // namespace

std::vector<float> shape_lights(const Mesh& mesh)
{
    const auto faces = static_cast<std::uint32_t>(mesh.triangles.size());
    std::vector<Vec3d> normals;
    for (std::uint32_t face = 0; face < faces; ++face)
        normals.push_back(fresco::geometry::area_vector(mesh, face));
    const fresco::numerics::Buckets around(mesh.positions.size(),
                                           [&](const auto& add)
                                           {
                                               for (std::uint32_t face = 0; face < faces; ++face)
                                                   for (const std::uint32_t v : mesh.triangles[face])
                                                       add(v, face);
                                           });
    const auto bends = vertex_bends(mesh);
    const Vec3d lamp = lamp_of(mesh);
    std::vector<float> lights;
    lights.reserve(3 * mesh.triangles.size());
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        const Vec3d own = normalized(normals[face]);
        for (const std::uint32_t v : mesh.triangles[face])
        {
            Vec3d sum;
            for (const std::uint32_t other : around[v])
                if (dot(normalized(normals[other]), own) >= crease_cosine)
                    sum += normals[other];
            const double facing = dot(normalized(sum), normalized(lamp - position(mesh, v)));
            const double bend = std::clamp(2 * bends[v], -1.0, 1.0);
            lights.push_back(static_cast<float>(light_of(middle_lightness + lamp_range * facing + bend_range * bend)));
        }
    }
    return lights;
}

namespace
{

/// A coordinate brought near [0,1], where whole numbers of texels can be counted.
double near_unit(double at, fresco::Wrap wrap)
{
    if (wrap == fresco::Wrap::repeat)
        return at - std::floor(at);
    if (wrap == fresco::Wrap::mirror)
        return at - 2 * std::floor(at / 2);
    return std::clamp(at, -1.0, 2.0);
}

int wrapped(int at, int size, fresco::Wrap wrap)
{
    if (wrap == fresco::Wrap::clamp)
        return std::clamp(at, 0, size - 1);
    const int period = wrap == fresco::Wrap::mirror ? 2 * size : size;
    const int inside = (at % period + period) % period;
    return inside < size ? inside : period - 1 - inside;
}

Vec3d light_of(const std::uint8_t* rgb)
{
    return {to_linear(rgb[0]), to_linear(rgb[1]), to_linear(rgb[2])};
}

Vec3d product(Vec3d a, Vec3d b)
{
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

}  // namespace

ColorSource color_source(const fresco::Model& model)
{
    const auto has_picture = [&](std::uint32_t material)
    { return model.materials[material].picture != fresco::ModelMaterial::no_picture; };
    if (std::ranges::any_of(model.material_of_face, has_picture))
        return ColorSource::pictures;
    const auto color = [&](std::size_t face, std::size_t corner)
    {
        const auto& material = model.materials[model.material_of_face[face]];
        const fresco::Rgb8 white{255, 255, 255};
        const auto& vertex = material.vertex_colors ? model.mesh.colors[model.mesh.triangles[face][corner]] : white;
        return std::pair(std::array{material.color.x, material.color.y, material.color.z}, vertex);
    };
    const auto first = color(0, 0);
    for (std::size_t face = 0; face < model.mesh.triangles.size(); ++face)
        for (std::size_t corner = 0; corner < 3; ++corner)
            if (color(face, corner) != first)
                return ColorSource::colors;
    return ColorSource::shape;
}

Vec3d sample_wrapped(const Raster8& picture, Vec2d uv, fresco::Wrap wrap_u, fresco::Wrap wrap_v)
{
    const auto around = [](double at, int size, fresco::Wrap wrap)
    {
        const auto cells = fresco::numerics::between(near_unit(at, wrap) * size - 0.5);
        return fresco::numerics::Between<double>{wrapped(cells.first, size, wrap), wrapped(cells.second, size, wrap),
                                                 cells.share};
    };
    // Row 0 is v = 1: wrapping v wraps 1 - v likewise.
    return fresco::numerics::bilinear(around(uv.x, picture.width, wrap_u), around(1 - uv.y, picture.height, wrap_v),
                                      [&](int x, int y) { return light_of(&picture.at(x, y)); });
}

Raster8 halved(const Raster8& picture)
{
    Raster8 result(std::max(1, picture.width / 2), std::max(1, picture.height / 2), 3);
    const auto range = [](int at, int count, int size) { return std::pair(2 * at, at + 1 == count ? size : 2 * at + 2); };
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
        {
            const auto [first_row, end_row] = range(y, result.height, picture.height);
            const auto [first_column, end_column] = range(x, result.width, picture.width);
            Vec3d sum;
            for (int row = first_row; row < end_row; ++row)
                for (int column = first_column; column < end_column; ++column)
                    sum += light_of(&picture.at(column, row));
            const Vec3d mean = sum * (1.0 / ((end_row - first_row) * (end_column - first_column)));
            std::uint8_t* const rgb = &result.at(x, y);
            rgb[0] = fresco::texturing::from_linear(mean.x);
            rgb[1] = fresco::texturing::from_linear(mean.y);
            rgb[2] = fresco::texturing::from_linear(mean.z);
        }
    return result;
}

ModelColors::ModelColors(const fresco::Model& model, std::vector<Raster8> pictures)
    : model_(model), pictures_(std::move(pictures))
{
}

ModelColors::ModelColors(const fresco::Model& model) : model_(model), corner_lights_(shape_lights(model.mesh)) {}

Vec3d ModelColors::at(std::uint32_t face, const std::array<double, 3>& weights) const
{
    const std::size_t first = 3 * std::size_t{face};
    if (!corner_lights_.empty())
    {
        double light = 0;
        for (std::size_t i = 0; i < 3; ++i)
            light += double{corner_lights_[first + i]} * weights[i];
        return {light, light, light};
    }
    const auto& material = model_.materials[model_.material_of_face[face]];
    Vec3d color = fresco::vec_cast<double>(material.color);
    if (material.vertex_colors)
    {
        Vec3d mean;
        for (std::size_t i = 0; i < 3; ++i)
            mean += light_of(model_.mesh.colors[model_.mesh.triangles[face][i]].data()) * weights[i];
        color = product(color, mean);
    }
    if (material.picture == fresco::ModelMaterial::no_picture)
        return color;
    Vec2d uv;
    for (std::size_t i = 0; i < 3; ++i)
    {
        const fresco::Vec2f corner = model_.mesh.texcoords[first + i];
        uv = uv + Vec2d{corner.x, corner.y} * weights[i];
    }
    return product(color,
                   sample_wrapped(pictures_[static_cast<std::size_t>(material.picture)], uv, material.wrap_u, material.wrap_v));
}

double ModelColors::pixels_per_meter(std::uint32_t face) const
{
    const int picture = corner_lights_.empty() ? model_.materials[model_.material_of_face[face]].picture : -1;
    const double area = length(fresco::geometry::area_vector(model_.mesh, face));
    if (picture == fresco::ModelMaterial::no_picture || !(area > 0))
        return 0;
    const Raster8& pixels = pictures_[static_cast<std::size_t>(picture)];
    return std::sqrt(std::abs(fresco::texturing::FaceFrame(model_.mesh, face, 1).area) / area * pixels.width * pixels.height);
}

}  // namespace from_model
