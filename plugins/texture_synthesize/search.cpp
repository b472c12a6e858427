#include "search.h"

#include "key_weights.h"
#include "nearest_keys.h"
#include "variety.h"

#include <fresco/numerics/noise.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

namespace fresco::synthesize
{
namespace
{

constexpr std::size_t searched_together = 192;
constexpr std::size_t sampled_queries = 6000;  // That say how well each key is served.
/// A place that continues a neighbor's may differ by this much more than the best one: (d + tolerance) * factor.
constexpr float coherence_factor = 2;
constexpr float coherence_tolerance = 15;  // L*a*b*² per value
/// A place so far beyond the picture's border does not continue a neighbor's: moved inside, it would only repeat it.
constexpr float beyond_border = 2;  // pixels
/// Of strokes that run across the direction that they should have.
constexpr float misalignment_cost = 600;  // L*a*b*² per value

class Search
{
  public:
    Search(const Patches& patches, const SurfaceGrid& grid, std::span<const Vec3f> wanted, const PictureLevel& picture,
           const SearchOptions& options, const Progress& progress)
        : patches_(patches), grid_(grid), wanted_(wanted), picture_(picture), progress_(progress),
          variety_(patches, grid, picture, options.stroke_px, options.variety, options.seed, progress),
          lift_(static_cast<float>(options.lift)), seed_(options.seed), values_(picture.values_per_patch())
    {
    }

    std::vector<Match> run(double completeness, std::span<const float> crowding)
    {
        weights_ = completeness_weights(picture_, sampled_features(), completeness, progress_);
        // An average key counts 1, so that preferences are worth what SearchOptions::variety says.
        const double mean = std::accumulate(weights_.begin(), weights_.end(), 0.0) / static_cast<double>(weights_.size());
        for (float& weight : weights_)
            weight = static_cast<float>(static_cast<double>(weight) / mean);
        std::transform(weights_.begin(), weights_.end(), crowding.begin(), weights_.begin(), std::multiplies<>());
        // On a plain wall all patches find one place, and by continuing each other they would only repeat it side by side: so
        // leaders are continued first.
        const std::vector<char> all(patches_.count(), 1);
        return continued(continued(continued(best_keys(), leaders()), all), all);
    }

  private:
    template <class Work>
    void in_pieces(std::size_t count, const Work& work) const
    {
        parallel_for(count, searched_together, progress_.threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         progress_.check_canceled();
                         work(begin, end);
                     });
    }

    void sample(std::size_t patch, std::vector<Vec3f>& out, std::size_t place) const
    {
        patches_.sample(grid_, wanted_, patch, &out[place * (values_ / 3)]);
    }
    const float* values(const std::vector<Vec3f>& samples, std::size_t place) const { return &samples[place * (values_ / 3)].x; }

    /// Of patches that are evenly spread.
    std::vector<float> sampled_features() const
    {
        const std::size_t count = std::min(patches_.count(), sampled_queries);
        std::vector<float> features(count * picture_.feature_count());
        in_pieces(count,
                  [&](std::size_t begin, std::size_t end)
                  {
                      std::vector<Vec3f> samples((end - begin) * values_ / 3);
                      for (std::size_t i = begin; i < end; ++i)
                          sample(i * patches_.count() / count, samples, i - begin);
                      picture_.project(values(samples, 0), end - begin, &features[begin * picture_.feature_count()]);
                  });
        return features;
    }

    std::vector<Match> best_keys() const
    {
        const FeatureSizes sizes{picture_.feature_count(), Variety::fields};
        // Preferences are means over a patch's values, distances are sums.
        const auto scale = static_cast<float>(values_);
        const auto joined = [&](const float* squared, const float* plain, float factor, float* out)
        {
            std::copy_n(squared, sizes.squared, out);
            std::transform(plain, plain + sizes.plain, out + sizes.squared, [factor](float v) { return factor * v; });
        };
        std::vector<float> key_features(picture_.key_count() * sizes.all());
        for (std::size_t k = 0; k < picture_.key_count(); ++k)
            joined(&picture_.key_features()[k * sizes.squared], variety_.of_key(k), 1, &key_features[k * sizes.all()]);
        const NearestKeys keys(key_features, sizes, weights_, lift_ * scale, patch_kernel());

        std::vector<Match> matches(patches_.count());
        in_pieces(matches.size(),
                  [&](std::size_t begin, std::size_t end)
                  {
                      std::vector<Vec3f> samples((end - begin) * values_ / 3);
                      std::vector<float> projected((end - begin) * sizes.squared);
                      std::vector<float> features((end - begin) * sizes.all());
                      std::vector<Nearest> nearest(end - begin);
                      for (std::size_t i = begin; i < end; ++i)
                          sample(i, samples, i - begin);
                      picture_.project(values(samples, 0), end - begin, projected.data());
                      for (std::size_t i = begin; i < end; ++i)
                          joined(&projected[(i - begin) * sizes.squared], variety_.of_patch(i), scale,
                                 &features[(i - begin) * sizes.all()]);
                      keys.find(features.data(), end - begin, nearest.data());
                      for (std::size_t i = begin; i < end; ++i)
                          matches[i] = refined(values(samples, i - begin), picture_.key(nearest[i - begin].key));
                  });
        return matches;
    }

