#include "room_file.h"

#include <fresco/files_io.h>
#include <fresco/value.h>
#include <fresco/wording.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fstream>
#include <map>

namespace fresco::paint
{
namespace
{

namespace fs = std::filesystem;

constexpr int largest_painted_px = 4096;  // From here on the picture's own detail is copied.
constexpr int usual_px = 2048;
constexpr int sheet_px = 768;  // Enough to choose a picture by.
constexpr std::string_view command_mark = "#   ";
constexpr std::string_view hash_mark = "# As written: ";

/// The line of a pipeline file that names the scan.
std::string_view scan_line(std::string_view text)
{
    constexpr std::string_view vars = "\nvars:\n";
    const std::size_t begin = text.find(vars);
    return begin == std::string_view::npos ? "" : text.substr(begin + vars.size(), text.find('\n', begin + vars.size()) - begin);
}

bool is_among(const std::string& word, const std::vector<std::string>& words)
{
    return std::ranges::find(words, word) != words.end();
}

/// As far as the beginning of a file tells: a PLY of Gaussians or of packed ones, a glTF with their extension, the JSON of a SOG.
bool has_splats(const fs::path& file)
{
    std::string header(1 << 20, '\0');
    std::ifstream stream(file, std::ios::binary);
    stream.read(header.data(), static_cast<std::streamsize>(header.size()));
    header.resize(static_cast<std::size_t>(stream.gcount()));
    header.resize(
        std::min(header.size(), header.find(header.starts_with("glTF") ? std::string("BIN\0", 4) : std::string("end_header"))));
    const auto has = [&](const char* word) { return header.find(word) != std::string::npos; };
    return has("\"KHR_gaussian_splatting\"") || has(" f_dc_0\n") || has(" f_dc_0\r") || has(" packed_position\n") ||
           (header.starts_with("{") && (has("\"means\"") || has("\"lodLevels\"")));
}

/// A text in YAML that stands for itself.
std::string quoted(std::string text)
{
    for (std::size_t at = text.find("${"); at != std::string::npos; at = text.find("${", at + 3))
        text.insert(at, "$");
    return to_json(Value(std::move(text)));
}

class Writer
{
  public:
    Writer(const Settings& settings, ScanKind kind) : settings_(settings), chosen_(settings.chosen), kind_(kind)
    {
        check_chosen(chosen_);
        const bool copies = kind == ScanKind::recording && settings.weights.empty();
        large_ = copies && size_px() > largest_painted_px;
        frames_ = kind == ScanKind::model ? "" : kind == ScanKind::splats ? "scan" : copies ? "align" : "frames";
        lit_ = kind != ScanKind::model && !options_of("relief").empty();
        check();
    }

    std::string take()
    {
        add("version: 1\nbase: {}  # it comes with fresco; fresco plan shows all of its stages", base());
        add("vars:\n  {}: {}",
            kind_ == ScanKind::recording ? "data"
            : kind_ == ScanKind::model   ? "model"
                                         : "splat",
            quoted(settings_.scan.string()));
        if (!settings_.weights.empty())
            add("  weights: {}", quoted(settings_.weights.string()));
        for (const char* name : {"unit_m", "up"})
            if (kind_ != ScanKind::recording && has(name))
                add("  {}: {}", name, to_json(chosen_.at(name)));
        if (settings_.pictures.size() == 1)
            add("  picture: {}", quoted(settings_.pictures.front().string()));
        else
            add("matrix:  # one painting for each; the scan is prepared once\n  picture:");
        for (const fs::path& picture : settings_.pictures)
            if (settings_.pictures.size() > 1)
                add("    - {}", quoted(picture.string()));
        add("stages:");
        add_painting();
        for (const std::string& name : settings_.with)
            if (name != own_export())
                add_export(name, name);
        add_views();
        return text_;
    }

    std::pair<std::string, std::string> take_export(const std::string& name)
    {
        check_export(name);
        const bool is_there = name == own_export();
        add("version: 1\nbase: painting.yaml{}", is_there ? "" : "\nstages:");
        if (!is_there)
            add_export("taken", name);
        return {text_, is_there ? "glb" : "taken"};
    }

