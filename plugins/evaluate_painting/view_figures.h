#pragma once

#include "figure_table.h"

#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/value.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

/// \file Figures of how painted single views look: their colors, strokes and speckle beside the style picture's, and how much of
/// the camera picture's edges is left. The stage judges every view with judged_view() and reports figures_over() all of them.

/// The colors of a picture in CIE L*a*b*, rounded to cells of 2 units.
class Palette
{
  public:
    /// `lab`: H x W x 3.
    explicit Palette(const fresco::RasterF& lab);

    /// A color of the picture, rounded, is at most 10 units away (CIE76).
    bool is_near(fresco::Vec3f color) const;

  private:
    std::vector<std::uint8_t> cells_;  ///< 1 = the picture has it.
};

/// The share of the camera picture's edges that a view keeps: the correlation of the gradients of L*, x and y together, at 256 px
/// height after a Gaussian of 3 px, over covered pixels with only covered ones within 7 px. Uncovered pixels have no weight in
/// the blur. `view`: 3 or 4 channels; `covered`: its covered_pixels; `camera`: RGB of any size and of the view's aspect ratio.
/// NaN if fewer than 1000 pixels are left or one of the two has no gradient.
double edge_correlation(const fresco::Raster8& view, const fresco::Raster8& covered, const fresco::Raster8& camera);

/// The share of what the camera picture shows that can be told from a view, whatever its colors: the mutual information of the
/// lightness of both, in cells of 4 px at 256 px height and less the mean around (a Gaussian of 12 px), each in eight classes of
/// equal size, over the entropy of the classes; less its bias (Miller 1955). About 0 for an unrelated view, 1 for the camera
/// picture in other colors. Arguments as for edge_correlation(). NaN if fewer than 500 cells are covered.
double legibility(const fresco::Raster8& view, const fresco::Raster8& covered, const fresco::Raster8& camera);

/// 1 for pixels that show something, else 0: alpha is not 0 or, without alpha, R + G + B > 5.
fresco::Raster8 covered_pixels(const fresco::Raster8& picture);

/// The covered pixels to judge: at least 8 px from the picture's border, and with only covered ones within 6 px.
struct JudgedPixels
{
    fresco::Raster8 mask;
    std::size_t count = 0;
};

JudgedPixels judged_pixels(const fresco::Raster8& covered);

/// The look of paint, measured on a picture in CIE L*a*b*.
struct Appearance
{
    double coherence = 0;     ///< 0..1: how directed strokes are, by the structure tensor of L*.
    double chroma_noise = 0;  ///< Root of the energy of a* and b* over that of L*, above a Gaussian of 1 px.
    double strokes = 0;       ///< Root mean square of L* between Gaussians of 1 px and 4 px.
};

/// The style picture as RGB: transparent parts are white. Throws Error unless it has 1, 3 or 4 channels.
fresco::Raster8 on_white(const fresco::Raster8& picture);

/// The reference of view_figures(): the style picture, scaled to 256 px along its shorter side.
struct StylePicture
{
    /// `picture`: 1, 3 or 4 channels; transparent parts are white. Throws Error for a single color, and for a picture longer
    /// than 16 times its width.
    explicit StylePicture(const fresco::Raster8& picture);

    /// Whether its finest detail has color, so that chroma_noise can be compared.
    bool has_chroma() const { return look.chroma_noise > 1e-3; }

    Palette palette;
    Appearance look;

  private:
    explicit StylePicture(const fresco::RasterF& lab);
};

/// A view relative to the style picture.
struct ViewFigures
{
    double off_palette = 0;   ///< Share of the judged pixels whose color the style picture does not have, 0..1.
    double coherence = 0;     ///< The view's over the picture's, like the next two.
    double chroma_noise = 0;  ///< NaN unless the style picture has_chroma().
    double strokes = 0;
};

/// `view`: 3 or 4 channels, at its own size. \pre pixels.count > 0
ViewFigures view_figures(const fresco::Raster8& view, const JudgedPixels& pixels, const StylePicture& style);

/// The figures of a view; NaN if not measured.
struct JudgedView
{
    /// A view with fewer judged pixels is skipped.
    static constexpr std::size_t least_pixels = 5000;

    std::string name;
    bool skipped = false;
    ViewFigures figures{.off_palette = undefined, .coherence = undefined, .chroma_noise = undefined, .strokes = undefined};
    double edges = undefined;
    double legible = undefined;

  private:
    static constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
};

/// `view`: 3 or 4 channels. Without `style` there are no ViewFigures; without `camera`, which loads the camera's picture,
/// there are no edges and no legibility.
JudgedView judged_view(const std::string& name, const fresco::Raster8& view, const StylePicture* style,
                       const std::function<fresco::Raster8()>& camera);

/// Mean and worst of every figure that was measured in at least one view.
std::vector<Figure> figures_over(const std::vector<JudgedView>& views);

/// For programs: a list of the views, each with its figures.
fresco::Value views_value(const std::vector<JudgedView>& views);
