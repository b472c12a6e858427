#include "painted_model.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/text.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <map>
#include <set>
#include <string_view>
#include <utility>

namespace export_model
{

namespace fs = std::filesystem;
using fresco::trimmed;
using fresco::Vec2f;
using fresco::Words;

namespace
{

/// Statements without their last end of line: a line that ends in a backslash goes on in the next one.
std::vector<std::string_view> statements_of(std::string_view text)
{
    const char end = text.find('\n') == std::string_view::npos ? '\r' : '\n';
    std::vector<std::string_view> statements;
    for (std::size_t begin = 0, at = 0; at < text.size(); begin = at)
    {
        std::string_view statement;
        for (bool goes_on = true; goes_on && at < text.size();)
        {
            const std::size_t stop = std::min(text.find(end, at), text.size());
            statement = text.substr(begin, stop - begin);
            if (statement.ends_with('\r'))
                statement.remove_suffix(1);
            goes_on = statement.ends_with('\\');
            at = std::min(stop + 1, text.size());
        }
        statements.push_back(statement);
    }
    return statements;
}

/// A statement in one line.
std::string joined(std::string_view statement)
{
    std::string line(statement.substr(0, statement.find('#')));
    for (std::size_t at = line.find('\\'); at != std::string::npos; at = line.find('\\', at + 1))
        if (at + 1 == line.size() || line[at + 1] == '\r' || line[at + 1] == '\n')
            line[at] = ' ';
    std::ranges::replace_if(
        line, [](char c) { return c == '\r' || c == '\n'; }, ' ');
    return line;
}

/// Takes the options of a map, such as "-s 2 2 1 -clamp on", from a text; the name of the picture is left.
std::string options_of(std::string_view& rest)
{
    std::string options;
    const auto is_value = [](std::string_view word)
    {
        double number = 0;
        return word == "on" || word == "off" ||
               std::from_chars(word.data(), word.data() + word.size(), number).ptr == word.data() + word.size();
    };
    Words words(rest);
    for (std::string_view word = words.next(); !word.empty(); word = words.next())
    {
        const bool is_option = word.size() > 1 && word[0] == '-' && !is_value(word);
        if (!is_option && (options.empty() || !is_value(word)))
            break;
        options += std::string(word) + " ";
        rest = words.rest();
    }
    return options;
}

/// The MTL of a painted OBJ. Painted materials have the picture in place of their color; what they show by other pictures stays
/// where the texture coordinates do. Other materials stay.
class MaterialWriter
{
  public:
    MaterialWriter(const fs::path& model, const Painting& painting, const std::string& picture, PaintedFiles& result)
        : folder_(model, result), painting_(painting), picture_(picture), result_(result)
    {
    }

    std::string text(const std::vector<std::string>& libraries, const std::vector<std::string>& materials,
                     const std::set<std::string>& painted)
    {
        for (const std::string& library : libraries)
        {
            // One name with spaces, or several names.
            Words names(library);
            if (folder_.has(library))
                read(library, painted);
            else
                for (std::string_view name = names.next(); !name.empty(); name = names.next())
                    if (folder_.has(name))
                        read(name, painted);
        }
        std::string text;
        for (const std::string& material : materials)
        {
            text += "newmtl " + material + "\n";
            if (painted.contains(material))
                text += "Kd 1 1 1\nmap_Kd " + placing_[material] + picture_ + "\n";
            text += kept_[material] + "\n";
        }
        if (maps_left_out_ > 0)
            result_.messages.push_back(fmt::format("{} picture{} other than the base color's {} left out: missing, or placed by "
                                                   "texture coordinates that the painting "
                                                   "replaces",
                                                   maps_left_out_, maps_left_out_ == 1 ? "" : "s",
                                                   maps_left_out_ == 1 ? "is" : "are"));
        return text;
    }

  private:
    void read(std::string_view library, const std::set<std::string>& painted)
    {
        const fs::path mtl = folder_.find(library, "mtllib");
        result_.files_read.push_back(mtl);
        const std::string all = fresco::read_text_file(mtl);
        std::string material;
        for (const std::string_view statement : statements_of(all))
        {
            const std::string line = joined(statement);
            Words words(line);
            const std::string_view word = words.next();
            std::string_view rest = words.rest();
            const bool is_map = word.starts_with("map_") || word == "bump" || word == "disp" || word == "decal" ||
                                word == "norm" || word == "refl";
            const bool is_color = word == "Kd" || word == "map_Kd";
            if (word == "newmtl")
                material = rest;
            else if (word == "map_Kd" && painting_.keeps_uvs && painted.contains(material))
                placing_[material] = options_of(rest);
            else if (word.empty() || (is_color && painted.contains(material)))
                continue;
            else if (is_map)
                keep_map(std::string(word), rest, mtl.parent_path(), kept_[material]);
            else
                kept_[material].append(trimmed(line)) += '\n';
        }
    }

