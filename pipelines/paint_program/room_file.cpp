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

/// As far as a PLY file's header tells: a vertex with the color of a Gaussian, or chunks of packed ones.
bool is_splat_ply(const fs::path& file)
{
    std::string header(4096, '\0');
    std::ifstream stream(file, std::ios::binary);
    stream.read(header.data(), static_cast<std::streamsize>(header.size()));
    header.resize(static_cast<std::size_t>(stream.gcount()));
    header.resize(std::min(header.size(), header.find("end_header")));
    return header.find(" f_dc_0\n") != std::string::npos || header.find(" packed_position\n") != std::string::npos ||
           header.find(" f_dc_0\r") != std::string::npos;
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
    Writer(const Settings& settings, ScanKind kind) : settings_(settings), kind_(kind)
    {
        const bool copies = kind == ScanKind::recording && settings.weights.empty();
        large_ = copies && settings.size_px.value_or(0) > largest_painted_px;
        frames_ = kind == ScanKind::model ? "" : kind == ScanKind::splats ? "scan" : copies ? "align" : "frames";
    }

    std::string take()
    {
        check();
        add("version: 1\nbase: {}  # it comes with fresco; fresco plan shows all of its stages", base());
        add("vars:\n  {}: {}",
            kind_ == ScanKind::recording ? "data"
            : kind_ == ScanKind::model   ? "model"
                                         : "splat",
            quoted(settings_.scan.string()));
        if (!settings_.weights.empty())
            add("  weights: {}", quoted(settings_.weights.string()));
        if (settings_.pictures.size() == 1)
            add("  picture: {}", quoted(settings_.pictures.front().string()));
        else
            add("matrix:  # one painting for each; the scan is prepared once\n  picture:");
        for (const fs::path& picture : settings_.pictures)
            if (settings_.pictures.size() > 1)
                add("    - {}", quoted(picture.string()));
        add("stages:");
        add_painting();
        add_exports();
        if (kind_ != ScanKind::model)
            add("preview:\n  views: {{every_count: 8, height_px: 480}}");
        return text_;
    }

  private:
    template <class... Arguments>
    void add(fmt::format_string<Arguments...> format, Arguments&&... arguments)
    {
        text_ += fmt::format(format, std::forward<Arguments>(arguments)...) + "\n";
    }

    bool mixes() const { return settings_.strength || !settings_.keep.empty(); }
    bool wants(const char* name) const { return is_among(name, settings_.with); }
    /// The end of the inputs, and the option that says which way is up where no frames do.
    std::string inputs_end() const { return frames_.empty() ? "}, up: \"${up}\"" : ", frames: " + frames_ + "}"; }
    std::string base() const
    {
        return kind_ == ScanKind::model    ? "model.yaml"
               : kind_ == ScanKind::splats ? "splat.yaml"
               : frames_ == "frames"       ? "stylemesh.yaml"
               : large_                    ? "large.yaml"
                                           : "room.yaml";
    }

    void check() const
    {
        if (large_ && mixes())
            throw UsageError(
                fmt::format("--size {} copies the picture's own detail, which --strength and --keep would lose; at most {} "
                            "with them",
                            *settings_.size_px, largest_painted_px));
        if (!settings_.weights.empty() && mixes())
            throw UsageError(
                "--stylemesh with --strength or --keep: paint without them, then put texture.mix or texture.regions into "
                "room.yaml (pipelines/README.md)");
        if (kind_ == ScanKind::recording)
            return;
        if (!settings_.weights.empty())
            throw UsageError("--stylemesh paints through the pictures of a recording; a model or splats have none");
        for (const char* name : {"views", "video"})
            if (wants(name) && kind_ == ScanKind::model)
                throw UsageError(
                    fmt::format("--with {}: a model has no cameras to show it from; --with page shows it in a browser", name));
    }

    void add_painting()
    {
        const bool network = !settings_.weights.empty();
        if (settings_.stroke_cm)
            add("  {}: {{stroke_cm: {}}}  # width of the brush strokes on the surface", network ? "strokes" : "texture",
                number_text(*settings_.stroke_cm));
        else if (!network)
            add("  # Wider strokes: texture: {{stroke_cm: 6}}. All options: fresco describe texture.synthesize");
        if (settings_.size_px && !large_)
            add("  atlas: {{size_px: {}}}", *settings_.size_px);
        if (large_)
            add("  bake: {{size_px: {}}}", *settings_.size_px);
        const std::string share = number_text(settings_.strength.value_or(1));
        if (!settings_.keep.empty())
        {
            add("  regions: {{type: regions.planes, input: {{mesh: atlas{}}}", inputs_end());
            add("  mixed:\n    type: texture.regions\n    input: {{photo: photo, mesh: atlas, regions: regions, painted: "
                "texture}}");
            add("    regions: {{{}: keep, \"*\": {{texture: painted, strength: {}}}}}", fmt::join(settings_.keep, ": keep, "),
                share);
        }
        else if (settings_.strength)
            add("  mixed: {{type: texture.mix, input: {{photo: photo, painted: texture, mesh: atlas}}, color: {0}, strokes: "
                "{0}}}",
                share);
        if (mixes())
            add("  bake: {{input: {{texture: mixed}}}}");
    }

    void add_export(const char* name, const char* type, const std::string& options)
    {
        add("  {}: {{type: {}, input: {{textured_mesh: bake{}, {}}}", name, type, inputs_end(), options);
    }

    void add_exports()
    {
        // Written already: export.model keeps the model's own format.
        const std::string format_of_scan = lower_extension(settings_.scan);
        const bool keeps = kind_ == ScanKind::model && (format_of_scan == ".obj" || format_of_scan == ".ply");
        const std::string own = keeps ? format_of_scan : ".glb";
        if (wants("glb") && own != ".glb")
            add_export("gltf", "export.gltf", "path: room.glb");
        if (wants("usdz"))
            add_export("usdz", "export.usdz", "path: room.usdz, image_format: jpeg");
        for (const char* format : {"obj", "ply"})
            if (wants(format) && own.substr(1) != format)
                add_export(format, "export.mesh", fmt::format("path: room.{}", format));
        if (wants("page"))
            add_export("page", "export.page", "path: room.html");
        if (kind_ == ScanKind::model)
            return;
        const bool has_video = frames_ == "align";
        if (wants("video") && !has_video)
            add("  video: {{type: render.flythrough, input: {{mesh: bake, frames: {}}}}}", frames_);
        if (!wants("video") && has_video)
            add("  video: ~  # not wanted; --with video makes one");
        if (!wants("views"))
            add("  views: {{every_count: 8}}  # every 8th frame as a picture; all: --with views");
    }

    const Settings& settings_;
    ScanKind kind_;
    bool large_ = false;
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
        return ScanKind::recording;
    if (is_among(extension, {".splat", ".spz", ".sog", ".ksplat"}) || (extension == ".ply" && is_splat_ply(scan)))
        return ScanKind::splats;
    return is_among(extension, models) ? ScanKind::model : ScanKind::recording;
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
