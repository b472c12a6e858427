#include "variety.h"

#include <fresco/numerics/noise.h>
#include <fresco/parallel.h>

#include <cmath>

namespace fresco::synthesize
{
namespace
{

constexpr double strokes_per_wave = 2.75;       // Over this length preferences change on the surface …
constexpr double picture_strokes_per_wave = 2;  // … and in the picture.
constexpr float deviation = 0.19F;              // Of the product of two sums of Variety::fields fields.
constexpr std::uint32_t picture_salt = 100;

}  // namespace

float smooth_noise(Vec3f at, std::uint32_t salt)
{
    const Vec3f low{std::floor(at.x), std::floor(at.y), std::floor(at.z)};
    const auto lattice = [](float v, int step) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(v) + step); };
    const auto share = [](float v, float from, int step) { return step != 0 ? v - from : 1 - v + from; };
    float sum = 0;
    for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 2; ++j)
            for (int i = 0; i < 2; ++i)
            {
                const std::uint32_t h =
                    noise::hash(lattice(low.x, i), noise::hash(lattice(low.y, j), noise::hash(lattice(low.z, k), salt)));
                sum += (2 * noise::unit(h) - 1) * share(at.x, low.x, i) * share(at.y, low.y, j) * share(at.z, low.z, k);
            }
    return sum;
}

Variety::Variety(const Patches& patches, const SurfaceGrid& grid, const PictureLevel& picture, double stroke_px, double amount,
                 std::uint32_t seed, const Progress& progress)
    : of_patch_(patches.count() * fields), of_key_(picture.key_count() * fields)
{
    const auto waves = static_cast<float>(1 / (strokes_per_wave * stroke_px * grid.spacing_m()));
    const auto scale = static_cast<float>(amount) / deviation;
    const auto salt = [seed](std::size_t field) { return noise::hash(seed, static_cast<std::uint32_t>(field)); };
    parallel_for(patches.count(), 4096, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t i = begin; i < end; ++i)
                         for (std::size_t f = 0; f < fields; ++f)
                             of_patch_[i * fields + f] = scale * smooth_noise(patches[i].center * waves, salt(f));
                 });
    const auto picture_waves = static_cast<float>(1 / (picture_strokes_per_wave * stroke_px));
    for (std::size_t k = 0; k < picture.key_count(); ++k)
        for (std::size_t f = 0; f < fields; ++f)
        {
            const Vec2f at = picture.key(k) * picture_waves;
            of_key_[k * fields + f] = smooth_noise({at.x, at.y, 0.5F}, salt(picture_salt + f));
        }
}

float Variety::preference(std::size_t patch, std::size_t key) const
{
    float sum = 0;
    for (std::size_t f = 0; f < fields; ++f)
        sum += of_patch(patch)[f] * of_key(key)[f];
    return sum;
}

}  // namespace fresco::synthesize
