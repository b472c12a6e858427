#pragma once

#include "circles.h"

#include <fresco/evaluation/statistics.h>

#include <cstddef>
#include <span>
#include <vector>

struct CircleStatistics
{
    double corr_2d = 0;  ///< Pearson's correlation of depth and radius in pixels; NaN where undefined.
    double corr_3d = 0;  ///< Of depth and radius in meters.
    double stretch = 0;  ///< Mean stretch on the surface.
};

/// Of the pictures drawn, one after the other. `paper`: all circles together. `released`: of each picture, then the mean weighted
/// by its number of circles; pictures for which a figure is undefined are left out of it.
CircleStatistics circle_statistics(const std::vector<std::vector<Circle>>& pictures, std::span<const std::size_t> drawn,
                                   Protocol protocol);

struct CircleFigures
{
    std::size_t circles = 0;     ///< With a depth at the center.
    std::size_t circles_3d = 0;  ///< With a radius in meters too.
    CircleStatistics value;
    fresco::evaluation::Interval corr_2d;
    fresco::evaluation::Interval corr_3d;
    fresco::evaluation::Interval stretch;
};

/// The statistics of all pictures and their intervals over pictures.
CircleFigures circle_figures(const std::vector<std::vector<Circle>>& pictures, Protocol protocol,
                             const fresco::evaluation::Bootstrap& bootstrap);
