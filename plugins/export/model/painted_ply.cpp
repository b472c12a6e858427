#include "painted_model.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/ply_header.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

namespace export_model
{

namespace fs = std::filesystem;
using fresco::Error;
using fresco::PlyElement;
using fresco::PlyFormat;
using fresco::PlyProperty;
using fresco::PlyType;
using fresco::Vec2f;

namespace
{

constexpr std::string_view spaces = " \t\r";

/// Walks over the values of a body. A value is its word in an ASCII file, and its bytes in a binary one.
class Body
{
  public:
    Body(std::string_view text, PlyFormat format)
        : text_(text), is_ascii_(format == PlyFormat::ascii), is_big_(format == PlyFormat::big_endian)
    {
    }

    /// A property of a row: its count and values, as they are.
    struct Values
    {
        std::string_view raw;
        std::vector<std::int64_t> integers;  ///< The items of the list of a face's vertices.
    };

    Values next(const PlyProperty& property, bool is_index_list)
    {
        const std::size_t begin = start();
        Values values;
        std::size_t count = 1;
        if (property.is_list)
            count = static_cast<std::size_t>(integer(value(property.count_type), property.count_type));
        for (std::size_t i = 0; i < count; ++i)
        {
            const std::string_view each = value(property.type);
            if (is_index_list)
                values.integers.push_back(integer(each, property.type));
        }
        values.raw = text_.substr(begin, at_ - begin);
        return values;
    }

    void end_row()
    {
        if (is_ascii_)
            at_ = std::min(text_.find('\n', at_), text_.size() - 1) + 1;
    }

    bool is_ascii() const { return is_ascii_; }
    std::string_view rest() const { return text_.substr(at_); }

    std::string integer_text(std::int64_t number, PlyType type) const
    {
        return is_ascii_ ? std::to_string(number) : raw(number, size_of(type));
    }
    std::string float_text(float number) const
    {
        return is_ascii_ ? fmt::format("{}", number) : raw(std::bit_cast<std::uint32_t>(number), 4);
    }

  private:
    std::size_t start()
    {
        if (is_ascii_)
            at_ = std::min(text_.find_first_not_of(spaces, at_), text_.size());
        return at_;
    }

    std::string_view value(PlyType type)
    {
        const std::size_t begin = start();
        const std::size_t end = is_ascii_ ? std::min(text_.find_first_of(" \t\r\n", begin), text_.size()) : begin + size_of(type);
        if (end > text_.size() || end == begin)
            throw Error("the file ends inside a row");
        at_ = end;
        return text_.substr(begin, end - begin);
    }

    std::int64_t integer(std::string_view value, PlyType type) const
    {
        std::int64_t number = 0;
        if (is_ascii_)
        {
            value.remove_prefix(value.starts_with('+') ? 1 : 0);
            std::from_chars(value.data(), value.data() + value.size(), number);
        }
        else
        {
            std::uint64_t bits = 0;
            for (std::size_t i = 0; i < value.size(); ++i)
                bits |= std::uint64_t{static_cast<unsigned char>(value[is_big_ ? value.size() - 1 - i : i])} << (8 * i);
            const bool is_signed = static_cast<unsigned>(type) % 2 == 0;
            const std::size_t unused = 64 - 8 * value.size();
            number = is_signed ? static_cast<std::int64_t>(bits << unused) >> unused : static_cast<std::int64_t>(bits);
        }
        if (number < 0)
            throw Error("a row has a negative number");
        return number;
    }

    std::string raw(std::int64_t number, std::size_t size) const
    {
        std::string bytes(size, '\0');
        for (std::size_t i = 0; i < size; ++i)
            bytes[is_big_ ? size - 1 - i : i] = static_cast<char>(static_cast<std::uint64_t>(number) >> (8 * i));
        return bytes;
    }

    std::string_view text_;
    std::size_t at_ = 0;
    bool is_ascii_;
    bool is_big_;
};

/// Whether new texcoords take the place of a property.
bool is_replaced(const PlyElement& element, const PlyProperty& property)
{
    static constexpr std::array<std::string_view, 8> of_vertex{"s",         "t",         "u",         "v",
                                                               "texture_u", "texture_v", "texture_s", "texture_t"};
    if (element.name == "vertex")
        return std::ranges::find(of_vertex, property.name) != of_vertex.end();
    return element.name == "face" && (property.name == "texcoord" || property.name == "texnumber" || property.name == "chart");
}

class PlyPainter
{
  public:
    PlyPainter(const fs::path& path, std::string_view text, const fresco::PlyHeader& header, const Painting& painting,
               PaintedFiles& result)
        : path_(path), header_(header), painting_(painting), result_(result),
          body_(text.substr(header.body_offset), header.format)
    {
    }

    /// The rows with the new texcoords; `face_rows` receives the number of faces, of which those across a seam are split.
    std::string rows(std::size_t& face_rows)
    {
        std::string rows;
        for (const PlyElement& element : header_.elements)
            for (std::size_t i = 0; i < element.count; ++i)
            {
                rows += element.name == "face" ? face(element, face_rows) : row(element);
                body_.end_row();
            }
        check_faces(path_, faces_, painting_);
        return rows.append(body_.rest());
    }

  private:
    std::string ended(std::string row) const
    {
        if (body_.is_ascii() && !row.empty())
            row.back() = '\n';
        return row;
    }

    std::string separated(const std::string& value) const { return body_.is_ascii() ? value + " " : value; }

