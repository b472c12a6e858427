#pragma once

#include <fresco/value.h>

#include <filesystem>
#include <string>
#include <vector>

/// \file The pipeline file of a painting: what the studio runs, and what a user can run without it.

namespace fresco::studio
{

struct PaintingRequest
{
    std::filesystem::path scan;
    bool is_model = false;
    std::filesystem::path picture;
    /// {"texture.stroke_cm": 6}: options of stages, and "strength.color", "strength.strokes", "keep" (a list of regions), "walls"
    /// (a picture for walls and ceiling). An option of `relief` adds that stage.
    Value settings{Value::Map{}};
};

/// Options that `settings` may set, as "stage.option". Throws Error naming the first that is another.
void check_settings(const Value& settings);

/// The text of a pipeline file with a `base:` of the installed ones. Its results beside the base's: mesh.glb, photo.glb and
/// view.glb, which the page shows.
std::string pipeline_text(const PaintingRequest& request);

/// How well a painting is made. `quick`: a first look, with fewer texels and rounds than a preview has.
enum class Care
{
    quick,
    preview,
    full
};
/// Arguments after `fresco run FILE`.
std::vector<std::string> run_arguments(const PaintingRequest& request, Care care);

/// The text of a pipeline file that adds the stage `taken`, an export of `kind` (glb, usdz, obj, ply, page, video), to the file
/// "painting.yaml" beside it. Throws Error for another kind, and for a video of a model.
std::string export_text(const PaintingRequest& request, const std::string& kind);

}  // namespace fresco::studio
