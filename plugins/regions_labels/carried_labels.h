#pragma once

#include "labeled_surface.h"

#include <fresco/progress.h>

struct CarriedLabels
{
    std::vector<std::uint32_t> label_of_face;  ///< Of the other mesh; index into the surface's names, or no_label.
    double covered_share = 0;                  ///< Of that mesh's area: closer to the surface than the limit.
    double mean_distance_m = 0;                ///< Of the middles of those faces from the surface.
};

/// The labels of another mesh of the same surface: of each face the label of the face that is closest to its middle, if it is
/// closer than `within_m`. Equal for any number of threads. Throws Canceled.
CarriedLabels carried_labels(const LabeledSurface& from, const fresco::Mesh& to, double within_m,
                             const fresco::Progress& progress);
