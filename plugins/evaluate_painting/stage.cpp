#include "figure_table.h"
#include "repeats.h"
#include "stroke_size.h"
#include "texture_figures.h"
#include "view_figures.h"

#include <fresco/evaluation/posed_pictures.h>
#include <fresco/evaluation/statistics.h>
#include <fresco/image_io.h>
#include <fresco/parallel.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

using namespace fresco;

namespace
{
/// A picture to judge.
struct View
{
    std::string name;
    std::filesystem::path file;
    const Frame* frame = nullptr;  ///< The frame that it is seen from; null where port 'frames' is not wired.
};

constexpr Wanted seams_wanted{.high = 1.25};
constexpr Wanted picture_used_wanted{.low = 0.4};
constexpr Wanted largest_share_wanted{.high = 0.05};
constexpr Wanted repeats_wanted{.high = 0.4};
constexpr Wanted weave_wanted{.high = 0.05};
constexpr double stroke_tolerance = 0.15;
constexpr double most_size_by_distance = 0.1;
constexpr double least_independent_places = 100;

class EvaluatePainting final : public Stage
{
    Input<Files> views{this, "views", optional, "Pictures to judge, as render.views makes them: RGBA, <sequence>_<frame>.png"};
    Input<Frames> frames{
        this, "frames", optional,
        "The frames whose color cameras took the pictures; their own pictures are the reference of 'edges' and 'legible'"};
    Input<Image> style{this, "style", optional, "The style picture of the room"};
    Input<TexturedMesh> textured_mesh{this, "textured_mesh", optional, "The painted mesh, for its seams"};
    Input<Texture> start{this, "start", optional, "The texture that the painting started from, in the same atlas, of any size"};
    Input<SourceMap> source{this, "source", optional, "Where in the picture each texel comes from"};
    Input<UvMaps> uvmaps{this, "uvmaps", optional, "Uv maps of the frames, for the distance that the surface was captured from"};
    Output<Files> figures{this, "figures", "All figures, and those of every view, as JSON"};
    Option<InputFolder> folder{this, "folder", InputFolder{},
                               "Folder of pictures made elsewhere (<sequence>_<frame>.png or .jpg), instead of port 'views'"};
    Option<double> stroke_cm{this, "stroke_cm", 0, range(0, 1000),
                             "Width of strokes that the painting was made with, compared with the surface; 0: not compared"};
    Option<int> every{this, "every", 1, range(1, 1'000'000), "Judge only every n-th picture"};
    Option<OutputName> path{this, "path", OutputName{"painting.json"}, "Name of the JSON file, below --out"};
    Slot<ImageIo> images{this, "Reads the pictures"};

    void check_inputs() const
    {
        const bool has_views = views.has_value() || !folder->empty();
        const bool shows_repeats = source.has_value() && textured_mesh.has_value();
        if (!has_views && ((style.has_value() && *stroke_cm == 0 && !shows_repeats) || frames.has_value()))
            throw Error(std::string("port '") + (frames.has_value() ? "frames" : "style") +
                        "' is compared with views: wire 'views' to what render.views made, or set 'folder'");
        if (*stroke_cm > 0 && (!style.has_value() || !textured_mesh.has_value()))
            throw Error(
                "option \"stroke_cm\" compares strokes on the painted mesh with those of the picture: wire 'textured_mesh' "
                "and 'style'");
        if (*stroke_cm == 0 && uvmaps.has_value())
            throw Error("the uv maps on port 'uvmaps' are compared with the size of strokes: set option \"stroke_cm\" to the "
                        "width that the painting was made with");
        if (!has_views && !textured_mesh.has_value() && !source.has_value())
            throw Error("nothing to measure: wire 'views' (or set 'folder') with 'style' or 'frames', or wire "
                        "'textured_mesh' or 'source'");
        if (has_views && !style.has_value() && !frames.has_value())
            throw Error("views are compared with the picture on port 'style' and with the camera pictures of port 'frames': wire "
                        "one of them or both");
        if (start.has_value() && !textured_mesh.has_value())
            throw Error("the texture on port 'start' is compared with the painted mesh: wire 'textured_mesh' to what "
                        "texture.bake made");
        if (textured_mesh.has_value())
            check_textured_mesh();
    }