    std::string take_look(const Value& view)
    {
        add("version: 1\nbase: painting.yaml\nstages:");
        add_look("texture", "sight", "\"${picture}\"", view);
        if (has("walls"))
            add_look("walls", "walls_sight", quoted(chosen_.at("walls").as_string()), view);
        if (mixes() || has_regions())
            add_sight("photo_sight", "", view);
        constexpr const char* photo = "photo: photo_sight.texture, mesh: sight.mesh";
        if (mixes())
            add("  mix: {{input: {{{}}}}}", photo);
        if (mixes() && has("walls"))
            add("  walls_mix: {{input: {{{}}}}}", photo);
        if (has_regions())
            add("  mixed: {{input: {{{}, regions: sight.regions}}}}", photo);
        add("  bake: {{input: {{mesh: sight.mesh}}}}\n  view: {{error_share: 0}}");
        return text_;
    }

  private:
    template <class... Arguments>
    void add(fmt::format_string<Arguments...> format, Arguments&&... arguments)
    {
        text_ += fmt::format(format, std::forward<Arguments>(arguments)...) + "\n";
    }

    bool has(const char* name) const { return chosen_.find(name) != nullptr; }
    double number(const char* name, double otherwise) const { return has(name) ? chosen_.at(name).as_double() : otherwise; }
    double color() const { return number("strength.color", 1); }
    double strokes() const { return number("strength.strokes", 1); }
    int size_px() const { return static_cast<int>(number("atlas.size_px", 0)); }
    bool mixes() const { return color() != 1 || strokes() != 1; }
    bool has_regions() const { return has("keep") || has("walls"); }
    bool wants(const char* name) const { return is_among(name, settings_.with); }
    /// Wires the frames, where there are some.
    std::string frames() const { return frames_.empty() ? "" : ", frames: " + frames_; }
    /// The end of the inputs, and the option that says which way is up where no frames do.
    std::string inputs_end() const { return frames() + (frames_.empty() ? "}, up: \"${up}\"" : "}"); }
    /// "stroke_cm: 6, …": what is chosen of a stage.
    std::string options_of(const std::string& stage) const
    {
        std::vector<std::string> options;
        for (const auto& [key, value] : chosen_.as_map())
            if (key.starts_with(stage + "."))
                options.push_back(key.substr(stage.size() + 1) + ": " +
                                  (value.is_string() ? quoted(value.as_string())
                                   : value.is_bool() ? to_json(value)
                                                     : number_text(value.as_double())));
        return fmt::format("{}", fmt::join(options, ", "));
    }
    std::string base() const
    {
        return kind_ == ScanKind::model    ? "model.yaml"
               : kind_ == ScanKind::splats ? "splat.yaml"
               : frames_ == "frames"       ? "stylemesh.yaml"
               : large_                    ? "large.yaml"
                                           : "room.yaml";
    }
    /// The format of the stage `glb`: export.model keeps the model's own format.
    std::string own_export() const
    {
        const std::string format = lower_extension(settings_.scan);
        return kind_ == ScanKind::model && (format == ".obj" || format == ".ply") ? format.substr(1) : "glb";
    }

    void check_export(const std::string& name) const
    {
        if (!is_among(name, exports()))
            throw UsageError(name + ": expected " + join(exports()));
        if (name == "video" && kind_ == ScanKind::model)
            throw UsageError("--with video: a model has no cameras that it could follow; --with page shows it in a browser");
    }

    void check() const
    {
        if (large_ && (mixes() || has_regions()))
            throw UsageError(
                fmt::format("--size {} copies the picture's own detail, which --strength and --keep would lose; at most {} "
                            "with them",
                            size_px(), largest_painted_px));
        for (const std::string& name : settings_.with)
            check_export(name);
        if (settings_.weights.empty())
            return;
        if (mixes() || has_regions())
            throw UsageError(
                "--stylemesh with --strength or --keep: paint without them, then put texture.mix or texture.regions into "
                "room.yaml (pipelines/README.md)");
        if (kind_ != ScanKind::recording)
            throw UsageError("--stylemesh paints through the pictures of a recording; a model or splats have none");
    }

    /// Fades a painted texture to the photo; the name of the stage with the result.
    std::string mixed(const char* painted, const char* name)
    {
        if (!mixes())
            return painted;
        add("  {}: {{type: texture.mix, input: {{photo: photo, painted: {}, mesh: atlas}}, color: {}, strokes: {}}}", name,
            painted, number_text(color()), number_text(strokes()));
        return name;
    }

