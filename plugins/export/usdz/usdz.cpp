#include "usdz.h"

#include <fresco/numerics/numerics.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

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
