#include "best_samples.h"

#include <fresco/numerics/noise.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace fresco::from_frames
{
namespace
{

constexpr float packed_steps = 32767;
constexpr float least_limit = 0.15F;
constexpr float median_factor = 3;
constexpr float rounded = 0.02F;
constexpr int median_rounds = 6;
constexpr std::size_t most_places = 64;
/// From here to 1 a channel is taken for more and more saturated.
constexpr float saturates_from = 0.9F;
constexpr float saturated_weight = 0.3F;

using Color = std::array<float, 3>;

struct Weighted
{
    float weight = 0;
    Color rgb{};
};

float distance(const Color& a, const Color& b)
{
    float sum = 0;
    for (std::size_t c = 0; c < 3; ++c)
        sum += (a[c] - b[c]) * (a[c] - b[c]);
    return std::sqrt(sum / 3);
}

/// The color with the least weighted sum of distances to the samples (Weiszfeld 1937), distances below `rounded` being
/// flattened: unlike the nearest sample, it changes steadily where weights do.
Color geometric_median(std::span<const Weighted> samples)
{
    Color center{};
    for (int round = 0; round <= median_rounds; ++round)
    {
        Color sum{};
        float total = 0;
        for (const Weighted& sample : samples)
        {
            const float weight = round == 0 ? sample.weight : sample.weight / (rounded + distance(sample.rgb, center));
            total += weight;
            for (std::size_t c = 0; c < 3; ++c)
                sum[c] += weight * sample.rgb[c];
        }
        for (std::size_t c = 0; c < 3; ++c)
            center[c] = sum[c] / total;
    }
    return center;
}

/// Half of the weight is at most so far from `center`.
float median_distance(std::span<const Weighted> samples, const Color& center)
{
    std::array<std::pair<float, float>, most_places> by_distance;
    float total = 0;
    for (std::size_t i = 0; i < samples.size(); ++i)
    {
        by_distance[i] = {distance(samples[i].rgb, center), samples[i].weight};
        total += samples[i].weight;
    }
    std::sort(by_distance.begin(), by_distance.begin() + static_cast<std::ptrdiff_t>(samples.size()));
    float sum = 0;
    for (std::size_t i = 0; i < samples.size(); ++i)
        if ((sum += by_distance[i].second) * 2 >= total)
            return by_distance[i].first;
    return by_distance[samples.size() - 1].first;
}

KeptSample exposed(const TexelSample& sample, float weight_factor, Color gain)
{
    const float saturation = noise::smooth_step(saturates_from, 1, std::max({sample.rgb[0], sample.rgb[1], sample.rgb[2]}));
    const float of_white = std::max({1.0F, gain[0], gain[1], gain[2]});
    for (std::size_t c = 0; c < 3; ++c)
        gain[c] = sample.rgb[c] * (gain[c] + (of_white - gain[c]) * saturation);
    return {sample.weight * weight_factor * (1 + (saturated_weight - 1) * saturation), gain};
}

}  // namespace

KeptSample::KeptSample(float weight, const std::array<float, 3>& rgb)
    : weight_(static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(weight) >> 16U))
{
    for (std::size_t c = 0; c < 3; ++c)
        rgb_[c] = static_cast<std::uint16_t>(std::clamp(rgb[c] * packed_steps + 0.5F, 0.0F, 65535.0F));
}

float KeptSample::weight() const
{
    return std::bit_cast<float>(std::uint32_t{weight_} << 16U);
}

std::array<float, 3> KeptSample::rgb() const
{
    return {static_cast<float>(rgb_[0]) / packed_steps, static_cast<float>(rgb_[1]) / packed_steps,
            static_cast<float>(rgb_[2]) / packed_steps};
}

Blend blended(std::span<const KeptSample> samples, const BlendRules& rules)
{
    // What is heavier than the last place takes part. Equally heavy samples all do.
    const float threshold = samples.front().heavier_than(samples.back()) ? samples.back().weight() : 0;
    std::array<Weighted, most_places> used_places;
    std::size_t count = 0;
    for (const KeptSample& sample : samples)
        if (const float weight = sample.weight(); weight > threshold)
            used_places[count++] = {weight - threshold, sample.rgb()};
    const std::span<const Weighted> used(used_places.data(), count);

    Blend result;
    result.used = static_cast<int>(count);
    Color center{};
    float limit = 0;
    if (rules.reject_outliers)
    {
        center = geometric_median(used);
        limit = std::max(least_limit, median_factor * median_distance(used, center));
    }
    Color sum{};
    float total = 0;
    for (const Weighted& sample : used)
    {
        float weight = sample.weight;
        if (rules.reject_outliers)
        {
            const float ratio = distance(sample.rgb, center) / limit;
            const float share = std::max(0.0F, 1 - ratio * ratio);
            result.rejected += share == 0;
            weight *= share * share;
        }
        total += weight;
        for (std::size_t c = 0; c < 3; ++c)
            sum[c] += weight * sample.rgb[c];
    }
    for (std::size_t c = 0; c < 3; ++c)
        result.rgb[c] = std::clamp(sum[c] / total, 0.0F, 1.0F);
    return result;
}

BestSamples::BestSamples(std::size_t texels, std::size_t places) : places_(places), kept_(texels * places) {}

void BestSamples::add(std::span<const TexelSample> samples, float weight_factor, const std::optional<Color>& gain)
{
    for (const TexelSample& sample : samples)
    {
        const KeptSample kept =
            gain ? exposed(sample, weight_factor, *gain) : KeptSample(sample.weight * weight_factor, sample.rgb);
        KeptSample* const first = kept_.data() + std::size_t{sample.texel} * places_;
        KeptSample* place = first + places_ - 1;
        if (!kept.heavier_than(*place))
            continue;
        for (; place != first && kept.heavier_than(*(place - 1)); --place)
            *place = *(place - 1);
        *place = kept;
    }
}

}  // namespace fresco::from_frames