    void check_textured_mesh() const
    {
        texturing::check_textured_mesh(*textured_mesh, "the mesh on port 'textured_mesh'");
        if (start.has_value())
            check_atlas(start->atlas, textured_mesh->mesh, "the texture on port 'start'");
        if (source.has_value())
            check_atlas(source->atlas, textured_mesh->mesh, "the map on port 'source'");
        if (uvmaps.has_value())
            check_atlas(uvmaps->atlas, textured_mesh->mesh, "the uv maps on port 'uvmaps'");
    }

    std::vector<View> wanted_views(RunContext& run) const
    {
        std::vector<View> all;
        const Files* const files = views.has_value() ? &*views : nullptr;
        if (frames.has_value())
            for (const auto& posed : evaluation::posed_pictures(*frames, files, folder->path, run))
            {
                const Frame& frame = frames->frames[posed.frame];
                all.push_back({frame.sequence + "_" + frame.name, posed.file, &frame});
            }
        else
            for (const auto& file : evaluation::pictures_of(files, folder->path, run))
                all.push_back({file.stem().string(), file, nullptr});
        if (all.empty())
            throw Error(std::string("no pictures ") + (files != nullptr ? "on port 'views'" : "in " + folder->path.string()) +
                        ": expected .png or .jpg files");
        std::erase_if(all, [&, i = 0](const View&) mutable { return i++ % *every != 0; });
        return all;
    }

    std::vector<JudgedView> judge_all(const std::vector<View>& all, RunContext& run) const
    {
        std::optional<StylePicture> style_picture;
        if (style.has_value())
            style_picture.emplace(style->pixels);
        if (style_picture && !style_picture->has_chroma())
            run.warning("the picture on port 'style' is gray: chroma_noise is not measured");
        std::vector<JudgedView> judged(all.size());
        parallel_for_each(all.size(), "views", run,
                          [&](std::size_t i)
                          {
                              const View& view = all[i];
                              const Raster8 picture = images->read_with_alpha(view.file);
                              if (view.frame != nullptr)
                                  evaluation::camera_of_picture(*view.frame, picture.width, picture.height, view.file);
                              const auto camera = [&] { return load_color(*view.frame, &*images); };
                              const bool has_camera = view.frame != nullptr && !view.frame->color_picture.empty();
                              judged[i] = judged_view(view.name, picture, style_picture ? &*style_picture : nullptr,
                                                      has_camera ? camera : std::function<Raster8()>());
                          });
        return judged;
    }

    /// Adds the figures over all views, and lists those of each view in `result`.
    void measure_views(std::vector<Figure>& found, Value::Map& result, RunContext& run) const
    {
        const std::vector<View> all = wanted_views(run);
        const std::vector<JudgedView> judged = judge_all(all, run);
        const auto skipped = static_cast<std::size_t>(std::ranges::count_if(judged, &JudgedView::skipped));
        if (skipped == all.size())
            throw Error(fmt::format("none of the {} views shows enough of the room: each needs at least {} pixels that are 6 px "
                                    "away from uncovered ones; render larger views",
                                    all.size(), JudgedView::least_pixels));
        std::ranges::move(figures_over(judged), std::back_inserter(found));
        run.report("views", all.size() - skipped);
        run.report("views_skipped", skipped);
        if (skipped > 0)
            run.message(fmt::format("{} of {} views skipped: too few covered pixels", skipped, all.size()));
        result.emplace_back("views", all.size() - skipped);
        result.emplace_back("views_skipped", skipped);
        result.emplace_back("view_figures", views_value(judged));
    }

    void measure_seams(std::vector<Figure>& found, Value::Map& result, RunContext& run) const
    {
        const Raster8& picture = textured_mesh->image.pixels;
        // Pairs must be as far apart as the coarser of the two pictures can tell.
        const int size = start.has_value() ? std::min(picture.width, start->size_px()) : picture.width;
        const SeamPairs pairs = find_seam_pairs(textured_mesh->mesh, size, run);
        const SeamFigures painted = seam_figures(pairs, picture, run);
        const auto tell = [&](const std::string& prefix, const SeamFigures& seams)
        {
            const Value ratio = evaluation::number_or_null(seams.ratio());
            run.report(prefix + "seam_ratio", ratio);
            result.emplace_back(prefix + "seam_ratio", ratio);
            result.emplace_back(prefix + "seam_difference", evaluation::number_or_null(seams.across));
            result.emplace_back(prefix + "inside_difference", evaluation::number_or_null(seams.inside));
            result.emplace_back(prefix + "seam_pairs", seams.across_count);
            result.emplace_back(prefix + "inside_pairs", seams.inside_count);
        };
        result.emplace_back("seam_distance_m", pairs.distance_m);
        tell("", painted);
        if (painted.across_count == 0)
        {
            run.message("the atlas has no seams but creases: there is nothing to see of them");
            return;
        }
        if (!start.has_value())
        {
            run.message("seam_ratio " + digits(painted.ratio()) +
                        ": wire 'start' to compare it with the texture before painting");
            return;
        }
        const SeamFigures before = seam_figures(pairs, *start, run);
        tell("start_", before);
        if (const double seams = painted.ratio() / before.ratio(); std::isfinite(seams))
            found.push_back({"seams", seams, std::nullopt, seams_wanted});
        else
            run.warning("the texture on port 'start' or the painting has one color around its seams: 'seams' is not defined");
    }

