#pragma once

#include "figure_table.h"
#include "view_figures.h"

#include <fresco/image.h>
#include <fresco/value.h>

#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <vector>

/// The figures of a view, NaN where they were not measured.
struct JudgedView
{
    /// A view with fewer judged pixels is skipped.
    static constexpr std::size_t least_pixels = 5000;

    std::string name;
    bool skipped = false;
    ViewFigures figures{.off_palette = undefined, .coherence = undefined, .chroma_noise = undefined, .strokes = undefined};
    double edges = undefined;

  private:
    static constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
};

/// `view`: 3 or 4 channels. Without `style` there are no ViewFigures, without `camera`, which loads the camera's picture, no
/// edges.
JudgedView judged_view(const std::string& name, const fresco::Raster8& view, const StylePicture* style,
                       const std::function<fresco::Raster8()>& camera);

/// Over the views, those that were measured in one at least.
std::vector<Figure> figures_over(const std::vector<JudgedView>& views);
/// For a program: a list of the views, each with the figures that it has.
fresco::Value views_value(const std::vector<JudgedView>& views);
