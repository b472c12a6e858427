#pragma once

#include <fresco/error.h>
#include <fresco/value.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

/// \file What a user asks for, a scan, pictures and a few settings, as a pipeline file: a short room.yaml that extends a pipeline
/// that comes with fresco. So whatever is asked for with a few words can be read, edited and run again.

namespace fresco::paint
{

/// Settings that cannot be met.
struct UsageError : Error
{
    using Error::Error;
};

enum class ScanKind
{
    recording,
    model,
    splats
};

/// By the file's extension, of a PLY file by its header; folders and all other files are recordings.
ScanKind kind_of(const std::filesystem::path& scan);

struct Settings
{
    std::filesystem::path scan;
    std::vector<std::filesystem::path> pictures;  ///< At least one. Several: the axis `picture` of a matrix.
    /// {"texture.stroke_cm": 6}: options of the stages texture, atlas, relief, which is added for them, and strokes, which lays
    /// brush strokes over StyleMesh's texture; and "strength.color" and "strength.strokes" (0: photo, 1: painting), "unit_m" and
    /// "up" of a model or splats, "keep" (regions of regions.planes that stay as photographed), "walls" (another picture for
    /// walls and ceiling). Above 4096, "atlas.size_px" copies the picture's own detail.
    Value chosen{Value::Map{}};
    std::vector<std::string> with{};  ///< Names among exports().
    std::filesystem::path weights{};  ///< VGG-19 for StyleMesh; empty: copy brush strokes.
    bool for_page = false;            ///< With mesh.glb, photo.glb and view.glb for fresco studio, without views and video.
};

/// The names that Settings::with may have.
const std::vector<std::string>& exports();

/// Throws UsageError naming the first of Settings::chosen that cannot be chosen.
void check_chosen(const Value& chosen);

/// A pipeline file without its heading. Throws UsageError naming the setting where the kind of scan does not go with it.
std::string pipeline_text(const Settings& settings, ScanKind kind);

/// A file that extends "painting.yaml", a pipeline_text, by what `name` among exports() needs; and the stage with its files.
std::pair<std::string, std::string> export_text(const Settings& settings, ScanKind kind, const std::string& name);

/// A file that extends "painting.yaml" and paints quickly what mesh.in_view sees with these options.
std::string look_text(const Settings& settings, ScanKind kind, const Value& view);

/// A pipeline_text whose StyleMesh ends after this step, as if the step had been chosen: "texture.stop_at_step".
std::string stopped_at(std::string text, std::int64_t step);

/// The text with a heading that has its hash, so that editing shows. `command`: runs the file.
std::string with_heading(const std::string& text, const std::string& command);

enum class RoomState
{
    replaceable,  ///< No file is there, or nobody has edited it.
    edited,       ///< Was written with the same text, and edited since.
    other         ///< Was written with another text and edited since, or somebody else wrote it.
};
/// How the file stands to the text that is to be written there.
RoomState state_of(const std::filesystem::path& path, const std::string& text);

/// A word as a shell reads it back.
std::string shell_word(const std::string& word);

/// "6 .jpg files, 1 .txt file and the folder seq", and what can be done with them.
std::string contents_of(const std::filesystem::path& folder);

}  // namespace fresco::paint