    std::string add_regions(const std::string& painted)
    {
        const std::vector<std::string> kept =
            has("keep") ? JsonPlace(chosen_.at("keep"), "keep").texts() : std::vector<std::string>{};
        std::string inputs, rules;
        for (const std::string& region : kept)
            rules += region + ": keep, ";
        if (has("walls"))
        {
            const std::string options = options_of("texture");
            add("  walls: {{type: texture.synthesize, input: {{mesh: atlas, start: photo{}, style: {{file: {}}}}}{}{}{}}}",
                frames(), quoted(chosen_.at("walls").as_string()), frames_.empty() ? ", up: \"${up}\"" : "",
                options.empty() ? "" : ", ", options);
            inputs = ", walls: " + mixed("walls", "walls_mix");
            for (const char* region : {"walls", "ceiling"})
                if (!is_among(region, kept))
                    rules += fmt::format("{}: walls, ", region);
        }
        add("  regions: {{type: regions.planes, input: {{mesh: atlas{}}}", inputs_end());
        add("  mixed:\n    type: texture.regions\n    input: {{photo: photo, mesh: atlas, regions: regions, painted: {}{}}}\n"
            "    regions: {{{}\"*\": painted}}",
            painted, inputs, rules);
        return "mixed";
    }

    void add_painting()
    {
        const std::string options = options_of("texture"), strokes = options_of("strokes");
        if (!options.empty())
            add("  texture: {{{}}}", options);
        if (!strokes.empty())
            add("  strokes: {{{}}}", strokes);
        else if (options.empty() && settings_.weights.empty())
            add("  # Wider strokes: texture: {{stroke_cm: 6}}. All options: fresco describe texture.synthesize");
        if (large_)
            add("  bake: {{size_px: {}}}", size_px());
        else if (const std::string atlas = options_of("atlas"); !atlas.empty())
            add("  atlas: {{{}}}", atlas);
        std::string last = mixed("texture", "mix");
        if (has_regions())
            last = add_regions(last);
        if (last != "texture")
            add("  bake: {{input: {{texture: {}}}}}", last);
        if (lit_)
            add("  relief: {{type: texture.relief, input: bake, {}}}\n  glb: {{input: {{relief: relief}}}}",
                options_of("relief"));
    }

    /// A stage that exports what was baked.
    void add_export(const std::string& stage, const std::string& name)
    {
        const auto with = [&](const char* type, const std::string& options)
        {
            add("  {}: {{type: {}, input: {{textured_mesh: bake{}{}, {}}}", stage, type,
                lit_ && type != std::string_view("export.mesh") ? ", relief: relief" : "", inputs_end(), options);
        };
        if (name == "glb")
            with("export.gltf", "path: room.glb");
        else if (name == "usdz")
            with("export.usdz", "path: room.usdz, image_format: jpeg");
        else if (name == "obj" || name == "ply")
            with("export.mesh", fmt::format("path: room.{}", name));
        else if (name == "page")
            with("export.page", "path: room.html");
        else if (name == "video" && (stage == "taken" || frames_ != "align"))
            add("  {}: {{type: render.flythrough, input: {{mesh: bake, frames: {}}}}}", stage, frames_);
    }

