#include "painted_model.h"

#include <fresco/error.h>
#include <fresco/files_io.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string_view>

namespace export_model
{

namespace fs = std::filesystem;
using fresco::Error;
using fresco::Vec2f;

namespace
{

constexpr std::string_view spaces = " \t\r";

struct Property
{
    std::string line;  ///< As declared.
    std::string name;
    std::string count_type;  ///< Type of a list's count; empty: no list.
    std::string type;
};

struct Element
{
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
};

struct Header
{
    std::string format;
    std::vector<std::string> comments;  ///< Lines of comments other than TextureFile, and of obj_info.
    std::size_t pictures = 0;           ///< Lines of TextureFile.
    std::vector<Element> elements;
    std::size_t bytes = 0;
};

std::vector<std::string> words_of(std::string_view line)
{
    std::vector<std::string> words;
    for (std::size_t begin = line.find_first_not_of(spaces); begin < line.size(); begin = line.find_first_not_of(spaces, begin))
    {
        const std::size_t end = std::min(line.find_first_of(spaces, begin), line.size());
        words.emplace_back(line.substr(begin, end - begin));
        begin = end;
    }
    return words;
}

std::size_t size_of(std::string_view type)
{
    static const std::map<std::string_view, std::size_t> sizes{
        {"char", 1}, {"int8", 1},  {"uchar", 1}, {"uint8", 1},  {"short", 2}, {"int16", 2},   {"ushort", 2}, {"uint16", 2},
        {"int", 4},  {"int32", 4}, {"uint", 4},  {"uint32", 4}, {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
    const auto found = sizes.find(type);
    if (found == sizes.end())
        throw Error("the header has a type that PLY does not have: " + std::string(type.substr(0, 40)));
    return found->second;
}

/// The reader knows this header; a file that changed since then is refused.
Header header_of(std::string_view text)
{
    Header header;
    while (true)
    {
        const std::size_t end = text.find('\n', header.bytes);
        if (end == std::string_view::npos)
            throw Error("the header does not end");
        std::string_view line = text.substr(header.bytes, end - header.bytes);
        header.bytes = end + 1;
        if (line.ends_with('\r'))
            line.remove_suffix(1);
        const auto words = words_of(line);
        const std::string first = words.empty() ? "" : words[0];
        if (first == "end_header")
            return header;
        if (first == "format")
            header.format = line;
        else if (first == "comment" && words.size() > 1 && words[1] == "TextureFile")
            ++header.pictures;
        else if (first == "comment" || first == "obj_info")
            header.comments.emplace_back(line);
        else if (first == "element" && words.size() == 3)
        {
            Element element{words[1], 0, {}};
            const char* const digits_end = words[2].data() + words[2].size();
            if (std::from_chars(words[2].data(), digits_end, element.count).ptr != digits_end)
                throw Error("the header has a count that is no number: " + words[2].substr(0, 40));
            header.elements.push_back(std::move(element));
        }
        else if (const bool is_list = words.size() == 5 && words[1] == "list";
                 first == "property" && !header.elements.empty() && (is_list || words.size() == 3))
        {
            header.elements.back().properties.push_back(
                {std::string(line), words.back(), is_list ? words[2] : "", is_list ? words[3] : words[1]});
            size_of(header.elements.back().properties.back().type);
        }
        else if (first != "ply" && !words.empty())
            throw Error("the header has an unknown line: " + std::string(line.substr(0, 60)));
    }
}

bool is_index_list(const Property& property)
{
    return !property.count_type.empty() && (property.name == "vertex_indices" || property.name == "vertex_index");
}

/// Walks over the values of a body. A value is its word in an ASCII file, and its bytes in a binary one.
class Body
{
  public:
    Body(std::string_view text, const std::string& format)
        : text_(text), is_ascii_(format.find("ascii") != std::string::npos), is_big_(format.find("big") != std::string::npos)
    {
    }

    /// A property of a row: its count and values, as they are.
    struct Values
    {
        std::string_view raw;
        std::vector<std::int64_t> integers;  ///< The items of the list of a face's vertices.
    };

    Values next(const Property& property)
    {
        const std::size_t begin = start();
        Values values;
        std::size_t count = 1;
        if (!property.count_type.empty())
            count = static_cast<std::size_t>(integer(value(property.count_type), property.count_type));
        for (std::size_t i = 0; i < count; ++i)
        {
            const std::string_view each = value(property.type);
            if (is_index_list(property))
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

    std::string integer_text(std::int64_t number, std::string_view type) const
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

    std::string_view value(std::string_view type)
    {
        const std::size_t begin = start();
        const std::size_t end = is_ascii_ ? std::min(text_.find_first_of(" \t\r\n", begin), text_.size()) : begin + size_of(type);
        if (end > text_.size() || end == begin)
            throw Error("the file ends inside a row");
        at_ = end;
        return text_.substr(begin, end - begin);
    }

    std::int64_t integer(std::string_view value, std::string_view type) const
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
            const bool is_signed = type.find('u') == std::string_view::npos;
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
bool is_replaced(const Element& element, const Property& property)
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
    PlyPainter(const fs::path& path, std::string_view text, const Header& header, const Painting& painting, PaintedFiles& result)
        : path_(path), header_(header), painting_(painting), result_(result), body_(text.substr(header.bytes), header.format)
    {
    }

    /// The rows with the new texcoords; `face_rows` receives the number of faces, of which those across a seam are split.
    std::string rows(std::size_t& face_rows)
    {
        std::string rows;
        for (const Element& element : header_.elements)
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

    std::string row(const Element& element)
    {
        std::string row;
        for (const Property& property : element.properties)
            if (const auto values = body_.next(property); !is_replaced(element, property))
                row += separated(std::string(values.raw));
        return element.properties.empty() ? "" : ended(row);
    }

    std::string face(const Element& element, std::size_t& face_rows)
    {
        std::vector<Body::Values> values;
        const Body::Values* corners = nullptr;
        const Property* list = nullptr;
        values.reserve(element.properties.size());
        for (const Property& property : element.properties)
        {
            values.push_back(body_.next(property));
            if (is_index_list(property))
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
                const Property& property = element.properties[i];
                if (is_replaced(element, property))
                    continue;
                if (chosen.empty() || !is_index_list(property))
                {
                    row += separated(std::string(values[i].raw));
                    continue;
                }
                row += separated(body_.integer_text(static_cast<std::int64_t>(chosen.size()), list->count_type));
                for (const std::size_t corner : chosen)
                    row += separated(body_.integer_text(v[corner], list->type));
            }
            const std::size_t count = chosen.empty() ? v.size() : chosen.size();
            row += separated(body_.integer_text(static_cast<std::int64_t>(2 * count), "uchar"));
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
    const Header& header_;
    const Painting& painting_;
    PaintedFiles& result_;
    Body body_;
    std::size_t faces_ = 0;
};

std::string header_text(const Header& header, const Painting& painting, const std::string& picture, std::size_t face_rows)
{
    std::string text = "ply\n" + header.format + "\n";
    for (const std::string& comment : header.comments)
        if (painting.keeps_uvs || !comment.starts_with("comment texture_px"))
            text += comment + "\n";
    // Faces name pictures by number.
    for (std::size_t i = 0; i < (painting.keeps_uvs ? std::max<std::size_t>(header.pictures, 1) : 1); ++i)
        text += "comment TextureFile " + picture + "\n";
    for (const Element& element : header.elements)
    {
        const bool is_changed = !painting.keeps_uvs && element.name == "face";
        text += fmt::format("element {} {}\n", element.name, is_changed ? face_rows : element.count);
        for (const Property& property : element.properties)
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
        const Header header = header_of(text);
        if (std::ranges::find(header.elements, "face", &Element::name) == header.elements.end())
            throw Error("the mesh has no faces, only strips, which hold no texture coordinates; set uvs: new");
        std::size_t face_rows = 0;
        std::string body = PlyPainter(file, text, header, painting, result).rows(face_rows);
        if (painting.keeps_uvs)
        {
            body = text.substr(header.bytes);
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
