#include "mesh_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <string>
#include <utility>

namespace fresco
{
namespace
{

using namespace detail;

// Grouping, materials, display, normals, and what has no area. Free-form curves and surfaces are not among them: leaving them out
// would change the shape. Points of their parameter spaces (vp) and weights (vw) alone do not.
constexpr std::array<std::string_view, 19> skipped_statements{
    "vn",     "vp", "vw", "g",   "o",     "s",        "mg",       "usemtl",     "mtllib",   "usemap",
    "maplib", "l",  "p",  "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj"};

/// Index of something declared elsewhere in the file: checked once everything has been read, because a face may come first.
struct Reference
{
    std::size_t greatest = 0;  ///< Greatest index used, counted from 1; 0: none.
    std::size_t line = 0;      ///< Line of that index.
};

class ObjReader
{
  public:
    /// `materials`: where names go; null if the caller wants none.
    ObjReader(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits, MeshReadReport& report,
              MeshMaterials* materials)
        : lines_(without_mark(as_text(bytes)), source, 0, true),
          max_vertices_(std::min<std::size_t>(limits.max_vertices, UINT32_MAX)), max_faces_(limits.max_faces), report_(report),
          fan_(report, false), materials_(materials)
    {
    }

    Mesh read()
    {
        std::string_view line;
        std::string joined;
        while (lines_.next(line))
            statement(continued(line, joined));
        check_references();
        place(mesh_, report_.positions, offset_for(report_.positions));
        color_vertices();
        if (mesh_.triangles.empty())
            lines_.fail("the file ends here without a triangle; export the scan as a triangle mesh");
        spread_texcoords();
        return std::move(mesh_);
    }

  private:
    /// Without the mark that some programs for Windows begin UTF-8 with.
    static std::string_view without_mark(std::string_view text)
    {
        constexpr std::string_view mark = "\xEF\xBB\xBF";
        return text.starts_with(mark) ? text.substr(mark.size()) : text;
    }

    /// The whole statement where a line ends in a backslash; `joined` holds its text then.
    std::string_view continued(std::string_view line, std::string& joined)
    {
        const bool is_comment = line.substr(0, line.find_first_not_of(" \t") + 1).ends_with('#');
        if (line.empty() || line.back() != '\\' || is_comment)
            return line;
        joined.clear();
        while (!line.empty() && line.back() == '\\')
        {
            joined.append(line.substr(0, line.size() - 1)).append(" ");
            if (!lines_.next(line))
                lines_.fail("the file ends after a line that must continue: it is truncated");
        }
        return joined.append(line);
    }

    void statement(std::string_view line)
    {
        words_ = Words(line.substr(0, line.find('#')));
        const auto keyword = words_.next();
        if (keyword.empty())
            return;
        if (lines_.is_open() && keyword.starts_with('v'))
            lines_.fail_open();
        if (keyword == "v")
            vertex();
        else if (keyword == "vt")
            texcoord();
        else if (keyword == "f")
            face();
        else if (materials_ != nullptr && keyword == "mtllib")
            materials_->files.push_back({rest_of(line, keyword), lines_.number()});
        else if (materials_ != nullptr && keyword == "usemtl")
            use_material(rest_of(line, keyword));
        else if (materials_ != nullptr && (keyword == "o" || keyword == "g"))
            materials_->groups.push_back({keyword == "o", rest_of(line, keyword)});
        else if (std::ranges::find(skipped_statements, keyword) == skipped_statements.end())
            lines_.fail("unknown statement " + in_quotes(keyword) + "; expected v, vt, vn, f, g, o, s, usemtl or mtllib");
    }

    /// A name: the line after its keyword, which may hold spaces and '#'.
    static std::string rest_of(std::string_view line, std::string_view keyword)
    {
        return std::string(trimmed(line.substr(static_cast<std::size_t>(keyword.data() - line.data()) + keyword.size())));
    }

    void use_material(const std::string& name)
    {
        const auto [found, is_new] = material_numbers_.try_emplace(name, static_cast<std::uint32_t>(materials_->names.size()));
        if (is_new)
            materials_->names.push_back({name, lines_.number()});
        material_ = found->second;
    }

