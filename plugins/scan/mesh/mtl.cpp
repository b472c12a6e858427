#include "mtl.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>
#include <fresco/text.h>

#include <array>
#include <cmath>
#include <utility>

namespace scan_mesh
{

namespace
{

using fresco::Words;

class MtlReader
{
  public:
    MtlReader(std::string_view text, std::string_view source) : lines_(text, source, fresco::recordings::LastLine::any)
    {
        while (const auto line = lines_.next())
        {
            Words words(*line);
            const std::string_view keyword = words.next();
            if (keyword == "newmtl")
                materials.emplace_back().name = words.rest();
            else if (keyword == "Kd")
                color(words);
            else if (keyword == "map_Kd")
                picture(words);
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

    /// Up to three numbers at the beginning of `words`.
    std::size_t numbers(Words& words, std::array<double, 3>& values) const
    {
        std::size_t count = 0;
        for (Words after = words;
             count < values.size() && fresco::parse_number(after.next(), values[count]) && std::isfinite(values[count]); ++count)
            words = after;
        return count;
    }

    void color(Words words)
    {
        std::array<double, 3> values{};
        const std::size_t count = numbers(words, values);
        if (count == 1)
            values[1] = values[2] = values[0];
        if ((count != 1 && count != 3) || !words.rest().empty())
            fail("expected 'Kd R G B' with numbers from 0 to 1");
        current().color = values;
    }

    void picture(Words words)
    {
        MtlMaterial& material = current();
        material.scale = {1, 1};
        material.offset = {};
        while (words.rest().starts_with('-'))
            option(words.next(), words, material);
        material.picture = words.rest();
        material.picture_line = lines_.line();
        if (material.picture.empty())
            fail("expected the name of a picture after map_Kd");
    }

    void option(std::string_view name, Words& words, MtlMaterial& material) const
    {
        std::array<double, 3> values{};
        if (name == "-s" || name == "-o")
        {
            const std::size_t count = numbers(words, values);
            if (count == 0)
                fail("expected a number after " + std::string(name));
            if (name == "-s")
                material.scale = {values[0], count > 1 ? values[1] : 1};
            else
                material.offset = {values[0], values[1]};
        }
        else if (name == "-clamp")
            material.clamp = words.next() == "on";
        else if (name == "-mm" || name == "-t")
            numbers(words, values);
        else if (name == "-blendu" || name == "-blendv" || name == "-cc" || name == "-boost" || name == "-bm" ||
                 name == "-imfchan" || name == "-texres" || name == "-type" || name == "-colorspace")
            words.next();
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
