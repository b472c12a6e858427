#include "usda.h"

#include <fresco/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

using namespace fresco;
using fresco::texturing::WeldedMesh;

namespace
{
constexpr std::size_t piece_bytes = std::size_t{1} << 20U;
constexpr std::size_t row = 16;  // Values per line: readers need not hold endless ones.

struct Box
{
    Vec3f low;
    Vec3f high;
};

Box box_of(const std::vector<Vec3f>& positions)
{
    Box box{positions.at(0), positions.at(0)};
    for (const Vec3f p : positions)
    {
        box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
        box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
    }
    return box;
}

double to_millimeters(double meters)
{
    const double rounded = std::round(1000 * meters) / 1000;
    return rounded == 0 ? 0 : rounded;  // No -0.
}

class Writer
{
  public:
    explicit Writer(const WritePiece& write) : write_(write) {}
    ~Writer() = default;
    Writer(const Writer&) = delete;
    Writer& operator=(const Writer&) = delete;

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
    const WritePiece& write_;
    fmt::memory_buffer text_;
};

void add_mesh(Writer& writer, const WeldedMesh& mesh, const Box& box, bool lit)
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

void add_material(Writer& writer, const UsdaOptions& options)
{
    // UsdPreviewSurface knows no unlit look: black that emits the picture comes closest.
    const char* const color = options.lit ? "diffuse" : "emissive";
    const char* const black = options.lit ? "" : "            color3f inputs:diffuseColor = (0, 0, 0)\n";
    writer.add(R"(
    def Material "material"
    {{
        token outputs:surface.connect = </room/material/surface.outputs:surface>

        def Shader "surface"
        {{
            uniform token info:id = "UsdPreviewSurface"
{}            color3f inputs:{}Color.connect = </room/material/picture.outputs:rgb>
            float inputs:metallic = 0
            float inputs:roughness = 1
            token outputs:surface
        }}

        def Shader "picture"
        {{
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @{}@
            token inputs:sourceColorSpace = "sRGB"
            float2 inputs:st.connect = </room/material/st.outputs:result>
            token inputs:wrapS = "clamp"
            token inputs:wrapT = "clamp"
            float3 outputs:rgb
        }}

        def Shader "st"
        {{
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 outputs:result
        }}
    }}
)",
               black, color, options.picture);
}
}  // namespace

void write_usda(const WeldedMesh& mesh, const UsdaOptions& options, const WritePiece& write)
{
    const Box box = box_of(mesh.positions);
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
