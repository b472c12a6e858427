// The loops of shading_kernel.h. Compiled several times for other processors, so that they must not use anything inline from
// elsewhere: the linker might take this copy for all.

#include "shading_kernel.h"

#if defined(__clang__)
#define FRESCO_SHUFFLE(a, b, places, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define FRESCO_SHUFFLE(a, b, places, ...) __builtin_shuffle(a, b, places{__VA_ARGS__})
#endif

namespace fresco::shading
{

#if FRESCO_VECTOR_BYTES > 0
namespace
{

typedef double Doubles __attribute__((vector_size(32)));
typedef std::int64_t Longs __attribute__((vector_size(32)));
typedef float Floats __attribute__((vector_size(32)));
typedef std::int32_t Ints __attribute__((vector_size(32)));
typedef std::int32_t HalfInts __attribute__((vector_size(16)));
typedef std::int8_t Bytes __attribute__((vector_size(8)));
typedef float LooseFloats __attribute__((vector_size(32), aligned(4), may_alias));
typedef std::int32_t LooseInts __attribute__((vector_size(32), aligned(4), may_alias));
typedef std::int8_t LooseBytes __attribute__((vector_size(8), aligned(1), may_alias));

/// A face seen from a camera's place: what takes a ray's direction to everything that the map holds. Corners a, b, c; the ray
/// along d meets the face's plane where the weights of b and c are (d.weigh_b)/(d.normal) and (d.weigh_c)/(d.normal): Cramer's
/// rule as in Möller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997).
struct Plane
{
    Doubles x, y, z;  ///< Coordinates of the normal, weigh_b, weigh_c and padding.
    Floats at_a;      ///< u, v, depth, the vertex's normal, …
    Floats to_b;      ///< … and how they change from a to b …
    Floats to_c;      ///< … and from a to c.
};

/// A corner of the mesh, in the same layout.
struct Corner
{
    double x, y, z;  ///< From the rays' origin.
    Floats values;
};

Corner corner_of(const Source& source, std::uint32_t face, int i)
{
    const Vertex& v = source.vertices[source.triangles[face][i]];
    const float* uv = source.texcoords[3 * static_cast<std::size_t>(face) + static_cast<std::size_t>(i)];
    Corner corner;
    corner.x = v.position[0] - source.origin[0];
    corner.y = v.position[1] - source.origin[1];
    corner.z = v.position[2] - source.origin[2];
    const double depth = corner.x * source.depth_axis[0] + corner.y * source.depth_axis[1] + corner.z * source.depth_axis[2];
    corner.values = Floats{uv[0], uv[1], static_cast<float>(depth), v.normal[0], v.normal[1], v.normal[2], 0, 0};
    return corner;
}

Plane plane_of(const Source& source, std::uint32_t face)
{
    const Corner a = corner_of(source, face, 0);
    const Corner b = corner_of(source, face, 1);
    const Corner c = corner_of(source, face, 2);
    // normal = ab x ac, weigh_b = ac x a, weigh_c = a x ab.
    const Doubles left_x{b.x - a.x, c.x - a.x, a.x, 0};
    const Doubles left_y{b.y - a.y, c.y - a.y, a.y, 0};
    const Doubles left_z{b.z - a.z, c.z - a.z, a.z, 0};
    const Doubles right_x = FRESCO_SHUFFLE(left_x, left_x, Longs, 1, 2, 0, 3);
    const Doubles right_y = FRESCO_SHUFFLE(left_y, left_y, Longs, 1, 2, 0, 3);
    const Doubles right_z = FRESCO_SHUFFLE(left_z, left_z, Longs, 1, 2, 0, 3);
    return {left_y * right_z - left_z * right_y,
            left_z * right_x - left_x * right_z,
            left_x * right_y - left_y * right_x,
            a.values,
            b.values - a.values,
            c.values - a.values};
}

constexpr std::uint32_t none = 0xFFFFFFFF;

/// Numbers the runs of pixels that see one face: `number` of every pixel, `face` of every run. Returns how many there are. No
/// branch, as faces change at random.
int number_runs(const std::uint32_t* faces, int width, std::uint32_t* number, std::uint32_t* face)
{
    std::uint32_t current = 0;
    face[0] = faces[0];
    for (int i = 0; i < width; ++i)
    {
        current += faces[i] != face[current];
        face[current] = faces[i];
        number[i] = current;
    }
    return static_cast<int>(current) + 1;
}

void fill_planes(const Source& source, const std::uint32_t* faces, int count, Plane* planes)
{
    constexpr int ahead = 8;
    for (int i = 0; i < count; ++i)
    {
        // The next faces' data is prefetched in two steps, as the first holds the address of the second.
        if (i + 2 * ahead < count && faces[i + 2 * ahead] != none)
        {
            __builtin_prefetch(source.triangles[faces[i + 2 * ahead]]);
            __builtin_prefetch(source.texcoords[3 * static_cast<std::size_t>(faces[i + 2 * ahead])]);
        }
        if (i + ahead < count && faces[i + ahead] != none)
            for (int k = 0; k < 3; ++k)
                __builtin_prefetch(source.vertices + source.triangles[faces[i + ahead]][k]);
        planes[i] = faces[i] == none ? Plane{} : plane_of(source, faces[i]);
    }
}

/// Pixels that are shaded at once.
constexpr int group = 8;

template <class Values, class Mask>
Values where(Mask mask, Values values)
{
    return (Values)((Mask)values & mask);
}

/// Weights of the corners b and c where a ray meets the plane, moved into the face where it passes by.
void weigh(Doubles against, Doubles& b, Doubles& c)
{
    const Doubles whole = 1 / against;
    b *= whole;
    c *= whole;
    // Not finite where the ray runs along the plane: the middle of the face then.
    const Longs finite = (b - b == 0) & (c - c == 0);
    const Doubles third = Doubles{} + 1.0 / 3;
    b = where(finite, b) + where(~finite, third);
    c = where(finite, c) + where(~finite, third);
    const Doubles rest = 1 - b - c;
    const Doubles a = where(rest > 0, rest);
    b = where(b > 0, b);
    c = where(c > 0, c);
    const Doubles share = 1 / (a + b + c);
    b *= share;
    c *= share;
}

/// Entries 0, 1 and 2 of four vectors.
void transpose(const Doubles* from, Doubles& zeroth, Doubles& first, Doubles& second)
{
    const Doubles even01 = FRESCO_SHUFFLE(from[0], from[1], Longs, 0, 4, 2, 6);
    const Doubles even23 = FRESCO_SHUFFLE(from[2], from[3], Longs, 0, 4, 2, 6);
    const Doubles odd01 = FRESCO_SHUFFLE(from[0], from[1], Longs, 1, 5, 3, 7);
    const Doubles odd23 = FRESCO_SHUFFLE(from[2], from[3], Longs, 1, 5, 3, 7);
    zeroth = FRESCO_SHUFFLE(even01, even23, Longs, 0, 1, 4, 5);
    first = FRESCO_SHUFFLE(odd01, odd23, Longs, 0, 1, 4, 5);
    second = FRESCO_SHUFFLE(even01, even23, Longs, 2, 3, 6, 7);
}

/// Entries 0 to 5 of eight vectors.
void transpose(const Floats* from, Floats* to)
{
    Floats lows[4];
    Floats highs[4];
    for (int i = 0; i < 4; ++i)
    {
        lows[i] = FRESCO_SHUFFLE(from[2 * i], from[2 * i + 1], Ints, 0, 8, 1, 9, 4, 12, 5, 13);
        highs[i] = FRESCO_SHUFFLE(from[2 * i], from[2 * i + 1], Ints, 2, 10, 3, 11, 6, 14, 7, 15);
    }
    Floats columns[2][4];
    for (int i = 0; i < 2; ++i)
    {
        columns[i][0] = FRESCO_SHUFFLE(lows[2 * i], lows[2 * i + 1], Ints, 0, 1, 8, 9, 4, 5, 12, 13);
        columns[i][1] = FRESCO_SHUFFLE(lows[2 * i], lows[2 * i + 1], Ints, 2, 3, 10, 11, 6, 7, 14, 15);
        columns[i][2] = FRESCO_SHUFFLE(highs[2 * i], highs[2 * i + 1], Ints, 0, 1, 8, 9, 4, 5, 12, 13);
        columns[i][3] = FRESCO_SHUFFLE(highs[2 * i], highs[2 * i + 1], Ints, 2, 3, 10, 11, 6, 7, 14, 15);
    }
    for (int i = 0; i < 4; ++i)
        to[i] = FRESCO_SHUFFLE(columns[0][i], columns[1][i], Ints, 0, 1, 2, 3, 8, 9, 10, 11);
    for (int i = 0; i < 2; ++i)
        to[4 + i] = FRESCO_SHUFFLE(columns[0][i], columns[1][i], Ints, 4, 5, 6, 7, 12, 13, 14, 15);
}

Floats roots(Floats of)
{
    for (int i = 0; i < group; ++i)
        of[i] = __builtin_sqrtf(of[i]);
    return of;
}

/// Pixels first to first + 7 of a row; `numbers` holds the plane of each.
void shade_group(const Source& source, const Plane* planes, const std::uint32_t* numbers, const std::uint32_t* faces, int first,
                 const double* ray, const Target& target, Ints* counts)
{
    Doubles along[group];
    for (int i = 0; i < group; ++i)
    {
        const Plane& plane = planes[numbers[i]];
        along[i] = plane.x * (ray[0] + source.across[0] * (first + i)) + plane.y * (ray[1] + source.across[1] * (first + i)) +
                   plane.z * (ray[2] + source.across[2] * (first + i));
    }
    Longs against[2];
    double b[group];
    double c[group];
    for (int half = 0; half < 2; ++half)
    {
        Doubles normal;
        Doubles weigh_b;
        Doubles weigh_c;
        transpose(along + 4 * half, normal, weigh_b, weigh_c);
        against[half] = normal < 0;
        weigh(normal, weigh_b, weigh_c);
        for (int i = 0; i < 4; ++i)
        {
            b[4 * half + i] = weigh_b[i];
            c[4 * half + i] = weigh_c[i];
        }
    }
    Floats met[group];
    for (int i = 0; i < group; ++i)
    {
        const Plane& plane = planes[numbers[i]];
        met[i] = plane.at_a + plane.to_b * static_cast<float>(b[i]) + plane.to_c * static_cast<float>(c[i]);
    }
    Floats values[6];
    transpose(met, values);
    const Floats u = values[0];
    const Floats v = values[1];
    const Floats depth = values[2];

    const Floats step = Floats{0, 1, 2, 3, 4, 5, 6, 7} + static_cast<float>(first);
    const Floats x = step * static_cast<float>(source.across[0]) + static_cast<float>(ray[0]);
    const Floats y = step * static_cast<float>(source.across[1]) + static_cast<float>(ray[1]);
    const Floats z = step * static_cast<float>(source.across[2]) + static_cast<float>(ray[2]);
    const Floats toward = values[3] * x + values[4] * y + values[5] * z;
    const Floats squares = values[3] * values[3] + values[4] * values[4] + values[5] * values[5];
    Floats cosine = -toward / roots(squares * (x * x + y * y + z * z));
    cosine = where(cosine > 0, cosine);
    cosine = where(cosine < 1, cosine) + where(cosine >= 1, Floats{} + 1);

    const HalfInts sides[2] = {__builtin_convertvector(against[0], HalfInts), __builtin_convertvector(against[1], HalfInts)};
    Ints front;
    __builtin_memcpy(&front, sides, sizeof front);
    // A depth beyond the range of numbers is no surface.
    const Ints something = (*reinterpret_cast<const LooseInts*>(faces) != static_cast<std::int32_t>(none)) & (depth - depth == 0);
    const Ints near = depth < source.nearest;
    const Ints valid = something & front & ~near;
    const Floats valid_u = where(valid, u);
    const Floats valid_v = where(valid, v);
    LooseFloats* uv = reinterpret_cast<LooseFloats*>(target.uv);
    uv[0] = FRESCO_SHUFFLE(valid_u, valid_v, Ints, 0, 8, 1, 9, 2, 10, 3, 11);
    uv[1] = FRESCO_SHUFFLE(valid_u, valid_v, Ints, 4, 12, 5, 13, 6, 14, 7, 15);
    *reinterpret_cast<LooseFloats*>(target.depth) = where(valid, depth);
    *reinterpret_cast<LooseFloats*>(target.cosine) = where(valid, cosine);
    *reinterpret_cast<LooseBytes*>(target.valid) = __builtin_convertvector(valid, Bytes) & 1;
    *reinterpret_cast<LooseFloats*>(target.met) = where(something, depth) + where(~something, Floats{} + __builtin_inff());
    counts[0] -= valid;
    counts[1] -= something & ~front;
    counts[2] -= something & front & near;
    counts[3] -= ~something;
}

/// The last pixels of a row, fewer than a group.
void shade_rest(const Source& source, const Plane* planes, const std::uint32_t* numbers, const std::uint32_t* faces, int first,
                int count, const double* ray, const Target& target, Ints* counts)
{
    std::uint32_t their_numbers[group] = {};
    std::uint32_t their_faces[group] = {};
    float uv[2 * group];
    float depth[group];
    float cosine[group];
    std::uint8_t valid[group];
    float met[group];
    Ints there{};
    for (int i = 0; i < count; ++i)
    {
        their_numbers[i] = numbers[i];
        their_faces[i] = faces[i];
        there[i] = -1;
    }
    Ints all[4] = {};
    shade_group(source, planes, their_numbers, their_faces, first, ray, {uv, depth, cosine, valid, met}, all);
    for (int i = 0; i < 4; ++i)
        counts[i] += all[i] & there;
    for (int i = 0; i < count; ++i)
    {
        target.uv[2 * i] = uv[2 * i];
        target.uv[2 * i + 1] = uv[2 * i + 1];
        target.depth[i] = depth[i];
        target.cosine[i] = cosine[i];
        target.valid[i] = valid[i];
        target.met[i] = met[i];
    }
}

void shade_row(const Source& source, const std::uint32_t* faces, int width, const double* ray, const Target& target,
               void* scratch, Seen& seen)
{
    auto* planes = static_cast<Plane*>(scratch);
    auto* numbers = reinterpret_cast<std::uint32_t*>(planes + width);
    std::uint32_t* run_faces = numbers + width;
    fill_planes(source, run_faces, number_runs(faces, width, numbers, run_faces), planes);
    Ints counts[4] = {};
    const auto from = [&](int i) -> Target {
        return {target.uv + 2 * i, target.depth + i, target.cosine + i, target.valid + i, target.met + i};
    };
    int i = 0;
    for (; i + group <= width; i += group)
        shade_group(source, planes, numbers + i, faces + i, i, ray, from(i), counts);
    if (i < width)
        shade_rest(source, planes, numbers + i, faces + i, i, width - i, ray, from(i), counts);
    for (int k = 0; k < group; ++k)
    {
        seen.surface += counts[0][k];
        seen.back_face += counts[1][k];
        seen.too_near += counts[2][k];
        seen.nothing += counts[3][k];
    }
}

}  // namespace
#endif

const Kernel* FRESCO_KERNEL()
{
#if FRESCO_VECTOR_BYTES > 0
    static constexpr Kernel kernel{FRESCO_KERNEL_NAME, sizeof(Plane) + 2 * sizeof(std::uint32_t), shade_row};
    return &kernel;
#else
    return nullptr;
#endif
}

}  // namespace fresco::shading
