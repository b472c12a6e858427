#pragma once

#include <fresco/mesh.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <fmt/format.h>
#include <map>
#include <span>
#include <string>
#include <string_view>

/// \file Writes small PLY files value by value in any encoding and with any types: the slow obvious counterpart of the reader.

enum class PlyEncoding
{
    ascii,
    little,
    big
};

inline const std::array<PlyEncoding, 3> all_encodings{PlyEncoding::ascii, PlyEncoding::little, PlyEncoding::big};

inline std::span<const std::byte> bytes_of(std::string_view text)
{
    return std::as_bytes(std::span(text.data(), text.size()));
}

class PlyText
{
  public:
    explicit PlyText(PlyEncoding encoding) : encoding_(encoding)
    {
        static constexpr std::string_view names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
        text = fmt::format("ply\nformat {} 1.0\n", names[static_cast<std::size_t>(encoding)]);
    }
    PlyText& line(std::string_view words)
    {
        text.append(words).append("\n");
        return *this;
    }

    /// One value of a type named as in the header.
    PlyText& value(std::string_view type, double v)
    {
        static const std::map<std::string_view, PlyText& (PlyText::*)(double)> puts{
            {"char", &PlyText::put<std::int8_t>},   {"uchar", &PlyText::put<std::uint8_t>},
            {"short", &PlyText::put<std::int16_t>}, {"ushort", &PlyText::put<std::uint16_t>},
            {"int", &PlyText::put<std::int32_t>},   {"uint", &PlyText::put<std::uint32_t>},
            {"float", &PlyText::put<float>},        {"double", &PlyText::put<double>}};
        return (this->*puts.at(type))(v);
    }
    PlyText& values(std::string_view type, std::initializer_list<double> list)
    {
        for (const double v : list)
            value(type, v);
        return *this;
    }
    PlyText& end_row()
    {
        if (encoding_ == PlyEncoding::ascii)
            text.back() = '\n';
        return *this;
    }

    std::string text;

  private:
    template <class T>
    PlyText& put(double v)
    {
        if (encoding_ == PlyEncoding::ascii)
        {
            text += fmt::format("{} ", static_cast<T>(v));
            return *this;
        }
        auto raw = std::bit_cast<std::array<char, sizeof(T)>>(static_cast<T>(v));
        if ((encoding_ == PlyEncoding::little) != (std::endian::native == std::endian::little))
            std::reverse(raw.begin(), raw.end());
        text.append(raw.data(), raw.size());
        return *this;
    }

    PlyEncoding encoding_;
};

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

inline std::string ply_of(const fresco::Mesh& mesh, PlyEncoding encoding, const PlyTypes& types = {})
{
    PlyText ply(encoding);
    ply.line("comment made for a test").line("element vertex " + std::to_string(mesh.positions.size()));
    for (const char* axis : {"x", "y", "z"})
        ply.line("property " + types.coordinate + " " + axis);
    if (!mesh.colors.empty())
        ply.line("property uchar red").line("property uchar green").line("property uchar blue");
    ply.line("element face " + std::to_string(mesh.triangles.size()));
    ply.line("property list " + types.count + " " + types.index + " vertex_indices").line("end_header");
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    {
        const auto& p = mesh.positions[i];
        ply.values(types.coordinate, {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
        if (!mesh.colors.empty())
            ply.values("uchar", {double(mesh.colors[i][0]), double(mesh.colors[i][1]), double(mesh.colors[i][2])});
        ply.end_row();
    }
    for (const auto& t : mesh.triangles)
        ply.value(types.count, 3).values(types.index, {double(t[0]), double(t[1]), double(t[2])}).end_row();
    return ply.text;
}

inline bool same_mesh(const fresco::Mesh& a, const fresco::Mesh& b)
{
    const auto same_bits = [](const auto& x, const auto& y)
    { return x.size() == y.size() && (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0); };
    return same_bits(a.positions, b.positions) && a.colors == b.colors && a.triangles == b.triangles &&
           same_bits(a.texcoords, b.texcoords) && a.charts == b.charts;
}
