#include "usdz.h"

#include <fresco/error.h>
#include <fresco/numerics/numerics.h>

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <system_error>

using namespace fresco;
using fresco::texturing::WeldedMesh;

namespace
{

constexpr std::size_t piece_bytes = std::size_t{1} << 20U;
constexpr std::size_t row = 16;  // Values per line: readers need not hold endless ones.

double to_millimeters(double meters)
{
    const double rounded = std::round(1000 * meters) / 1000;
    return rounded == 0 ? 0 : rounded;  // No -0.
}

class Writer
{
  public:
    explicit Writer(const WriteText& write) : write_(write) {}

    template <class... Values>
    void add(fmt::format_string<Values...> text, Values&&... values)
    {
        fmt::format_to(std::back_inserter(text_), text, std::forward<Values>(values)...);
        if (text_.size() >= piece_bytes)
            flush();
    }
    void flush()
    {
        write_({text_.data(), text_.size()});
        text_.clear();
    }
    /// "        DECLARATION = [a, b, …]"
    template <class Add>
    void list(std::string_view declaration, std::size_t count, const Add& add_value, std::string_view after = "")
    {
        add("        {} = [", declaration);
        for (std::size_t i = 0; i < count; ++i)
        {
            add("{}", i == 0 ? "" : i % row == 0 ? ",\n" : ", ");
            add_value(i);
        }
        add("]{}\n", after);
    }

  private:
    const WriteText& write_;
    fmt::memory_buffer text_;
};

void add_mesh(Writer& writer, const WeldedMesh& mesh, const numerics::Bounds<float>& box, bool lit)
{
    constexpr std::string_view per_vertex = " (\n            interpolation = \"vertex\"\n        )";
    const auto triple = [&](Vec3f v) { writer.add("({}, {}, {})", v.x, v.y, v.z); };
    writer.add("    def Mesh \"surface\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {{\n"
               "        uniform bool doubleSided = 1\n");
    const std::array<Vec3f, 2> extent{box.low, box.high};
    writer.list("float3[] extent", 2, [&](std::size_t i) { triple(extent[i]); });
    writer.list("int[] faceVertexCounts", mesh.indices.size() / 3, [&](std::size_t) { writer.add("3"); });
    writer.list("int[] faceVertexIndices", mesh.indices.size(), [&](std::size_t i) { writer.add("{}", mesh.indices[i]); });
    writer.add("        rel material:binding = </room/material>\n");
    if (lit)
        writer.list(
            "normal3f[] normals", mesh.normals.size(), [&](std::size_t i) { triple(mesh.normals[i]); }, per_vertex);
    writer.list("point3f[] points", mesh.positions.size(), [&](std::size_t i) { triple(mesh.positions[i]); });
    writer.list(
        "texCoord2f[] primvars:st", mesh.texcoords.size(),
        [&](std::size_t i) { writer.add("({}, {})", mesh.texcoords[i].x, mesh.texcoords[i].y); }, per_vertex);
    writer.add("        uniform token subdivisionScheme = \"none\"\n    }}\n");
}

/// A shader that looks a picture up; `more` are further inputs.
void add_picture(Writer& writer, std::string_view shader, std::string_view file, std::string_view color_space,
                 std::string_view output, std::string_view more = "")
{
    writer.add(R"(
        def Shader "{}"
        {{
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @{}@
{}            token inputs:sourceColorSpace = "{}"
            float2 inputs:st.connect = </room/material/st.outputs:result>
            token inputs:wrapS = "clamp"
            token inputs:wrapT = "clamp"
            {}
        }}
)",
               shader, file, more, color_space, output);
}

