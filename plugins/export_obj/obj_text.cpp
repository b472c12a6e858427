#include "obj_text.h"

#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

using namespace fresco;

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
    std::vector<std::uint32_t> order(texcoords.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto key = [&](std::uint32_t i) { return std::tuple(texcoords[i].x, texcoords[i].y); };
    std::ranges::sort(order, {}, [&](std::uint32_t i) { return std::tuple_cat(key(i), std::tuple(i)); });
    std::vector<std::uint32_t> number(texcoords.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        number[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? number[order[i - 1]] : order[i];
    for (const std::uint32_t corner : numerics::number_by_first(number, number.size()))
        unique.push_back(texcoords[corner]);
    return number;
}
}  // namespace

std::string obj_text(const Mesh& mesh, std::string_view material_file, std::string_view material)
{
    std::vector<Vec2f> unique;
    const std::vector<std::uint32_t> number = number_texcoords(mesh.texcoords, unique);
    const bool has_material = !material_file.empty();
    const bool has_colors = !has_material && !mesh.colors.empty();
    std::string text = has_material ? "mtllib " + std::string(material_file) + "\n" : "";
    text += "o room\n";
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    {
        const Vec3f p = mesh.positions[v];
        text += 'v';
        append(text, ' ', p.x, p.y, p.z);
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