    /// Reads the numbers up to the end of the line to values_; how many there are.
    std::size_t numbers(std::size_t least, std::size_t most, const char* expected)
    {
        std::size_t count = 0;
        values_.fill(0);
        for (auto word = words_.next(); !word.empty(); word = words_.next())
        {
            if (count == most)
                lines_.fail("unexpected " + in_quotes(word) + "; expected " + expected);
            if (!parse_number(word, values_[count]) || !std::isfinite(static_cast<float>(values_[count])))
                lines_.fail("expected a finite number instead of " + in_quotes(word));
            ++count;
        }
        if (count < least)
            lines_.fail(fmt::format("the line ends after {} numbers; expected {}", count, expected));
        return count;
    }

    void limit(std::size_t count, const char* what) const
    {
        if (count >= max_vertices_)
            lines_.fail(fmt::format("more than {} {}, the limit", max_vertices_, what));
    }

    void vertex()
    {
        static constexpr const char* expected = "'v X Y Z', 'v X Y Z 1', 'v X Y Z R G B' or 'v X Y Z R G B A'";
        limit(report_.positions.size(), "vertices");
        const std::size_t count = numbers(3, 7, expected);
        if (count == 5 || (count == 4 && values_[3] != 1.0))
            lines_.fail(std::string("expected ") + expected);
        const bool colored = count >= 6;
        if (!report_.positions.empty() && colored == colors_.empty())
            lines_.fail("some vertices have a color and some have none; expected all or none");
        report_.positions.push_back({values_[0], values_[1], values_[2]});
        if (colored)
        {
            colors_.push_back(vec_cast<float>(Vec3d{values_[3], values_[4], values_[5]}));
            for (std::size_t i = 3; i < 6; ++i)
            {
                if (values_[i] < 0 || values_[i] > 255)
                    lines_.fail("a vertex color is outside 0 to 1, and 0 to 255");
                greatest_color_ = std::max(greatest_color_, values_[i]);
            }
        }
    }

    /// Programs write colors from 0 to 1 or to 255.
    void color_vertices()
    {
        const float steps = greatest_color_ > 1 ? 1.0F : 255.0F;
        const auto channel = [&](float value) { return static_cast<std::uint8_t>(std::lround(value * steps)); };
        for (const Vec3f& color : colors_)
            mesh_.colors.push_back({channel(color.x), channel(color.y), channel(color.z)});
    }

    void texcoord()
    {
        limit(texcoords_.size(), "texture coordinates");
        numbers(1, 3, "'vt U', 'vt U V' or 'vt U V W'");
        texcoords_.push_back({static_cast<float>(values_[0]), static_cast<float>(values_[1])});
    }

    /// One part of a corner as an index from 0; a negative one counts back from what is declared so far.
    std::uint32_t index(std::string_view text, std::string_view corner, std::size_t declared, Reference& reference)
    {
        std::int64_t value = 0;
        if (!parse_number(text, value) || value == 0 || value > UINT32_MAX || value < -static_cast<std::int64_t>(declared))
            lines_.fail(
                fmt::format("wrong index in {}; expected 1 to the number declared, or -1 to -{}", in_quotes(corner), declared));
        const std::size_t from_one =
            value > 0 ? static_cast<std::size_t>(value) : declared + 1 - static_cast<std::size_t>(-value);
        if (from_one > reference.greatest)
            reference = {from_one, lines_.number()};
        return static_cast<std::uint32_t>(from_one - 1);
    }

    void corner(std::string_view text)
    {
        const auto first = text.find('/');
        const auto second = first == std::string_view::npos ? first : text.find('/', first + 1);
        if (std::ranges::count(text, '/') > 2)
            lines_.fail("wrong index in " + in_quotes(text) + "; expected V, V/VT, V//VN or V/VT/VN");
        // "1/" and "1//" have none, either. Normals are not read.
        const auto texcoord = first == std::string_view::npos ? "" : text.substr(first + 1, second - first - 1);
        if (!corners_.empty() && texcoord.empty() != corner_texcoords_.empty())
            lines_.fail("the corners of a face must all be of one form: V, V/VT, V//VN or V/VT/VN");
        corners_.push_back(index(text.substr(0, first), text, report_.positions.size(), used_vertices_));
        if (!texcoord.empty())
            corner_texcoords_.push_back(index(texcoord, text, texcoords_.size(), used_texcoords_));
    }

