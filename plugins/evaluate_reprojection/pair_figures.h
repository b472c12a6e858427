#pragma once

#include "floor.h"
#include "frame_pairs.h"

#include <fresco/evaluation/statistics.h>
#include <fresco/value.h>

#include <memory>
#include <vector>

/// A picture and what of the mesh it shows.
struct JudgedView
{
    ViewSurface surface;
    fresco::Raster8 picture;  ///< RGB, of the camera's size.
};

struct JudgeOptions
{
    Protocol protocol;
    double min_covisible;  ///< Share of the source's pixels below which a pair is dropped.
};

/// What is measured of one pair. Where `dropped`, only `covisible` is.
struct PairFigures
{
    FramePair pair;
    double covisible = 0;  ///< Share of the source's pixels, 0..1.
    bool dropped = false;
    bool flat = false;     ///< The source has no detail over these pixels: the value says nothing, there is no headline.
    double value = 0;      ///< reprojection_difference
    double floor = 0;      ///< The same of the floor_pictures.
    double detail = 0;     ///< forward_difference
    double sharpness = 0;  ///< Variance of the Laplacian.
    double headline = 0;   ///< (value - floor) / detail; NaN where flat.
};

/// Pictures whose neighboring pixels differ by less than half a step of 8 bits, on average, are flat.
double least_detail(Protocol protocol);

/// Without a paint the floor is of the source's picture, projected. Throws Canceled.
PairFigures judge_pair(const FramePair& pair, const JudgedView& source, const JudgedView& target, const fresco::Mesh& mesh,
                       const SurfacePaint* paint, const JudgeOptions& options, const fresco::Progress& progress);

struct Figure
{
    double value = 0;
    fresco::evaluation::Interval interval;
};

/// Means over the pairs that were not dropped, with intervals over their source frames; the headline over those that are not
/// flat.
struct GapFigures
{
    std::size_t kept = 0;
    std::size_t dropped = 0;
    std::size_t flat = 0;
    bool invalid = false;  ///< No pair was kept, or at least half of these are flat.
    Figure value;
    Figure floor;
    Figure sharpness;
    Figure detail;
    Figure headline;
};
GapFigures summary(const std::vector<PairFigures>& pairs, const fresco::evaluation::Bootstrap& bootstrap);
