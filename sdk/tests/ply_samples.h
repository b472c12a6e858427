#pragma once

#include <fresco/mesh.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// \file Small meshes, and PLY files of them in any encoding and with any types.

inline const std::array<std::string, 3> all_encodings{"ascii", "binary_little_endian", "binary_big_endian"};

inline std::span<const std::byte> bytes_of(std::string_view text)
{
    return std::as_bytes(std::span(text.data(), text.size()));
}

template <class T>
std::string binary(double v, bool big)
{
    auto raw = std::bit_cast<std::array<char, sizeof(T)>>(static_cast<T>(v));
    if (big != (std::endian::native == std::endian::big))
        std::reverse(raw.begin(), raw.end());
    return {raw.begin(), raw.end()};
}

/// An ASCII file in another encoding, value by value: the slow obvious counterpart of the reader.
inline std::string in_encoding(const std::string& encoding, const std::string& ascii)
{
    static const std::map<std::string, std::string (*)(double, bool)> by_type{
        {"char", binary<std::int8_t>},     {"uchar", binary<std::uint8_t>}, {"short", binary<std::int16_t>},
        {"ushort", binary<std::uint16_t>}, {"int", binary<std::int32_t>},   {"uint", binary<std::uint32_t>},
        {"float", binary<float>},          {"double", binary<double>}};
    if (encoding == "ascii")
        return ascii;
    std::istringstream from(ascii);
    std::string text;
    std::vector<std::pair<int, std::vector<std::vector<std::string>>>> elements;
    for (std::string line; line != "end_header";)
    {
        std::getline(from, line);
        text += line == "format ascii 1.0" ? "format " + encoding + " 1.0\n" : line + "\n";
        std::istringstream words(line);
        const std::vector<std::string> declared{std::istream_iterator<std::string>(words), {}};
        if (declared[0] == "element")
            elements.push_back({std::stoi(declared[2]), {}});
        if (declared[0] == "property")
            elements.back().second.push_back(declared);
    }
    const auto copy_value = [&](const std::string& type)
    {
        std::string word;
        from >> word;
        text += by_type.at(type)(std::stod(word), encoding == "binary_big_endian");
        return std::stod(word);
    };
    for (const auto& [count, properties] : elements)
        for (int i = 0; i < count; ++i)
            for (const auto& property : properties)
            {
                const bool is_list = property[1] == "list";
                for (double left = is_list ? copy_value(property[2]) : 1; left > 0; --left)
                    copy_value(property[is_list ? 3 : 1]);
            }
    return text;
}

/// Two triangles of a unit square with a fold, with colors; every number is exact in float and in its text.
inline fresco::Mesh folded_square()
{
    fresco::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.25F}, {0, 1, -1.5F}};
    mesh.colors = {{0, 127, 255}, {1, 2, 3}, {10, 20, 30}, {255, 0, 7}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

struct PlyTypes
{
    std::string coordinate = "float";
    std::string index = "int";
    std::string count = "uchar";
};

inline std::string ply_of(const fresco::Mesh& mesh, const std::string& encoding, const PlyTypes& types = {})
{
    std::string text = "ply\nformat ascii 1.0\ncomment made for a test\n";
    text += fmt::format("element vertex {0}\nproperty {1} x\nproperty {1} y\nproperty {1} z\n", mesh.positions.size(),
                        types.coordinate);
    text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    text += fmt::format("element face {}\nproperty list {} {} vertex_indices\nend_header\n", mesh.triangles.size(), types.count,
                        types.index);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        text += fmt::format("{} {} {} {}\n", mesh.positions[i].x, mesh.positions[i].y, mesh.positions[i].z,
                            fmt::join(mesh.colors[i], " "));
    for (const auto& triangle : mesh.triangles)
        text += fmt::format("3 {}\n", fmt::join(triangle, " "));
    return in_encoding(encoding, text);
}

inline bool same_mesh(const fresco::Mesh& a, const fresco::Mesh& b)
{
    const auto same_bits = [](const auto& x, const auto& y)
    { return x.size() == y.size() && (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0); };
    return same_bits(a.positions, b.positions) && a.colors == b.colors && a.triangles == b.triangles &&
           same_bits(a.texcoords, b.texcoords) && a.charts == b.charts;
}
