#pragma once

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/numerics/greedy_cover.h>
#include <fresco/run_context.h>
#include <fresco/uv_maps.h>

#include <vector>

namespace fresco::cover
{

/// How much it is worth to see a cell: 1 to see it at all, and more to see it well. Both are small beside that, so that a frame
/// that sees more is chosen before one that sees better.
struct WorthRules
{
    double angle_weight = 0.3;      ///< Added when it is seen straight on, in proportion to the cosine of the angle.
    double sharpness_weight = 0.1;  ///< Added for a picture as sharp as the median, in proportion; 0: pictures are not read.
};

/// The cells that valid pixels of `map` fall into, ascending, each with the best worth that a pixel gives it, scaled so that the
/// most possible is SeenCell::best_worth; never 0. Cells are numbered row by row in a square grid of cells_px x cells_px over the
/// texture, from the lower left. \pre cells_px² <= SeenCell::most_cells, sharpness in [0,1]
std::vector<numerics::SeenCell> seen_cells(const UvMap& map, int cells_px, double sharpness, const WorthRules& rules);

struct CoverOptions
{
    double target_coverage;  ///< Stop at this share of the cells that all frames see.
    int max_frames = 0;      ///< 0: as many as the target needs.
    double max_share = 1;    ///< Choose at most this share of the frames.
    double min_seen_share =
        0.05;             ///< Frames with less of the mesh in the picture would be mostly empty for what is made of them.
    int cells_px = 1024;  ///< Along a side of the texture: cells of about a centimeter in a room.
    int height_px = 256;  ///< At which frames view the mesh: pixels lie about as close as cells.
    WorthRules worth = {};
};

/// The fewest frames that see enough of the mesh, in their order; reports figures. `images`: may be null if all pictures are NPY.
/// Throws Error, Canceled.
Frames covering_frames(const Mesh& mesh, const Frames& frames, const CoverOptions& options, const ImageIo* images,
                       RunContext& run);

}  // namespace fresco::cover
