#include "plain_viewer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace plain
{

namespace
{
using nlohmann::json;

void expect(bool condition, const char* what)
{
    if (!condition)
        throw std::runtime_error(std::string("not the GLB that was expected: ") + what);
}

std::uint32_t little_endian(const std::string& bytes, std::size_t at)
{
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes.at(at + i))) << (8 * i);
    return value;
}

double as_float(const std::string& bytes, std::size_t at)
{
    const std::uint32_t bits = little_endian(bytes, at);
    float value = 0;
    std::memcpy(&value, &bits, 4);
    return double{value};
}

/// Offset of an accessor's elements in the binary chunk.
std::size_t begin_of(const json& root, const json& accessor)
{
    const json& view = root.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
    expect(!view.contains("byteStride"), "interleaved data");
    return view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0});
}
}  // namespace

Model read_glb(const std::filesystem::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    expect(bytes.size() > 28 && bytes.substr(0, 4) == "glTF" && little_endian(bytes, 4) == 2, "header");
    const std::size_t json_size = little_endian(bytes, 12);
    const json root = json::parse(bytes.substr(20, json_size));
    const std::string binary = bytes.substr(28 + json_size);

    const json& primitive = root.at("meshes").at(0).at("primitives").at(0);
    expect(primitive.value("mode", 4) == 4, "triangles");
    const auto accessor = [&](const json& index) -> const json& { return root.at("accessors").at(index.get<std::size_t>()); };
    const json& indices = accessor(primitive.at("indices"));
    const json& positions = accessor(primitive.at("attributes").at("POSITION"));
    const json& texcoords = accessor(primitive.at("attributes").at("TEXCOORD_0"));
    const bool is_short = indices.at("componentType") == 5123;
    expect((is_short || indices.at("componentType") == 5125) && indices.at("type") == "SCALAR", "16-bit or 32-bit indices");
    expect(positions.at("componentType") == 5126 && positions.at("type") == "VEC3", "float positions");
    expect(texcoords.at("componentType") == 5126 && texcoords.at("type") == "VEC2", "float texcoords");

    Model model;
    const std::size_t index_begin = begin_of(root, indices);
    const std::size_t position_begin = begin_of(root, positions);
    const std::size_t texcoord_begin = begin_of(root, texcoords);
    for (std::size_t i = 0; i < indices.at("count").get<std::size_t>(); ++i)
    {
        const std::size_t vertex =
            is_short ? little_endian(binary, index_begin + 2 * i) & 0xFFFFU : little_endian(binary, index_begin + 4 * i);
        if (i % 3 == 0)
            model.triangles.emplace_back();
        Corner& corner = model.triangles.back()[i % 3];
        for (std::size_t axis = 0; axis < 3; ++axis)
            corner.position[axis] = as_float(binary, position_begin + 12 * vertex + 4 * axis);
        corner.u = as_float(binary, texcoord_begin + 8 * vertex);
        corner.v = as_float(binary, texcoord_begin + 8 * vertex + 4);
    }

    const json& view = root.at("bufferViews").at(root.at("images").at(0).at("bufferView").get<std::size_t>());
    const std::string picture = binary.substr(view.value("byteOffset", std::size_t{0}), view.at("byteLength").get<std::size_t>());
    model.picture.assign(picture.begin(), picture.end());
    return model;
}

namespace
{
Point cross(const Point& a, const Point& b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Point& a, const Point& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Point to_camera(const View& view, const Point& world)
{
    const auto& m = view.world_from_camera;
    const Point from_eye{world[0] - m[3], world[1] - m[7], world[2] - m[11]};
    return {dot({m[0], m[4], m[8]}, from_eye), dot({m[1], m[5], m[9]}, from_eye), dot({m[2], m[6], m[10]}, from_eye)};
}

/// A texture lookup as OpenGL defines it: linear, clamped to the edge.
std::array<double, 3> lookup(const Picture& picture, double u, double v, const Wrong& wrong)
{
    if (wrong.flipped_v)
        v = 1 - v;
    const double shift = wrong.half_texel ? 0 : 0.5;
    const double x = u * picture.width - shift;
    const double y = v * picture.height - shift;
    const double left = std::floor(x);
    const double top = std::floor(y);
    std::array<double, 3> result{};
    for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx)
        {
            const int tx = std::clamp(static_cast<int>(left) + dx, 0, picture.width - 1);
            const int ty = std::clamp(static_cast<int>(top) + dy, 0, picture.height - 1);
            const double share = (dx ? x - left : 1 - x + left) * (dy ? y - top : 1 - y + top);
            for (std::size_t c = 0; c < 3; ++c)
                result[c] += share * picture.rgb[3 * static_cast<std::size_t>(ty * picture.width + tx) + c];
        }
    return result;
}

/// A triangle in camera space; `rows[i]` dotted with a pixel's direction is corner i's weight times the triangle's volume.
struct Prepared
{
    const std::array<Corner, 3>* corners;
    std::array<Point, 3> rows;
    double volume;
};

Prepared prepare(const View& view, const std::array<Corner, 3>& corners)
{
    const Point a = to_camera(view, corners[0].position);
    const Point b = to_camera(view, corners[1].position);
    const Point c = to_camera(view, corners[2].position);
    return {&corners, {cross(b, c), cross(c, a), cross(a, b)}, dot(a, cross(b, c))};
}
}  // namespace

std::vector<Pixel> render(const Model& model, const Picture& picture, const View& view, const Wrong& wrong)
{
    std::vector<Prepared> prepared;
    for (const auto& triangle : model.triangles)
        prepared.push_back(prepare(view, triangle));

    std::vector<Pixel> pixels;
    for (int row = 0; row < view.height; ++row)
        for (int column = 0; column < view.width; ++column)
        {
            const double x = wrong.mirrored_axis ? view.width - (column + 0.5) : column + 0.5;
            const Point direction{(x - view.cx) / view.fx, (row + 0.5 - view.cy) / view.fy, 1};
            Pixel pixel;
            double nearest = std::numeric_limits<double>::infinity();
            for (const Prepared& t : prepared)
            {
                // direction = w0 a + w1 b + w2 c; the point direction * depth lies on the triangle for depth = 1 / (w0 + w1 +
                // w2).
                const Point w{dot(t.rows[0], direction) / t.volume, dot(t.rows[1], direction) / t.volume,
                              dot(t.rows[2], direction) / t.volume};
                const double sum = w[0] + w[1] + w[2];
                if (t.volume == 0 || w[0] < 0 || w[1] < 0 || w[2] < 0 || 1 / sum >= nearest)
                    continue;
                nearest = 1 / sum;
                // Corners that run counter-clockwise around the direction they are seen in have a negative volume.
                pixel.found = t.volume < 0;
                double u = 0;
                double v = 0;
                pixel.position = {};
                for (std::size_t i = 0; i < 3; ++i)
                {
                    const Corner& corner = (*t.corners)[i];
                    u += corner.u * w[i] / sum;
                    v += corner.v * w[i] / sum;
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        pixel.position[axis] += corner.position[axis] * w[i] / sum;
                }
                pixel.rgb = lookup(picture, u, v, wrong);
            }
            pixels.push_back(pixel);
        }
    return pixels;
}

}  // namespace plain
