#pragma once

#include "glb.h"
#include "read_glb.h"

/// How far what a file holds may be from what was to be written.
struct GlbErrors
{
    double position_m = 0;  ///< Largest difference along an axis.
    double texcoord = 0;    ///< Largest difference of u or v.
};

/// Compares a file that was read again with what was given to make_glb: the same triangles in the same order (their corners may
/// be turned where it is compressed), every position, normal and texcoord within what quantized_mesh.h promises (the same bits
/// without quantization), the picture's bytes. Throws Error naming the first difference.
GlbErrors check_glb(const GlbModel& model, const fresco::texturing::WeldedMesh& mesh, const std::vector<std::byte>& image,
                    const GlbOptions& options);