    /// Whether the last number of the last line could lack digits: with one more, it would still be an index. That of a normal
    /// does not matter.
    bool may_be_cut(std::string_view last) const
    {
        const auto slash = last.find('/');
        if (slash != last.rfind('/'))
            return false;
        std::int64_t value = 0;
        const auto declared = slash == std::string_view::npos ? report_.positions.size() : texcoords_.size();
        return parse_number(last.substr(slash + 1), value) && 10 * std::abs(value) <= static_cast<std::int64_t>(declared);
    }

    void face()
    {
        corners_.clear();
        corner_texcoords_.clear();
        std::string_view last;
        for (auto word = words_.next(); !word.empty(); word = words_.next())
            corner(last = word);
        if (lines_.is_open() && may_be_cut(last))
            lines_.fail_open();
        if (corners_.size() < 3)
            lines_.fail(fmt::format("a face of {} corners; expected 3 or more", corners_.size()));
        const bool textured = !corner_texcoords_.empty();
        some_textured_ = some_textured_ || textured;
        some_bare_ = some_bare_ || !textured;
        if (some_textured_ && some_bare_ && materials_ == nullptr)
            lines_.fail("some faces have texture coordinates and some have none; expected all or none");
        fan_.split(corners_,
                   [&](std::size_t a, std::size_t b, std::size_t c)
                   {
                       mesh_.triangles.push_back({corners_[a], corners_[b], corners_[c]});
                       if (textured)
                           triangle_texcoords_.push_back({corner_texcoords_[a], corner_texcoords_[b], corner_texcoords_[c]});
                       if (materials_ != nullptr)
                       {
                           materials_->of_face.push_back(material_);
                           materials_->group_of_face.push_back(static_cast<std::uint32_t>(materials_->groups.size()) - 1);
                           materials_->has_texcoords.push_back(textured ? 1 : 0);
                       }
                   });
        if (mesh_.triangles.size() > max_faces_)
            lines_.fail(fmt::format("more than {} triangles, the limit", max_faces_));
    }

    void check_references() const
    {
        const auto check = [&](const Reference& used, std::size_t declared, const char* what)
        {
            if (used.greatest > declared)
                lines_.fail_at(used.line, fmt::format("a face names {} {}, but only {} are declared: the file is cut or damaged",
                                                      what, used.greatest, declared));
        };
        check(used_vertices_, report_.positions.size(), "vertex");
        check(used_texcoords_, texcoords_.size(), "texture coordinate");
    }

    void spread_texcoords()
    {
        const bool mixed = some_textured_ && some_bare_;
        mesh_.texcoords.reserve(some_textured_ ? mesh_.triangles.size() * 3 : 0);
        auto next = triangle_texcoords_.begin();
        for (std::size_t face = 0; face < mesh_.triangles.size() && some_textured_; ++face)
        {
            if (mixed && materials_->has_texcoords[face] == 0)
            {
                mesh_.texcoords.insert(mesh_.texcoords.end(), 3, Vec2f{});
                continue;
            }
            for (const std::uint32_t corner : *next++)
                mesh_.texcoords.push_back(texcoords_[corner]);
        }
        if (materials_ != nullptr && !mixed)
            materials_->has_texcoords.clear();
    }

    Lines lines_;
    Words words_;
    std::array<double, 7> values_{};  ///< Numbers of the statement.
    std::size_t max_vertices_;
    std::size_t max_faces_;
    MeshReadReport& report_;
    TriangleFan fan_;
    Mesh mesh_;
    std::vector<Vec2f> texcoords_;
    std::vector<Triangle> triangle_texcoords_;  ///< Indices into texcoords_.
    std::vector<Vec3f> colors_;                 ///< As written.
    double greatest_color_ = 0;
    bool some_textured_ = false;
    bool some_bare_ = false;
    MeshMaterials* materials_;
    std::map<std::string, std::uint32_t> material_numbers_;
    std::uint32_t material_ = MeshMaterials::none;
    Reference used_vertices_;
    Reference used_texcoords_;
    std::vector<std::uint32_t> corners_;
    std::vector<std::uint32_t> corner_texcoords_;
};

}  // namespace

Mesh parse_obj(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits, MeshReadReport* report,
               MeshMaterials* materials)
{
    if (materials != nullptr)
        *materials = {};
    MeshReadReport counted;
    Mesh mesh = ObjReader(bytes, source, limits, counted, materials).read();
    if (report != nullptr)
        *report = std::move(counted);
    return mesh;
}

}  // namespace fresco
