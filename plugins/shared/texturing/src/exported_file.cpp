#include <fresco/texturing/exported_file.h>

#include <fresco/error.h>

#include <array>
#include <fmt/format.h>

namespace fresco::texturing
{

void check_textured_mesh(const TexturedMesh& textured, std::string_view source)
{
    check_mesh(textured.mesh, source);
    if (textured.mesh.texcoords.empty())
        throw Error(std::string(source) + " has no texcoords: wire what texture.bake made");
    const Raster8& picture = textured.image.pixels;
    if (picture.empty() || picture.width != picture.height || picture.channels != 3)
        throw Error(fmt::format(
            "{} has a picture of {} x {} texels and {} channels; expected a square RGB picture, as texture.bake makes it", source,
            picture.width, picture.height, picture.channels));
}

void check_written_mesh(const Mesh& found, const Mesh& meant)
{
    const auto expect = [](bool good, const std::string& what)
    {
        if (!good)
            throw Error("the written file differs from what was to be written: " + what);
    };
    expect(found.positions == meant.positions, "the positions differ");
    expect(found.colors == meant.colors, "the vertex colors differ");
    expect(found.texcoords.size() == (meant.texcoords.empty() ? 0 : 3 * found.triangles.size()),
           "the number of texcoords differs");
    std::size_t next = 0;
    for (std::size_t face = 0; face < meant.triangles.size(); ++face)
    {
        const Triangle& t = meant.triangles[face];
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
            continue;
        const std::string name = fmt::format("triangle {}", face);
        expect(next < found.triangles.size() && found.triangles[next] == t, name + " is missing or differs");
        for (std::size_t i = 0; i < 3 && !meant.texcoords.empty(); ++i)
            expect(found.texcoords[3 * next + i] == meant.texcoords[3 * face + i], name + " has a different texcoord");
        ++next;
    }
    expect(next == found.triangles.size(), "more triangles");
}

std::string grouped(std::uint64_t number)
{
    std::string text = std::to_string(number);
    for (std::size_t at = text.size(); at > 3;)
        text.insert(at -= 3, 1, ' ');
    return text;
}

std::string file_size(std::uint64_t bytes)
{
    constexpr std::array units{"kB", "MB", "GB", "TB"};
    if (bytes < 1000)
        return fmt::format("{} bytes", bytes);
    std::size_t unit = 0;
    // Tenths of the unit, rounded once.
    std::uint64_t divisor = 100;
    while (unit + 1 < units.size() && (bytes + divisor / 2) / divisor >= 10000)
    {
        divisor *= 1000;
        ++unit;
    }
    const std::uint64_t tenths = (bytes + divisor / 2) / divisor;
    return fmt::format("{}.{} {}", tenths / 10, tenths % 10, units[unit]);
}

std::string valid_line(std::string_view name, std::uint64_t bytes, std::string_view what)
{
    return std::string(name) + ": " + file_size(bytes) + (what.empty() ? "" : ", " + std::string(what)) + ", valid";
}

}  // namespace fresco::texturing