    std::string row(const PlyElement& element)
    {
        std::string row;
        for (const PlyProperty& property : element.properties)
            if (const auto values = body_.next(property, false); !is_replaced(element, property))
                row += separated(std::string(values.raw));
        return element.properties.empty() ? "" : ended(row);
    }

    std::string face(const PlyElement& element, std::size_t& face_rows)
    {
        std::vector<Body::Values> values;
        const Body::Values* corners = nullptr;
        const PlyProperty* list = nullptr;
        values.reserve(element.properties.size());
        for (const PlyProperty& property : element.properties)
        {
            values.push_back(body_.next(property, is_index_list(element, property)));
            if (is_index_list(element, property))
            {
                corners = &values.back();
                list = &property;
            }
        }
        if (corners == nullptr)
            throw Error("the faces have no vertex_indices");
        const auto& v = corners->integers;
        std::vector<std::optional<Vec2f>> texcoords(v.size());
        std::vector<std::array<std::size_t, 3>> triangles;
        std::vector<std::array<Vec2f, 3>> own;
        bool agrees = true;
        for (std::size_t i = 2; i < v.size(); ++i)
        {
            const std::array<std::size_t, 3> at{0, i - 1, i};
            if (v[0] == v[i - 1] || v[i - 1] == v[i] || v[i] == v[0])
                continue;
            triangles.push_back(at);
            own.emplace_back();
            for (std::size_t k = 0; k < 3 && 3 * faces_ + k < painting_.atlas.texcoords.size(); ++k)
            {
                const Vec2f uv = painting_.atlas.texcoords[3 * faces_ + k];
                own.back()[k] = uv;
                agrees = agrees && texcoords[at[k]].value_or(uv) == uv;
                texcoords[at[k]] = uv;
            }
            ++faces_;
        }
        const auto written = [&](std::span<const std::size_t> chosen, const auto& uv_of)
        {
            ++face_rows;
            std::string row;
            for (std::size_t i = 0; i < values.size(); ++i)
            {
                const PlyProperty& property = element.properties[i];
                if (is_replaced(element, property))
                    continue;
                if (chosen.empty() || !is_index_list(element, property))
                {
                    row += separated(std::string(values[i].raw));
                    continue;
                }
                row += separated(body_.integer_text(static_cast<std::int64_t>(chosen.size()), list->count_type));
                for (const std::size_t corner : chosen)
                    row += separated(body_.integer_text(v[corner], list->type));
            }
            const std::size_t count = chosen.empty() ? v.size() : chosen.size();
            row += separated(body_.integer_text(static_cast<std::int64_t>(2 * count), PlyType::uint8));
            for (std::size_t k = 0; k < count; ++k)
                row += separated(body_.float_text(uv_of(k).x)) + separated(body_.float_text(uv_of(k).y));
            return ended(row);
        };
        // The count of the list has one byte.
        if (agrees && v.size() < 128)
            return written({}, [&](std::size_t k) { return texcoords[k].value_or(Vec2f{}); });
        ++result_.polygons_split;
        std::string rows;
        for (std::size_t i = 0; i < triangles.size(); ++i)
            rows += written(triangles[i], [&](std::size_t k) { return own[i][k]; });
        return rows;
    }

    const fs::path& path_;
    const fresco::PlyHeader& header_;
    const Painting& painting_;
    PaintedFiles& result_;
    Body body_;
    std::size_t faces_ = 0;
};

std::string header_text(const fresco::PlyHeader& header, const Painting& painting, const std::string& picture,
                        std::size_t face_rows)
{
    static constexpr std::array formats{"ascii", "binary_little_endian", "binary_big_endian"};
    std::string text = fmt::format("ply\nformat {} 1.0\n", formats[static_cast<std::size_t>(header.format)]);
    for (const std::string& comment : header.comments)
        if (painting.keeps_uvs || !comment.starts_with("comment texture_px"))
            text += comment + "\n";
    // Faces name pictures by number.
    for (std::size_t i = 0; i < (painting.keeps_uvs ? std::max<std::size_t>(header.pictures.size(), 1) : 1); ++i)
        text += "comment TextureFile " + picture + "\n";
    for (const PlyElement& element : header.elements)
    {
        const bool is_changed = !painting.keeps_uvs && element.name == "face";
        text += fmt::format("element {} {}\n", element.name, is_changed ? face_rows : element.count);
        for (const PlyProperty& property : element.properties)
            if (painting.keeps_uvs || !is_replaced(element, property))
                text += property.line + "\n";
        if (is_changed)
            text += "property list uchar float texcoord\n";
    }
    return text + "end_header\n";
}

}  // namespace

PaintedFiles painted_ply(const fs::path& file, const Painting& painting)
{
    PaintedFiles result;
    const auto bytes = fresco::read_file(file);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    try
    {
        const fresco::PlyHeader header = fresco::parse_ply_header(bytes, file.string());
        std::size_t face_rows = 0;
        std::string body = PlyPainter(file, text, header, painting, result).rows(face_rows);
        if (painting.keeps_uvs)
        {
            body = text.substr(header.body_offset);
            result.polygons_split = 0;
        }
        const Picture picture = painting.picture({});
        const std::string picture_name = painting.name + picture.extension;
        result.files = {{painting.name + ".ply", header_text(header, painting, picture_name, face_rows) + body},
                        {picture_name, std::string(reinterpret_cast<const char*>(picture.bytes.data()), picture.bytes.size())}};
    }
    catch (const Error& error)
    {
        const std::string what = error.what();
        throw Error(what.starts_with(file.string()) ? what : file.string() + ": " + what);
    }
    return result;
}

}  // namespace export_model
