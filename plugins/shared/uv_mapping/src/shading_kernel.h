#pragma once

#include <cstddef>
#include <cstdint>

namespace fresco::shading
{

/// A vertex of the mesh.
struct Vertex
{
    float position[3];
    float normal[3];
    float unused[2];  ///< So that none lies in two cache lines.
};

/// Inputs for shading a row of pixels; plain arrays, as the loops are compiled for several kinds of processors.
struct Source
{
    const std::uint32_t (*triangles)[3];
    const float (*texcoords)[2];  ///< Three per triangle.
    const Vertex* vertices;
    double origin[3];      ///< Origin of the rays.
    double depth_axis[3];  ///< Takes a direction to its length along the optical axis.
    double across[3];      ///< From one pixel's ray to the next one's.
    float nearest;         ///< Smallest depth; nearer surface is clipped.
};

/// One row's values, as UvMap and seen_through_crack have them.
struct Target
{
    float* uv;
    float* depth;
    float* cosine;
    std::uint8_t* valid;
    float* met;
};

/// Pixels by what they see.
struct Seen
{
    std::int64_t surface;
    std::int64_t back_face;
    std::int64_t too_near;
    std::int64_t nothing;
};

struct Kernel
{
    const char* name;
    /// Bytes of scratch memory for each pixel of the row; the memory is aligned to 64.
    unsigned scratch_bytes;

    /// Shades a row of `width` pixels that see `faces`; the first one's ray goes along `ray`. Adds to `seen`. `scratch`: width
    /// times scratch_bytes.
    void (*shade_row)(const Source& source, const std::uint32_t* faces, int width, const double* ray, const Target& target,
                      void* scratch, Seen& seen);
};

/// For any processor, and for x86-64 ones with AVX2 and FMA, and with AVX-512; null where the compiler cannot make them.
const Kernel* base_kernel();
const Kernel* avx2_kernel();
const Kernel* avx512_kernel();
/// The fastest that this processor can run.
const Kernel& fastest_kernel();

}  // namespace fresco::shading
