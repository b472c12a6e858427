#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/geometry/upright.h>
#include <fresco/page/page.h>
#include <fresco/relief.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>

#include <page_parts.h>

#include <filesystem>
#include <string>
#include <string_view>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
std::string escaped(std::string_view text)
{
    std::string result;
    for (const char c : text)
        result += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
    return result;
}

/// One HTML file that shows a room and fetches nothing. `data`: {room, cameras, up} as showRoom of plugins/shared/page takes
/// them; cameras and up may be null. `title`: of the window.
std::string room_page(const Value& data, std::string_view title)
{
    const PageScripts& viewer = page::room_scripts();
    const std::string name = escaped(title);
    const std::string json = script_json(data);
    std::string page;
    for (const std::string_view part : std::initializer_list<std::string_view>{
             "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
             "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1, viewport-fit=cover\">\n"
             "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
             "style-src 'unsafe-inline'; img-src data: blob:\">\n<link rel=\"icon\" href=\"data:,\">\n<title>",
             name, "</title>\n<style>", viewer.css, page_css,
             "</style></head>\n<body>\n<div id=\"room\"><noscript><p class=\"message\">This page shows a room by JavaScript, "
             "which is switched off here.</p></noscript>"
             "<script>document.write('<p class=\"message\" id=\"loading\">Loading the room…</p>')</script></div>\n"
             "<nav><button id=\"walk\">Walk</button><button id=\"orbit\">Orbit</button><button id=\"light\" "
             "hidden>Light</button><button id=\"vr\" hidden>Enter VR</button></nav>\n"
             "<script type=\"application/json\" id=\"data\">",
             json, "</script>\n<script>", viewer.library, "</script>\n<script>\"use strict\";\n", viewer.js, page_js,
             "</script>\n</body></html>\n"})
        page += part;
    return page;
}

class ExportPage final : public Stage
{
    Input<TexturedMesh> textured_mesh{this, "textured_mesh", "The mesh with its picture, as texture.bake makes it"};
    Input<Relief> relief{this, "relief", optional, "Normals and roughness of the paint (texture.relief), for a light to move"};
    Output<Files> files{this, "files", "One .html file"};
    Option<OutputName> path{this, "path", OutputName{"room.html"}, extensions({".html"}), "Output path below --out"};
    PictureEncoding picture{this, 2048};
    geometry::UprightOption up{this};

    /// The world's upward direction, as a page takes it.
    Value upwards(RunContext& run) const
    {
        const auto [x, y, z, w] = up.turn(textured_mesh->mesh, {0, 0, 1}, run);
        const Vec3d direction = geometry::turned({-x, -y, -z, w}, {0, 0, 1});
        return Value::List{direction.x, direction.y, direction.z};
    }

    Value relief_entry(RunContext& run) const
    {
        if (!relief.has_value())
            return {};
        const auto maps = picture.encoded(*relief, textured_mesh->mesh, NormalFrame::world, ".jpg", run);
        return page::relief(relief->atlas, maps.normals, maps.roughness);
    }

    void run(RunContext& run) override
    {
        check_textured_mesh(*textured_mesh, "the mesh on port 'textured_mesh'");
        const PictureEncoding::Encoded image = picture.encoded(*textured_mesh, ".jpg", run);
        const bool has_cameras = up.frames().has_value() && !up.frames()->frames.empty();
        const Value data = Value::Map{{"room", page::room(textured_mesh->mesh, image.bytes)},
                                      {"relief", relief_entry(run)},
                                      {"cameras", has_cameras ? page::cameras(*up.frames()) : Value()},
                                      {"up", upwards(run)}};
        run.check_canceled();
        const auto file = files.folder().path / path->path;
        std::filesystem::create_directories(file.parent_path());
        write_file(file, room_page(data, std::filesystem::path(path->path).stem().string()));

        const std::size_t triangles = textured_mesh->mesh.triangles.size();
        const int texture_px = image.picture(*textured_mesh).width;
        tell_export(run, path->path, std::filesystem::file_size(file), triangles, texture_px, image.bytes.size());
        if (triangles > 1'000'000 || texture_px > 4096)
            run.warning(path->path +
                        ": more than 1,000,000 triangles or 4096 texels a side, perhaps too much for a stand-alone VR "
                        "headset: lower max_faces of "
                        "mesh.decimate or max_texture_px");
        Files result;
        result.names = {path->path};
        files = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("export.page", ExportPage, "Writes a textured mesh as one HTML file to walk through, which fetches nothing")
