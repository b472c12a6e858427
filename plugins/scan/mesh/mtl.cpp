#include "mtl.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <charconv>
#include <cmath>
#include <utility>

namespace scan_mesh
{

namespace
{

constexpr std::string_view blanks = " \t\r";

std::string_view trimmed(std::string_view text)
{
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    return text.substr(0, text.find_last_not_of(blanks) + 1);
}

/// Takes the first word off a line.
std::string_view next_word(std::string_view& rest)
{
    rest = trimmed(rest);
    const std::string_view word = rest.substr(0, rest.find_first_of(blanks));
    rest.remove_prefix(word.size());
    return word;
}

bool parse_number(std::string_view word, double& value)
{
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc{} && end == word.data() + word.size() && std::isfinite(value);
}

class MtlReader
{
  public:
    MtlReader(std::string_view text, std::string_view source) : lines_(text, source, fresco::recordings::LastLine::any)
    {
        while (const auto line = lines_.next())
        {
            std::string_view rest = *line;
            const std::string_view keyword = next_word(rest);
            if (keyword == "newmtl")
                materials.emplace_back().name = trimmed(rest);
            else if (keyword == "Kd")
                color(rest);
            else if (keyword == "map_Kd")
                picture(rest);
        }
    }

    std::vector<MtlMaterial> materials;

  private:
    [[noreturn]] void fail(const std::string& what) const { throw fresco::Error(lines_.place() + ": " + what); }

    MtlMaterial& current()
    {
        if (materials.empty())
            fail("expected 'newmtl NAME' before the first material's properties");
        return materials.back();
    }

    /// Up to three numbers at the beginning of `rest`.
    std::size_t numbers(std::string_view& rest, std::array<double, 3>& values) const
    {
        std::size_t count = 0;
        while (count < values.size())
        {
            std::string_view after = rest;
            if (!parse_number(next_word(after), values[count]))
                break;
            rest = after;
            ++count;
        }
        return count;
    }

    void color(std::string_view rest)
    {
        std::array<double, 3> values{};
        const std::size_t count = numbers(rest, values);
        if (count == 1)
            values[1] = values[2] = values[0];
        if ((count != 1 && count != 3) || !trimmed(rest).empty())
            fail("expected 'Kd R G B' with numbers from 0 to 1");
        current().color = values;
    }

    void picture(std::string_view rest)
    {
        MtlMaterial& material = current();
        material.scale = {1, 1};
        material.offset = {};
        while (trimmed(rest).starts_with('-'))
            option(next_word(rest), rest, material);
        material.picture = trimmed(rest);
        material.picture_line = lines_.line();
        if (material.picture.empty())
            fail("expected the name of a picture after map_Kd");
    }

    void option(std::string_view name, std::string_view& rest, MtlMaterial& material) const
    {
        std::array<double, 3> values{};
        if (name == "-s" || name == "-o")
        {
            const std::size_t count = numbers(rest, values);
            if (count == 0)
                fail("expected a number after " + std::string(name));
            if (name == "-s")
                material.scale = {values[0], count > 1 ? values[1] : 1};
            else
                material.offset = {values[0], values[1]};
        }
        else if (name == "-clamp")
            material.clamp = next_word(rest) == "on";
        else if (name == "-mm" || name == "-t")
            numbers(rest, values);
        else if (name == "-blendu" || name == "-blendv" || name == "-cc" || name == "-boost" || name == "-bm" ||
                 name == "-imfchan" || name == "-texres" || name == "-type" || name == "-colorspace")
            next_word(rest);
        else
            fail("unknown option \"" + std::string(name.substr(0, 40)) + "\" of map_Kd");
    }

    fresco::recordings::LineReader lines_;
};

}  // namespace

std::vector<MtlMaterial> parse_mtl(std::string_view text, std::string_view source)
{
    return MtlReader(text, source).materials;
}

}  // namespace scan_mesh