    /// A picture other than the color's goes along, under a name that nothing else has.
    void keep_map(const std::string& word, std::string_view rest, const fs::path& folder, std::string& material)
    {
        const std::string options = options_of(rest);
        fs::path file;
        try
        {
            file = folder_.find(std::string(trimmed(rest)), word, {}, folder);
        }
        catch (const fresco::Error&)
        {
            file.clear();
        }
        if (!painting_.keeps_uvs || file.empty())
        {
            ++maps_left_out_;
            return;
        }
        const auto [name, is_new] = maps_.try_emplace(
            fs::canonical(file), fmt::format("{}_{}{}", painting_.name, maps_.size() + 1, file.extension().string()));
        material += fmt::format("{} {}{}\n", word, options, name->second);
        if (!is_new)
            return;
        result_.files_read.push_back(file);
        const auto bytes = fresco::read_file(file);
        result_.files.emplace_back(name->second, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    }

    fresco::recordings::ModelFolder folder_;
    const Painting& painting_;
    std::string picture_;
    PaintedFiles& result_;
    std::map<std::string, std::string> kept_;     ///< Statements of each material.
    std::map<std::string, std::string> placing_;  ///< Options of its picture.
    std::map<fs::path, std::string> maps_;
    std::size_t maps_left_out_ = 0;
};

class ObjPainter
{
  public:
    ObjPainter(const Painting& painting, PaintedFiles& result) : painting_(painting), result_(result) {}

    void add(std::string_view statement)
    {
        Words words(statement);
        const std::string_view word = words.next();
        if (word == "mtllib")
            libraries.emplace_back(words.rest());
        else if (word == "f" || word == "f\\")
            add_face(statement);
        else if (word == "v")
            add_vertex(statement);
        else if (word == "l" && !painting_.keeps_uvs)
            add_line(statement);
        else if (word != "vt" || painting_.keeps_uvs)
        {
            if (word == "usemtl")
                use(std::string(words.rest()));
            body.append(statement) += '\n';
        }
    }

    std::string texcoords() const
    {
        std::string text;
        for (const auto& [u, v] : written_)
            text += fmt::format("vt {} {}\n", u, v);
        return text;
    }

    std::string body;
    std::vector<std::string> libraries;
    std::vector<std::string> materials;
    std::set<std::string> painted;  ///< The materials of faces that show the picture.
    std::size_t faces = 0;

  private:
    struct Corner
    {
        std::string_view vertex;
        std::string_view normal;
        std::int64_t index = 0;  ///< The vertex, counted from 1.
        std::size_t texcoord = 0;
    };

    void use(const std::string& material)
    {
        material_ = material;
        if (known_materials_.insert(material).second)
            materials.push_back(material);
    }

    /// Colors behind a position went into the painting, and viewers would multiply it with them.
    void add_vertex(std::string_view statement)
    {
        ++vertices_;
        const std::string line = joined(statement);
        std::vector<std::string_view> words;
        Words rest(line);
        for (std::string_view word = rest.next(); !word.empty(); word = rest.next())
            words.push_back(word);
        if (words.size() >= 7)
            body += fmt::format("v {} {} {}\n", words[1], words[2], words[3]);
        else
            body.append(statement) += '\n';
    }

    void add_line(std::string_view statement)
    {
        const std::string line = joined(statement);
        Words words(line);
        std::string separator;
        for (std::string_view word = words.next(); !word.empty(); word = words.next())
        {
            body.append(separator).append(word.substr(0, word.find('/')));
            separator = " ";
        }
        body += '\n';
    }

    Corner corner_of(std::string_view word) const
    {
        Corner corner;
        const auto first = std::min(word.find('/'), word.size());
        const auto second = std::min(word.find('/', first + 1), word.size());
        corner.vertex = word.substr(0, first);
        corner.normal = second < word.size() ? word.substr(second + 1) : "";
        const std::string_view digits = corner.vertex.substr(corner.vertex.starts_with('+') ? 1 : 0);
        std::from_chars(digits.data(), digits.data() + digits.size(), corner.index);
        if (corner.index < 0)
            corner.index += vertices_ + 1;
        corner.texcoord = first + 1 < second ? 1 : 0;
        return corner;
    }

