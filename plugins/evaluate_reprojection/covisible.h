#pragma once

#include "view_surface.h"

#include <fresco/evaluation/protocol.h>

#include <vector>

using fresco::evaluation::Protocol;

/// A bilinear lookup: at most four pixels and the shares of the second column and row.
struct Lookup
{
    int x0 = 0;
    int y0 = 0;
    int x1 = 0;  ///< x0 or x0 + 1
    int y1 = 0;
    double share_x = 0;  ///< [0, 1)
    double share_y = 0;
};

/// A pixel of the source picture and where the target picture shows the same point of the surface.
struct Match
{
    int x = 0;
    int y = 0;
    Lookup target;
};

/// The source's pixels whose surface point both cameras see, row by row.
/// `paper`: the point lies between the target's pixel centers, and at every target pixel that contributes to the bilinear value
/// |z - depth| <= 2 % of z + 1 cm. Pixels beside one without surface are left out in both pictures: renders are antialiased
/// there. `released`: pixel indices are moved by index / size (the script scales them by W but looks them up by W - 1, and so for
/// H); a depth within 0.1 m at one of the four pixels is enough, and all that contribute must have one.
std::vector<Match> covisible(const ViewSurface& source, const ViewSurface& target, Protocol protocol);