    void add_views()
    {
        if (settings_.for_page && frames_ == "frames")
            add("  strokes: ~\n  strokes_bake: ~\n  strokes_glb: ~\n"
                "  photo: {{type: texture.from_frames, input: {{uvmaps: uvmaps, frames: frames}}}}");
        if (settings_.for_page)
            add("  # For the page: the mesh, with the photo, painted.\n"
                "  mesh_view: {{type: export.gltf, input: {{mesh: mesh{0}, path: mesh.glb}}\n"
                "  photo_bake: {{type: texture.bake, input: {{texture: photo, mesh: atlas}}}}\n"
                "  photo_view: {{type: export.gltf, input: {{textured_mesh: photo_bake{0}, path: photo.glb, image_format: "
                "jpeg, error_share: 0.0005}}\n"
                "  view: {{type: export.gltf, input: {{textured_mesh: bake{0}, path: view.glb, image_format: jpeg, error_share: "
                "0.0005}}",
                inputs_end());
        if (kind_ != ScanKind::model && frames_ == "align" && !wants("video"))
            add("  video: ~{}", settings_.for_page ? "" : "  # not wanted; --with video makes one");
        if (kind_ != ScanKind::model && settings_.for_page)
            add("  views: ~");
        else if (kind_ == ScanKind::model && (wants("views") || settings_.pictures.size() > 1))
            add("  views: {{type: render.views, input: {{mesh: bake}}, up: \"${{up}}\"}}  # from four sides");
        else if (kind_ != ScanKind::model && !wants("views"))
            add("  views: {{every_count: 8}}  # every 8th frame as a picture; all: --with views");
        std::string smaller;
        if (const bool has_sheet = settings_.pictures.size() > 1 && settings_.weights.empty(); has_sheet || settings_.for_page)
        {
            const int limit_px = settings_.for_page ? usual_px : sheet_px;
            smaller = fmt::format("\n  atlas: {{size_px: {}}}", size_px() > 0 ? std::min(size_px(), limit_px) : limit_px) +
                      (large_ ? fmt::format("\n  bake: {{size_px: {}}}", limit_px) : "");
        }
        if (!smaller.empty() || kind_ != ScanKind::model)
            add("preview:{}{}", smaller,
                settings_.for_page         ? ""
                : kind_ == ScanKind::model ? "\n  views: {height_px: 480}"
                                           : "\n  views: {every_count: 8, height_px: 480}");
    }

    void add_sight(const char* name, const std::string& style, const Value& view)
    {
        std::string options;
        for (const auto& [option, value] : view.as_map())
            if (!is_name(option))
                throw UsageError(option + ": not an option of mesh.in_view");
            else
                options += ", " + option + ": " + to_json(value);
        add("  {}: {{type: mesh.in_view, input: {{mesh: atlas, texture: photo{}{}}}{}}}", name, style,
            has_regions() ? ", regions: regions" : "", options);
    }

    /// Paints what is in view at two scales, with one round at the coarser one, nearly in the colors that the whole would get.
    void add_look(const char* stage, const char* sight, const std::string& picture, const Value& view)
    {
        const bool recolors = !has("texture.recolor") || chosen_.at("texture.recolor").as_bool();
        add_sight(sight, recolors ? fmt::format(", style: {{file: {}}}", picture) : "", view);
        add("  {0}: {{input: {{mesh: {1}.mesh, start: {1}.texture}}, recolor: false, levels_count: 2, rounds_count: 1{2}}}",
            stage, sight, has("texture.detail") ? "" : ", detail: 0");
    }

