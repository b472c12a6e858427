#pragma once

#include "palette.h"

#include <fresco/image.h>

#include <cstddef>

/// 1 where a picture shows something, else 0: where alpha is not 0, or in a picture without alpha where R + G + B > 5.
fresco::Raster8 covered_pixels(const fresco::Raster8& picture);

/// The covered pixels that are judged: those with only covered ones within 6 px, and 8 px from the picture's border.
struct JudgedPixels
{
    fresco::Raster8 mask;
    std::size_t count = 0;
};
JudgedPixels judged_pixels(const fresco::Raster8& covered);

/// How paint looks, measured on a picture in CIE L*a*b*.
struct Appearance
{
    double coherence = 0;     ///< 0..1: how much strokes have a direction, by the structure tensor of L*.
    double chroma_noise = 0;  ///< Energy of a* and b* over that of L* above a Gaussian of 1 px, the root of it.
    double strokes = 0;       ///< Root mean square of L* between Gaussians of 1 px and 4 px.
};
/// `lab`: H x W x 3, `mask`: H x W. Without variation all are 0; chroma_noise is infinite where only a* and b* vary.
Appearance appearance(const fresco::RasterF& lab, const fresco::Raster8& mask);

/// The style picture as RGB: transparent parts are white. Throws Error unless it has 1, 3 or 4 channels.
fresco::Raster8 on_white(const fresco::Raster8& picture);

/// What is compared with: the painting, scaled to 256 px along its shorter side.
struct StylePicture
{
    /// `picture`: 1, 3 or 4 channels; transparent parts are white. Throws Error for one of a single color, or longer than 16
    /// times its width.
    explicit StylePicture(const fresco::Raster8& picture);

    /// Its finest detail has color: chroma_noise can be compared.
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
    double coherence = 0;     ///< The view's over the picture's, as the other two.
    double chroma_noise = 0;  ///< NaN unless the style picture has_chroma().
    double strokes = 0;
};
/// `view`: 3 or 4 channels, at its own size. \pre pixels.count > 0
ViewFigures view_figures(const fresco::Raster8& view, const JudgedPixels& pixels, const StylePicture& style);
