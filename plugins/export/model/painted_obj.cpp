#include "painted_model.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/gltf/model_folder.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <map>
#include <string_view>
#include <utility>

namespace export_model
{

namespace fs = std::filesystem;
using fresco::Vec2f;

namespace
{

constexpr std::string_view blanks = " \t\r\n";

/// The next word of a text, which is left without it; empty at its end.
std::string_view next_word(std::string_view& rest)
{
    rest.remove_prefix(std::min(rest.find_first_not_of(blanks), rest.size()));
    const std::string_view word = rest.substr(0, rest.find_first_of(blanks));
    rest.remove_prefix(word.size());
    return word;
}

std::string trimmed(std::string_view text)
{
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    return std::string(text.substr(0, text.find_last_not_of(blanks) + 1));
}

/// Statements with their ends of lines: a line that ends in a backslash goes on in the next one.
std::vector<std::string_view> statements_of(std::string_view text)
{
    const char end = text.find('\n') == std::string_view::npos ? '\r' : '\n';
    std::vector<std::string_view> statements;
    for (std::size_t begin = 0, at = 0; at < text.size(); begin = at)
    {
        bool goes_on = true;
        while (goes_on && at < text.size())
        {
            const std::size_t stop = std::min(text.find(end, at), text.size());
            std::string_view line = text.substr(at, stop - at);
            if (line.ends_with('\r'))
                line.remove_suffix(1);
            goes_on = line.ends_with('\\');
            at = std::min(stop + 1, text.size());
        }
        statements.push_back(text.substr(begin, at - begin));
    }
    return statements;
}

/// The MTL of a painted OBJ: the picture in place of each material's color. Statements that show nothing by texture coordinates
/// stay, and with the file's own texture coordinates all others do, too.
class MaterialWriter
{
  public:
    MaterialWriter(const fs::path& model, const Painting& painting, const std::string& picture, PaintedFiles& result)
        : folder_(model), keeps_maps_(painting.keeps_uvs), picture_(picture), result_(result)
    {
    }

    std::string text(const std::vector<std::string>& libraries, const std::vector<std::string>& materials)
    {
        for (const std::string& library : libraries)
        {
            // One name with spaces, or several names.
            std::string_view rest = library;
            if (folder_.has(library))
                read(library);
            else
                for (std::string_view name = next_word(rest); !name.empty(); name = next_word(rest))
                    if (folder_.has(name))
                        read(std::string(name));
        }
        std::string text;
        for (const std::string& material : materials)
            text += "newmtl " + material + "\nKd 1 1 1\nmap_Kd " + picture_ + "\n" + kept_[material] + "\n";
        if (maps_left_out_ > 0)
            result_.messages.push_back(fmt::format(
                "{} pictures of the materials besides the color are left out, since an OBJ has one set of texture coordinates",
                maps_left_out_));
        return text;
    }

  private:
    void read(const std::string& library)
    {
        result_.files_read.push_back(folder_.find(library, "mtllib"));
        const std::string all = fresco::read_text_file(result_.files_read.back());
        std::string* material = nullptr;
        for (const std::string_view statement : statements_of(all))
        {
            std::string_view rest = statement;
            const std::string_view word = next_word(rest);
            const bool is_map = word.starts_with("map_") || word == "bump" || word == "disp" || word == "decal" ||
                                word == "norm" || word == "refl";
            if (word == "newmtl")
                material = &kept_[trimmed(rest)];
            else if (material == nullptr || word.empty() || word == "Kd" || word == "map_Kd")
                continue;
            else if (!is_map)
                *material += trimmed(statement) + "\n";
            else if (keeps_maps_)
                keep_map(trimmed(statement), *material);
            else
                ++maps_left_out_;
        }
    }

    /// A picture other than the color's goes along under its own name.
    void keep_map(const std::string& statement, std::string& material)
    {
        const std::string name = statement.substr(statement.find_last_of(blanks) + 1);
        if (!folder_.has(name))
            return;
        const fs::path file = folder_.find(name, "map");
        const std::string flat = file.filename().string();
        material += statement.substr(0, statement.size() - name.size()) + flat + "\n";
        if (std::ranges::find(result_.files_read, file) != result_.files_read.end())
            return;
        result_.files_read.push_back(file);
        const auto bytes = fresco::read_file(file);
        result_.files.emplace_back(flat, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    }

    fresco::gltf::ModelFolder folder_;
    bool keeps_maps_;
    std::string picture_;
    PaintedFiles& result_;
    std::map<std::string, std::string> kept_;
    std::size_t maps_left_out_ = 0;
};

class ObjPainter
{
  public:
    ObjPainter(const Painting& painting, PaintedFiles& result) : painting_(painting), result_(result) {}

    void add(std::string_view statement)
    {
        std::string_view rest = statement;
        const std::string_view word = next_word(rest);
        if (word == "mtllib")
            libraries.push_back(trimmed(rest));
        else if (word == "f")
            add_face(statement, rest.substr(0, rest.find('#')));
        else if (word != "vt" || painting_.keeps_uvs)
        {
            vertices_ += word == "v" ? 1 : 0;
            if (word == "usemtl")
                use(trimmed(rest));
            body += statement;
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
        has_material_ = true;
        if (std::ranges::find(materials, material) == materials.end())
            materials.push_back(material);
    }

    Corner corner_of(std::string_view word) const
    {
        Corner corner;
        const auto first = std::min(word.find('/'), word.size());
        const auto second = std::min(word.find('/', first + 1), word.size());
        corner.vertex = word.substr(0, first);
        corner.normal = second < word.size() ? word.substr(second + 1) : "";
        std::from_chars(corner.vertex.data(), corner.vertex.data() + corner.vertex.size(), corner.index);
        if (corner.index < 0)
            corner.index += vertices_ + 1;
        return corner;
    }

    void add_face(std::string_view statement, std::string_view rest)
    {
        if (!has_material_)
        {
            use("painted");
            body += "usemtl painted\n";
        }
        std::vector<Corner> corners;
        for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest))
            if (word != "\\")
                corners.push_back(corner_of(word));
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
            body += statement;
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
    bool has_material_ = false;
    std::int64_t vertices_ = 0;
    std::map<std::pair<float, float>, std::size_t> numbers_;
    std::vector<std::pair<float, float>> written_;
};

}  // namespace

PaintedFiles painted_obj(const fs::path& file, const Painting& painting)
{
    PaintedFiles result;
    const std::string text = fresco::read_text_file(file, std::size_t{1} << 33U);
    std::string_view rest = text;
    constexpr std::string_view mark = "\xEF\xBB\xBF";
    if (rest.starts_with(mark))
        rest.remove_prefix(mark.size());
    ObjPainter painter(painting, result);
    for (const std::string_view statement : statements_of(rest))
        painter.add(statement);
    check_faces(file, painter.faces, painting);
    const Picture picture = painting.picture({});
    const std::string picture_name = painting.name + picture.extension;
    const std::string materials = MaterialWriter(file, painting, picture_name, result).text(painter.libraries, painter.materials);
    std::vector<std::pair<std::string, std::string>> own{
        {painting.name + ".obj", "mtllib " + painting.name + ".mtl\n" + painter.texcoords() + painter.body},
        {painting.name + ".mtl", materials},
        {picture_name, std::string(reinterpret_cast<const char*>(picture.bytes.data()), picture.bytes.size())}};
    result.files.insert(result.files.begin(), own.begin(), own.end());
    return result;
}

}  // namespace export_model