    void add_face(std::string_view statement)
    {
        if (material_.empty())
        {
            use("painted");
            body += "usemtl painted\n";
        }
        const std::string line = joined(statement);
        Words words(line);
        words.next();
        std::vector<Corner> corners;
        for (std::string_view word = words.next(); !word.empty(); word = words.next())
            corners.push_back(corner_of(word));
        if (!painting_.keeps_uvs || (!corners.empty() && corners[0].texcoord > 0))
            painted.insert(material_);
        // As the reader does it: a fan, without triangles that name a vertex twice.
        std::vector<std::array<Corner, 3>> triangles;
        bool agrees = true;
        std::vector<std::size_t> texcoord_of(corners.size(), 0);
        for (std::size_t i = 2; i < corners.size(); ++i)
        {
            const std::array<std::size_t, 3> at{0, i - 1, i};
            std::array<Corner, 3> triangle{corners[0], corners[i - 1], corners[i]};
            if (triangle[0].index == triangle[1].index || triangle[1].index == triangle[2].index ||
                triangle[2].index == triangle[0].index)
                continue;
            for (std::size_t k = 0; k < 3 && 3 * faces + k < painting_.atlas.texcoords.size() && !painting_.keeps_uvs; ++k)
            {
                triangle[k].texcoord = number_of(painting_.atlas.texcoords[3 * faces + k]);
                agrees = agrees && (texcoord_of[at[k]] == 0 || texcoord_of[at[k]] == triangle[k].texcoord);
                texcoord_of[at[k]] = triangle[k].texcoord;
            }
            ++faces;
            triangles.push_back(triangle);
        }
        if (painting_.keeps_uvs)
            body.append(statement) += '\n';
        else if (agrees)
        {
            for (std::size_t i = 0; i < corners.size(); ++i)
                corners[i].texcoord = std::max<std::size_t>(texcoord_of[i], 1);
            write(corners);
        }
        else
        {
            ++result_.polygons_split;
            for (const auto& triangle : triangles)
                write(triangle);
        }
    }

    std::size_t number_of(Vec2f uv)
    {
        const auto [found, is_new] = numbers_.try_emplace({uv.x, uv.y}, written_.size() + 1);
        if (is_new)
            written_.emplace_back(uv.x, uv.y);
        return found->second;
    }

    template <class Corners>
    void write(const Corners& corners)
    {
        body += "f";
        for (const Corner& corner : corners)
        {
            body += fmt::format(" {}/{}", corner.vertex, corner.texcoord);
            if (!corner.normal.empty())
                body += fmt::format("/{}", corner.normal);
        }
        body += "\n";
    }

    const Painting& painting_;
    PaintedFiles& result_;
    std::string material_;
    std::set<std::string> known_materials_;
    std::int64_t vertices_ = 0;
    std::map<std::pair<float, float>, std::size_t> numbers_;
    std::vector<std::pair<float, float>> written_;
};

}  // namespace

PaintedFiles painted_obj(const fs::path& file, const Painting& painting)
{
    PaintedFiles result;
    const auto bytes = fresco::read_file(file);
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    constexpr std::string_view mark = "\xEF\xBB\xBF";
    if (text.starts_with(mark))
        text.remove_prefix(mark.size());
    ObjPainter painter(painting, result);
    for (const std::string_view statement : statements_of(text))
        painter.add(statement);
    check_faces(file, painter.faces, painting);
    const Picture picture = painting.picture({});
    const std::string picture_name = painting.name + picture.extension;
    const std::string materials =
        MaterialWriter(file, painting, picture_name, result).text(painter.libraries, painter.materials, painter.painted);
    const std::vector<std::pair<std::string, std::string>> own{
        {painting.name + ".obj", "mtllib " + painting.name + ".mtl\n" + painter.texcoords() + painter.body},
        {painting.name + ".mtl", materials},
        {picture_name, std::string(reinterpret_cast<const char*>(picture.bytes.data()), picture.bytes.size())}};
    result.files.insert(result.files.begin(), own.begin(), own.end());
    return result;
}

}  // namespace export_model
