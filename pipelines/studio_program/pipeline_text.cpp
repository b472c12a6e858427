#include "pipeline_text.h"

#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>
#include <fmt/format.h>

namespace fresco::studio
{
namespace
{
/// Stages whose options a painting may set.
const std::vector<std::string> set_stages{"texture", "atlas", "relief"};

/// A flow scalar of YAML: JSON's are.
std::string yaml(const Value& value)
{
    std::string text = to_json(value);
    if (text.find("${") != std::string::npos)
        throw Error(text + ": a pipeline file would take '${' for a variable; rename it");
    return text;
}

double number(const Value& settings, std::string_view key, double otherwise)
{
    const Value* value = settings.find(key);
    return value == nullptr ? otherwise : value->as_double();
}

/// ", stroke_cm: 6, …": what is set of a stage.
std::string options_of(const Value& settings, const std::string& stage)
{
    std::string text;
    for (const auto& [key, value] : settings.as_map())
        if (key.starts_with(stage + "."))
            text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", key.substr(stage.size() + 1), yaml(value));
    return text;
}

/// Adds what comes between the texture and `bake`; gives the name of the stage that `bake` reads.
std::string add_mixing(const PaintingRequest& request, std::string& stages)
{
    const Value& settings = request.settings;
    std::string last = "texture";
    const double color = number(settings, "strength.color", 1);
    const double strokes = number(settings, "strength.strokes", 1);
    if (color < 1 || strokes < 1)
    {
        stages += fmt::format(
            "  mix: {{type: texture.mix, input: {{photo: photo, painted: {}, mesh: atlas}}, color: {}, strokes: {}}}\n", last,
            number_text(color), number_text(strokes));
        last = "mix";
    }
    const Value* keep = settings.find("keep");
    const Value* walls = settings.find("walls");
    if ((keep == nullptr || keep->as_list().empty()) && walls == nullptr)
        return last;
    const std::string frames = request.is_model ? "" : ", frames: align";
    stages += fmt::format("  regions: {{type: regions.planes, input: {{mesh: atlas{}}}{}}}\n", frames,
                          request.is_model ? ", up: y" : "");
    std::string rules;
    if (keep != nullptr)
        for (const Value& region : keep->as_list())
            rules += fmt::format("{}: keep, ", yaml(region));
    std::string inputs;
    if (walls != nullptr)
    {
        const std::string options = options_of(settings, "texture");
        stages += fmt::format(
            "  walls: {{type: texture.synthesize, input: {{mesh: atlas, start: photo{}, style: {{file: {}}}}}{}{}}}\n", frames,
            yaml(*walls), options.empty() ? "" : ", ", options);
        inputs = ", walls: walls";
        for (const char* region : {"walls", "ceiling"})
            if (rules.find(fmt::format("\"{}\": keep", region)) == std::string::npos)
                rules += fmt::format("{}: walls, ", region);
    }
    stages +=
        fmt::format("  mixed: {{type: texture.regions, input: {{photo: photo, mesh: atlas, regions: regions, painted: {}{}}}, "
                    "regions: {{{}\"*\": painted}}}}\n",
                    last, inputs, rules);
    return "mixed";
}
}  // namespace

void check_settings(const Value& settings)
{
    for (const auto& [key, value] : settings.as_map())
    {
        const std::size_t dot = key.find('.');
        const bool option = dot != std::string::npos && std::ranges::find(set_stages, key.substr(0, dot)) != set_stages.end() &&
                            is_name(key.substr(dot + 1));
        const bool scalar = value.is_number() || value.is_bool() || value.is_string();
        const bool strength = (key == "strength.color" || key == "strength.strokes") && value.is_number();
        if (!(option && scalar) && !strength && !(key == "keep" && value.is_list()) && !(key == "walls" && value.is_string()))
            throw Error(key + ": not a setting of a painting");
        if (key == "keep")
            for (const Value& region : value.as_list())
                if (!is_name(region.as_string()))
                    throw Error("keep: not the name of a region: " + region.as_string());
    }
}

std::string pipeline_text(const PaintingRequest& request)
{
    const Value& settings = request.settings;
    check_settings(settings);
    std::string stages;
    for (const char* stage : {"atlas", "texture"})
        if (const std::string options = options_of(settings, stage); !options.empty())
            stages += fmt::format("  {}: {{{}}}\n", stage, options);
    const std::string last = add_mixing(request, stages);
    if (last != "texture")
        stages += fmt::format("  bake: {{input: {{texture: {}}}}}\n", last);
    if (const std::string options = options_of(settings, "relief"); !options.empty() && !request.is_model)
        stages += fmt::format("  relief: {{type: texture.relief, input: bake, {}}}\n"
                              "  glb: {{input: {{relief: relief}}}}\n",
                              options);
    const std::string frames = request.is_model ? "" : ", frames: align";
    const std::string up = request.is_model ? ", up: y" : "";
    return fmt::format(
        "# Made by fresco studio. Paint it again: fresco run FILE. What the stages do: fresco describe TYPE.\n"
        "version: 1\n"
        "base: {}\n"
        "vars:\n"
        "  {}: {}\n"
        "  picture: {}\n"
        "stages:\n"
        "{}"
        "  # For the page: the mesh, with the photo, painted.\n"
        "  mesh_view: {{type: export.gltf, input: {{mesh: mesh{}}}, path: mesh.glb{}}}\n"
        "  photo_bake: {{type: texture.bake, input: {{texture: photo, mesh: atlas}}}}\n"
        "  photo_view: {{type: export.gltf, input: {{textured_mesh: photo_bake{}}}, path: photo.glb, image_format: jpeg{}}}\n"
        "  view: {{type: export.gltf, input: {{textured_mesh: bake{}}}, path: view.glb, image_format: jpeg{}}}\n",
        request.is_model ? "model.yaml" : "room.yaml", request.is_model ? "model" : "data", yaml(request.scan.string()),
        yaml(request.picture.string()), stages, frames, up, frames, up, frames, up);
}

std::vector<std::string> run_arguments(const PaintingRequest& request, Care care)
{
    std::vector<std::string> words;
    if (!request.is_model)
        words = {"--without", "views", "--without", "video"};
    const auto add = [&](std::initializer_list<const char*> more) { words.insert(words.end(), more.begin(), more.end()); };
    if (care != Care::full)
        add({"--preview", "--without", "glb"});
    if (care != Care::full && request.settings.find("relief.height_mm") != nullptr && !request.is_model)
        add({"--without", "relief"});
    if (care == Care::quick)
        add({"--set", "texture.levels_count=1", "--set", "texture.rounds_count=1", "--set", "atlas.size_px=512"});
    return words;
}

std::string export_text(const PaintingRequest& request, const std::string& kind)
{
    const std::string with_frames = request.is_model ? ", up: y" : "";
    const std::string input = request.is_model ? "{textured_mesh: bake}" : "{textured_mesh: bake, frames: align}";
    const bool relief = !request.is_model && request.settings.find("relief.height_mm") != nullptr;
    const std::string lit = relief ? "{textured_mesh: bake, frames: align, relief: relief}" : input;
    std::string stage;
    if (kind == "glb")
        stage = fmt::format("{{type: export.gltf, input: {}, path: room.glb{}}}", lit, with_frames);
    else if (kind == "usdz")
        stage = fmt::format("{{type: export.usdz, input: {}, path: room.usdz{}}}", lit, with_frames);
    else if (kind == "page")
        stage = fmt::format("{{type: export.page, input: {}, path: room.html{}}}", lit, with_frames);
    else if (kind == "obj")
        stage = fmt::format("{{type: export.mesh, input: {}, path: obj/room.obj{}}}", input, with_frames);
    else if (kind == "ply")
        stage = fmt::format("{{type: export.mesh, input: {}, path: room.ply, colors: true{}}}", input, with_frames);
    else if (kind == "video" && !request.is_model)
        stage = "{type: render.flythrough, input: {mesh: bake, frames: align}, name: video}";
    else if (kind == "video")
        throw Error("a video follows the cameras of a recording; a model has none");
    else
        throw Error(kind + ": expected glb, usdz, obj, ply, page or video");
    return "version: 1\nbase: painting.yaml\nstages:\n  taken: " + stage + "\n";
}

}  // namespace fresco::studio