    const Settings& settings_;
    const Value& chosen_;
    ScanKind kind_;
    bool large_ = false;
    bool lit_ = false;
    std::string frames_;  ///< The stage whose frames exporters take; empty: none.
    std::string text_;
};

}  // namespace

ScanKind kind_of(const fs::path& scan)
{
    // scan.mesh reads these, the later ones by Blender.
    static const std::vector<std::string> models{".glb", ".gltf", ".obj", ".ply",  ".3ds",  ".abc",  ".blend", ".dae",
                                                 ".fbx", ".stl",  ".usd", ".usda", ".usdc", ".usdz", ".wrl",   ".x3d"};
    const std::string extension = lower_extension(scan);
    if (fs::is_directory(scan))
        return has_splats(scan / "meta.json") || has_splats(scan / "lod-meta.json") ? ScanKind::splats : ScanKind::recording;
    if (is_among(extension, {".splat", ".spz", ".sog", ".ksplat"}) ||
        (is_among(extension, {".ply", ".glb", ".gltf", ".json"}) && has_splats(scan)))
        return ScanKind::splats;
    return is_among(extension, models) ? ScanKind::model : ScanKind::recording;
}

void check_chosen(const Value& chosen)
{
    for (const auto& [key, value] : chosen.as_map())
    {
        const std::size_t dot = std::min(key.find('.'), key.size() - 1);
        const bool is_option = is_among(key.substr(0, dot), {"texture", "strokes", "atlas", "relief"}) &&
                               is_name(key.substr(dot + 1)) && (value.is_number() || value.is_bool() || value.is_string());
        const bool is_strength = (key == "strength.color" || key == "strength.strokes") && value.is_number();
        const bool is_keep = key == "keep" && value.is_list() && !value.as_list().empty() &&
                             std::ranges::all_of(value.as_list(), [](const Value& region)
                                                 { return region.is_string() && is_name(region.as_string()); });
        const bool is_of_file = (key == "unit_m" && value.is_number()) || (key == "up" && value.is_string());
        if (!is_option && !is_strength && !is_keep && !is_of_file && !(key == "walls" && value.is_string()))
            throw UsageError(key + ": not a setting of a painting");
    }
}

const std::vector<std::string>& exports()
{
    static const std::vector<std::string> names{"glb", "usdz", "obj", "ply", "page", "video", "views"};
    return names;
}

std::string pipeline_text(const Settings& settings, ScanKind kind)
{
    return Writer(settings, kind).take();
}

std::pair<std::string, std::string> export_text(const Settings& settings, ScanKind kind, const std::string& name)
{
    return Writer(settings, kind).take_export(name);
}

std::string look_text(const Settings& settings, ScanKind kind, const Value& view)
{
    return Writer(settings, kind).take_look(view);
}

std::string stopped_at(std::string text, std::int64_t step)
{
    constexpr std::string_view stages = "\nstages:\n";
    const std::string option = fmt::format("stop_at_step: {}", step);
    if (const std::size_t begin = text.find("\n  texture: {"); begin != std::string::npos)
        return text.insert(text.find('\n', begin + 1) - 1, ", " + option);
    return text.insert(text.find(stages) + stages.size(), "  texture: {" + option + "}\n");
}

std::string with_heading(const std::string& text, const std::string& command)
{
    return fmt::format("# Yours to edit: once changed, fresco paint uses this file and does not write it again.\n{}{}\n{}{}\n{}",
                       command_mark, command, hash_mark, content_hash(text), text);
}

RoomState state_of(const fs::path& path, const std::string& text)
{
    if (!fs::exists(path))
        return RoomState::replaceable;
    const std::string there = read_text_file(path);
    const std::size_t mark = there.find(hash_mark);
    if (mark == std::string::npos)
        return RoomState::other;
    const std::size_t begin = mark + hash_mark.size();
    const std::size_t end = there.find('\n', begin);
    const std::string hash = there.substr(begin, end - begin);
    const std::string body = end == std::string::npos ? "" : there.substr(end + 1);
    const std::size_t command = there.find(command_mark);
    const bool is_as_written =
        command < mark &&
        there == with_heading(body, there.substr(command + command_mark.size(), mark - command - command_mark.size() - 1));
    if (is_as_written && scan_line(body) == scan_line(text))
        return RoomState::replaceable;
    return hash == content_hash(text) ? RoomState::edited : RoomState::other;
}

std::string shell_word(const std::string& word)
{
    constexpr std::string_view plain = "@%+=:,./-_";
    const auto is_plain = [&](char c)
    { return (c >= '0' && c <= '9') || ((c | 0x20) >= 'a' && (c | 0x20) <= 'z') || plain.find(c) != std::string_view::npos; };
    if (!word.empty() && std::ranges::all_of(word, is_plain))
        return word;
    std::string text = "'";
    for (const char c : word)
        text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return text + "'";
}

std::string contents_of(const fs::path& folder)
{
    std::map<std::string, int> files;
    std::vector<std::string> parts;
    std::string model;
    std::error_code failure;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, failure))
        if (entry.is_directory(failure))
            parts.push_back(entry.path().filename().string() + "/");
        else if (++files[lower_extension(entry.path())]; kind_of(entry.path()) == ScanKind::model)
            model = std::max(model, entry.path().string());
    std::ranges::sort(parts);
    constexpr std::size_t most = 8;
    if (parts.size() > most)
        parts.resize(most, fmt::format("{} more folders", parts.size() - most));
    const bool has_folders = !parts.empty();
    for (const auto& [extension, count] : files)
        parts.push_back(fmt::format("{} {} {}", count, extension, count == 1 ? "file" : "files"));
    return folder.string() + " has " + (parts.empty() ? "nothing" : join(parts)) +
           (!model.empty() ? "\n  To paint a model, name its file: " + shell_word(model)
            : has_folders
                ? "\n  If the recording is one of its folders, name that."
                : "\n  Pictures do not say where they were taken from; COLMAP finds that out (sdk/docs/your-recording.md).");
}

}  // namespace fresco::paint