void add_material(Writer& writer, const UsdaOptions& options)
{
    // UsdPreviewSurface knows no unlit look: black that emits the picture comes closest.
    const char* const color = options.lit ? "diffuse" : "emissive";
    const char* const black = options.lit ? "" : "            color3f inputs:diffuseColor = (0, 0, 0)\n";
    const bool has_relief = !options.normals.empty();
    writer.add(R"(
    def Material "material"
    {{
        token outputs:surface.connect = </room/material/surface.outputs:surface>

        def Shader "surface"
        {{
            uniform token info:id = "UsdPreviewSurface"
{}            color3f inputs:{}Color.connect = </room/material/picture.outputs:rgb>
            float inputs:metallic = 0
            {}
            token outputs:surface
        }}
)",
               black, color,
               has_relief ? "normal3f inputs:normal.connect = </room/material/normals.outputs:rgb>\n"
                            "            float inputs:roughness.connect = </room/material/roughness.outputs:r>"
                          : "float inputs:roughness = 1");
    add_picture(writer, "picture", options.picture, "sRGB", "float3 outputs:rgb");
    if (has_relief)
    {
        // Steps to components from -1 to 1.
        add_picture(writer, "normals", options.normals, "raw", "float3 outputs:rgb",
                    "            float4 inputs:scale = (2, 2, 2, 1)\n            float4 inputs:bias = (-1, -1, -1, 0)\n");
        add_picture(writer, "roughness", options.roughness, "raw", "float outputs:r");
    }
    writer.add(R"(
        def Shader "st"
        {{
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 outputs:result
        }}
    }}
)");
}

}  // namespace

void write_usda(const WeldedMesh& mesh, const UsdaOptions& options, const WriteText& write)
{
    numerics::Bounds<float> box;
    for (const Vec3f p : mesh.positions)
        box.add(p);
    Writer writer(write);
    writer.add("#usda 1.0\n(\n    defaultPrim = \"room\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n"
               "def Xform \"room\" (\n    kind = \"component\"\n)\n{{\n"
               "    double3 xformOp:translate = ({}, {}, {})\n"
               "    uniform token[] xformOpOrder = [\"xformOp:translate\"]\n\n",
               to_millimeters(-(double{box.low.x} + double{box.high.x}) / 2), to_millimeters(-double{box.low.y}),
               to_millimeters(-(double{box.low.z} + double{box.high.z}) / 2));
    add_mesh(writer, mesh, box, options.lit);
    add_material(writer, options);
    writer.add("}}\n");
    writer.flush();
}

namespace
{

/// The data of each file in a package begin at multiples of this, in bytes.
constexpr std::uint64_t zip_alignment = 64;

constexpr std::size_t local_header_bytes = 30;
constexpr std::size_t crc_at = 14;
constexpr std::uint16_t padding_id = 0x1986;  ///< Of the extra field that pads; the one that USD itself writes.
constexpr std::uint32_t first_of_1980 = 0x00210000;

std::string little(std::uint64_t number, int bytes)
{
    std::string text;
    for (int i = 0; i < bytes; ++i)
        text += static_cast<char>(number >> (8 * i) & 255U);
    return text;
}

/// Fills up to the next multiple of 64 from `offset`, and says so itself: 4 bytes and zeros.
std::string padding(std::uint64_t offset)
{
    constexpr std::uint64_t least = 4;
    const std::uint64_t bytes = least + (zip_alignment - (offset + least) % zip_alignment) % zip_alignment;
    return little(padding_id, 2) + little(bytes - least, 2) + std::string(bytes - least, '\0');
}

/// What local headers and the directory have in common, from the version needed to the length of the name.
std::string common(std::uint32_t crc, std::uint64_t bytes, std::size_t name_bytes)
{
    constexpr int version_needed = 10;
    return little(version_needed, 2) + little(0, 2) + little(0, 2) + little(first_of_1980, 4) + little(crc, 4) +
           little(bytes, 4) + little(bytes, 4) + little(name_bytes, 2);
}

}  // namespace

ZipWriter::ZipWriter(std::filesystem::path file) : file_(std::move(file)), stream_(file_, std::ios::binary | std::ios::trunc)
{
    check_written();
}

void ZipWriter::check_written() const
{
    if (!stream_)
        throw Error(file_.string() + ": cannot be written: " + std::generic_category().message(errno));
}