    float distance(const float* patch, Vec2f at, Vec2f turn) const
    {
        if (picture_.is_directed())
            return turned_distance(patch, at, turn);
        const int x = static_cast<int>(std::lround(at.x));
        const int y = static_cast<int>(std::lround(at.y));
        const auto side = static_cast<std::size_t>(picture_.side());
        const float sum = patch_kernel().squared_distance(patch, picture_.patch(x, y),
                                                          3 * static_cast<std::size_t>(picture_.lab().width), side, 3 * side);
        return sum / static_cast<float>(values_);
    }

    float turned_distance(const float* patch, Vec2f at, Vec2f turn) const
    {
        thread_local std::vector<float> found;
        found.resize(values_);
        picture_.turned_patch(at, turn, found.data());
        const auto side = static_cast<std::size_t>(picture_.side());
        return patch_kernel().squared_distance(patch, found.data(), 3 * side, side, 3 * side) / static_cast<float>(values_);
    }

    float score(std::size_t patch, float distance, Vec2f at, Vec2f turn) const
    {
        const std::size_t key = picture_.key_near(at);
        const float cost = weights_[key] * (distance + lift_) + variety_.preference(patch, key);
        return picture_.is_directed() ? cost + misalignment_cost * picture_.misalignment(at, turn) : cost;
    }

    /// The best whole position between a key and the next ones.
    Match refined(const float* patch, Vec2f key) const
    {
        const Vec2f turn = picture_.is_directed() ? picture_.direction(key).along : Vec2f{1, 0};
        Match best{key, distance(patch, key, turn), turn};
        const int reach = picture_.key_reach();
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x)
            {
                const Vec2f at = picture_.inside(key + Vec2f{static_cast<float>(x), static_cast<float>(y)});
                if (const float away = distance(patch, at, turn); away < best.distance)
                    best = {at, away, turn};
            }
        return best;
    }

    /// Patches that come first, in a random order, of those over their center.
    std::vector<char> leaders() const
    {
        const auto order = [this](std::uint32_t patch) { return std::pair(noise::hash(seed_, patch), patch); };
        std::vector<char> result(patches_.count(), 1);
        for (std::uint32_t i = 0; i < result.size(); ++i)
            for (const Cover& cover : patches_.covers(patches_[i].texel))
                if (order(cover.patch) < order(i))
                    result[i] = 0;
        return result;
    }

    /// Every patch tries the places that continue those of the `sources` over its center.
    std::vector<Match> continued(const std::vector<Match>& matches, const std::vector<char>& sources) const
    {
        std::vector<Match> result(matches.size());
        in_pieces(matches.size(),
                  [&](std::size_t begin, std::size_t end)
                  {
                      std::vector<Vec3f> samples(values_ / 3);
                      for (std::size_t i = begin; i < end; ++i)
                      {
                          sample(i, samples, 0);
                          result[i] = continued(values(samples, 0), i, matches, sources);
                      }
                  });
        return result;
    }

    Match continued(const float* patch_values, std::size_t patch, const std::vector<Match>& matches,
                    const std::vector<char>& sources) const
    {
        Match best = matches[patch];
        float least = score(patch, (best.distance + coherence_tolerance + lift_) * coherence_factor - lift_, best.at, best.turn);
        for (const Cover& cover : patches_.covers(patches_[patch].texel))
        {
            if (cover.patch == patch || sources[cover.patch] == 0)
                continue;
            const Match& source = matches[cover.patch];
            const Vec2f beyond = source.place(cover.offset());
            const Vec2f at = picture_.inside(beyond);
            if (length(at - beyond) >= beyond_border)
                continue;
            const Vec2f turn = picture_.is_directed() ? turned(axis_in(cover.patch, patch), source.turn) : source.turn;
            const float away = distance(patch_values, at, turn);
            if (const float found = score(patch, away, at, turn); found < least)
            {
                least = found;
                best = {at, away, turn};
            }
        }
        return best;
    }

    /// Which way a patch's x axis runs in the plane of another, unit length.
    Vec2f axis_in(std::size_t other, std::size_t patch) const
    {
        const TangentFrame& frame = patches_[other].frame;
        const Vec3f right = patches_[patch].frame.right;
        const Vec2f axis{dot(right, frame.right), dot(right, frame.down)};
        const float size = length(axis);
        return size > 0 ? axis * (1 / size) : Vec2f{1, 0};
    }

    const Patches& patches_;
    const SurfaceGrid& grid_;
    std::span<const Vec3f> wanted_;
    const PictureLevel& picture_;
    const Progress& progress_;
    Variety variety_;
    float lift_;
    std::uint32_t seed_;
    std::size_t values_;
    std::vector<float> weights_;
};

}  // namespace

std::vector<Match> search(const Patches& patches, const SurfaceGrid& grid, std::span<const Vec3f> wanted,
                          const PictureLevel& picture, const SearchOptions& options, std::span<const float> crowding,
                          const Progress& progress)
{
    return Search(patches, grid, wanted, picture, options, progress).run(options.completeness, crowding);
}

}  // namespace fresco::synthesize