    void measure_source(std::vector<Figure>& found, Value::Map& result, RunContext& run) const
    {
        const SourceUse use = source_use(*source);
        found.push_back({"picture_used", use.picture_used, std::nullopt, picture_used_wanted});
        found.push_back({"largest_share", use.largest_share, std::nullopt, largest_share_wanted});
        result.emplace_back("texels_from_picture", use.texels);
        if (!textured_mesh.has_value() || !style.has_value())
            return;
        const Repeats seen = repeats(copied_points(*source, textured_mesh->mesh, on_white(style->pixels), run), run);
        found.push_back({"repeats", seen.repeats, std::nullopt, repeats_wanted});
        found.push_back({"weave", seen.weave, std::nullopt, weave_wanted});
    }

    void measure_strokes(std::vector<Figure>& found, Value::Map& result, RunContext& run) const
    {
        const StrokeSize size =
            stroke_size(*textured_mesh, on_white(style->pixels), *stroke_cm, uvmaps.has_value() ? &*uvmaps : nullptr, run);
        result.emplace_back("swatches", size.swatches);
        if (std::isfinite(size.stroke_cm))
            found.push_back({"stroke_cm",
                             size.stroke_cm,
                             std::nullopt,
                             {*stroke_cm * (1 - stroke_tolerance), *stroke_cm * (1 + stroke_tolerance)}});
        else
            run.warning(
                fmt::format("the surface has only {} flat places as wide as five strokes of {} cm on one chart: the size of "
                            "strokes is not measured",
                            size.swatches, digits(*stroke_cm)));
        if (std::isfinite(size.by_distance.correlation))
            measure_size_by_distance(size.by_distance, found, result, run);
    }

    /// Chance alone can take the correlation to twice its standard error: only beyond that is a larger one known to be too large.
    static void measure_size_by_distance(const SizeByDistance& measured, std::vector<Figure>& found, Value::Map& result,
                                         RunContext& run)
    {
        result.emplace_back("swatches_captured", measured.places);
        result.emplace_back("size_by_distance", measured.correlation);
        result.emplace_back("size_by_distance_error", measured.standard_error);
        result.emplace_back("independent_places", measured.independent_places());
        const std::string text =
            fmt::format("size_by_distance {} with a standard error of {} ({:.0f} independent places)",
                        digits(measured.correlation), digits(measured.standard_error), measured.independent_places());
        const double high = most_size_by_distance + 2 * measured.standard_error;
        const bool too_few = measured.independent_places() < least_independent_places;
        run.message(text + (too_few ? fmt::format(": small correlations are not told from chance below {:g}; measure narrower "
                                                  "strokes or a larger room",
                                                  least_independent_places)
                                    : ""));
        if (!too_few || std::abs(measured.correlation) > high)
            found.push_back({"size_by_distance", measured.correlation, std::nullopt, {-high, high}});
    }

    void run(RunContext& run) override
    {
        check_inputs();
        std::vector<Figure> found;
        Value::Map result;
        if (views.has_value() || !folder->empty())
            measure_views(found, result, run);
        if (textured_mesh.has_value())
            measure_seams(found, result, run);
        if (source.has_value())
            measure_source(found, result, run);
        if (*stroke_cm > 0)
            measure_strokes(found, result, run);

        result.insert(result.begin(), {"figures", figures_value(found)});
        for (const Figure& figure : found)
            run.report(figure.name, figure.value);
        if (!found.empty())
        {
            run.report("table", table(found));
            run.message(values_line(found));
            run.message(ranges_line(found));
        }
        figures = evaluation::write_figures(figures.folder(), path->path, result);
    }
};
}  // namespace

FRESCO_STAGE("evaluate.painting", EvaluatePainting, "Measures whether a room looks painted in the style of its picture")