void ZipWriter::put(std::string_view bytes)
{
    stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    check_written();
    offset_ += bytes.size();
    constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max() - 65536;  // Leaves room for the directory.
    if (offset_ > most)
        throw Error(file_.string() + ": exceeds the 4 GiB of a usdz file: decimate the mesh or set max_texture_px");
}

void ZipWriter::begin(std::string name)
{
    end_entry();
    Entry& entry = entries_.emplace_back();
    entry.name = std::move(name);
    entry.header = offset_;
    const std::string extra = padding(offset_ + local_header_bytes + entry.name.size());
    put("PK\3\4" + common(0, 0, entry.name.size()) + little(extra.size(), 2) + entry.name + extra);
    entry.data = offset_;
}

void ZipWriter::write(std::string_view bytes)
{
    put(bytes);
    Entry& entry = entries_.back();
    entry.crc = static_cast<std::uint32_t>(crc32_z(entry.crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// What was unknown when its header was written.
void ZipWriter::end_entry()
{
    if (entries_.empty())
        return;
    Entry& entry = entries_.back();
    entry.bytes = offset_ - entry.data;
    const std::uint64_t end = offset_;
    stream_.seekp(static_cast<std::streamoff>(entry.header + crc_at));
    put(little(entry.crc, 4) + little(entry.bytes, 4) + little(entry.bytes, 4));
    stream_.seekp(static_cast<std::streamoff>(end));
    offset_ = end;
}

void ZipWriter::finish()
{
    end_entry();
    const std::uint64_t directory = offset_;
    for (const Entry& entry : entries_)
        put("PK\1\2" + little(10, 2) + common(entry.crc, entry.bytes, entry.name.size()) + std::string(12, '\0') +
            little(entry.header, 4) + entry.name);
    const std::uint64_t bytes = offset_ - directory;
    put("PK\5\6" + std::string(4, '\0') + little(entries_.size(), 2) + little(entries_.size(), 2) + little(bytes, 4) +
        little(directory, 4) + little(0, 2));
    stream_.close();
    check_written();
}

namespace
{

constexpr std::size_t central_bytes = 46;
constexpr std::size_t end_bytes = 22;

void expect(bool good, const std::string& what)
{
    if (!good)
        throw Error(what);
}

std::uint64_t number(std::string_view bytes, std::size_t at, std::size_t width)
{
    expect(at + width <= bytes.size(), fmt::format("ends before byte {}", at + width));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < width; ++i)
        value |= std::uint64_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
    return value;
}

/// The file that the directory's entry at byte `central` is of. `next`: where it must begin, then where it ends.
UsdzEntry entry_at(std::string_view package, std::size_t central, std::size_t& next)
{
    const std::size_t name_bytes = number(package, central + 28, 2);
    const std::size_t local = number(package, central + 42, 4);
    expect(local == next && number(package, local, 4) == 0x04034b50, fmt::format("byte {}: expected a file", next));
    expect(central + central_bytes + name_bytes <= package.size(), "a name exceeds the archive");
    UsdzEntry result;
    result.name = package.substr(central + central_bytes, name_bytes);
    const std::string place = result.name + ": ";
    // Version, flags, method, time, checksum and sizes.
    expect(package.substr(central + 6, 22) == package.substr(local + 4, 22) && number(package, local + 26, 2) == name_bytes &&
               package.substr(local + local_header_bytes, name_bytes) == result.name,
           place + "its header and the directory do not agree");
    expect(number(package, local + 6, 2) == 0 && number(package, local + 8, 2) == 0,
           place + "expected stored bytes, not compressed ones");
    const std::size_t data = local + local_header_bytes + name_bytes + number(package, local + 28, 2);
    const std::size_t bytes = number(package, local + 18, 4);
    expect(data % zip_alignment == 0, place + fmt::format("begins at byte {}, not at a multiple of {}", data, zip_alignment));
    expect(bytes == number(package, local + 22, 4) && data + bytes <= package.size(), place + "exceeds the archive");
    result.data = package.substr(data, bytes);
    expect(crc32_z(0, reinterpret_cast<const Bytef*>(result.data.data()), bytes) == number(package, local + 14, 4),
           place + "the checksum differs");
    next = data + bytes;
    return result;
}

std::vector<UsdzEntry> entries_of(std::string_view package)
{
    expect(package.size() >= end_bytes, "too short for a zip archive");
    const std::size_t end = package.size() - end_bytes;
    expect(package.substr(end, 4) == "PK\5\6", fmt::format("byte {}: expected the end of the directory", end));
    const std::uint64_t count = number(package, end + 10, 2);
    const std::size_t directory = number(package, end + 16, 4);
    expect(number(package, end + 8, 2) == count && directory + number(package, end + 12, 4) == end,
           "the directory does not end where the archive says");
    std::vector<UsdzEntry> entries;
    std::size_t next = 0;
    std::size_t central = directory;
    for (std::uint64_t i = 0; i < count; ++i)
    {
        expect(number(package, central, 4) == 0x02014b50, fmt::format("byte {}: expected an entry of the directory", central));
        entries.push_back(entry_at(package, central, next));
        central +=
            central_bytes + entries.back().name.size() + number(package, central + 30, 2) + number(package, central + 32, 2);
    }
    expect(central == end && next == directory, "bytes that belong to no file");
    return entries;
}

/// The numbers of a list, whatever brackets are around them.
class Numbers
{
  public:
    Numbers(std::string_view layer, std::string_view declaration)
    {
        const std::string begin = "        " + std::string(declaration) + " = [";
        const std::size_t at = layer.find(begin);
        expect(at != std::string_view::npos, std::string(declaration) + " is missing");
        rest_ = layer.substr(at + begin.size());
        rest_ = rest_.substr(0, rest_.find(']'));
    }

    template <class Number>
    bool is_next(Number meant)
    {
        skip();
        Number found{};
        const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), found);
        if (error != std::errc() || std::memcmp(&found, &meant, sizeof found) != 0)
            return false;
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        return true;
    }
    bool is_at_end()
    {
        skip();
        return rest_.empty();
    }

  private:
    void skip() { rest_.remove_prefix(std::min(rest_.find_first_not_of("(), \n"), rest_.size())); }

    std::string_view rest_;
};

template <class Row>
void check_rows(std::string_view layer, std::string_view declaration, const std::vector<Row>& rows, const auto& is_next)
{
    Numbers numbers(layer, declaration);
    for (std::size_t i = 0; i < rows.size(); ++i)
        expect(is_next(numbers, rows[i]),
               fmt::format("the written file differs from what was to be written: {}, {}", declaration, i));
    expect(numbers.is_at_end(), fmt::format("{}: more than the {} that were to be written", declaration, rows.size()));
}

}  // namespace

std::vector<UsdzEntry> read_usdz(std::string_view package, std::string_view source)
{
    try
    {
        return entries_of(package);
    }
    catch (const Error& error)
    {
        throw Error(std::string(source) + ": " + error.what());
    }
}

void check_usda(std::string_view layer, const WeldedMesh& mesh)
{
    check_rows(layer, "int[] faceVertexIndices", mesh.indices,
               [](Numbers& numbers, std::uint32_t index) { return numbers.is_next(index); });
    check_rows(layer, "int[] faceVertexCounts", std::vector<std::uint32_t>(mesh.indices.size() / 3, 3),
               [](Numbers& numbers, std::uint32_t count) { return numbers.is_next(count); });
    check_rows(layer, "point3f[] points", mesh.positions,
               [](Numbers& numbers, Vec3f p) { return numbers.is_next(p.x) && numbers.is_next(p.y) && numbers.is_next(p.z); });
    check_rows(layer, "texCoord2f[] primvars:st", mesh.texcoords,
               [](Numbers& numbers, Vec2f uv) { return numbers.is_next(uv.x) && numbers.is_next(uv.y); });
}
