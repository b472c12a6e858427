#include "search.h"

#include "nearby_uses.h"

#include <fresco/numerics/noise.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

namespace fresco::synthesize
{
namespace
{

/// Panels that stay in the second-level cache while queries pass by.
constexpr std::size_t block_bytes = std::size_t{384} << 10U;
constexpr float never = 1e30F;

}  // namespace

const PatchKernel& patch_kernel()
{
    static const PatchKernel& kernel = fastest_of(avx512_kernel(), avx2_kernel(), base_kernel());
    return kernel;
}

NearestKeys::NearestKeys(std::span<const float> features, const FeatureSizes& sizes, std::span<const float> weights, float lift,
                         const PatchKernel& kernel)
    : kernel_(kernel), sizes_(sizes), panels_((weights.size() + kernel.columns - 1) / kernel.columns)
{
    const std::size_t columns = kernel.columns;
    const std::size_t size = sizes.all();
    values_.assign(panels_ * (size + 2) * columns, 0.0F);
    for (std::size_t key = 0; key < panels_ * columns; ++key)
    {
        float* column = &values_[key / columns * (size + 2) * columns + key % columns];
        if (key >= weights.size())
        {
            column[(size + 1) * columns] = never;
            continue;
        }
        const float weight = weights[key];
        float norm = 0;
        for (std::size_t f = 0; f < size; ++f)
        {
            const float value = features[key * size + f];
            const bool is_squared = f < sizes.squared;
            norm += is_squared ? value * value : 0;
            column[f * columns] = is_squared ? -2 * weight * value : value;
        }
        column[size * columns] = weight;
        column[(size + 1) * columns] = weight * (norm + lift);
    }
}

void NearestKeys::find(const float* queries, std::size_t count, Nearest* out, std::span<const float> unavoidable) const
{
    const std::size_t rows = kernel_.rows;
    const std::size_t columns = kernel_.columns;
    const std::size_t size = sizes_.all();
    const std::size_t inner = size + 2;
    const std::size_t groups = (count + rows - 1) / rows;
    std::vector<float> augmented(groups * rows * inner, 0.0F);
    for (std::size_t q = 0; q < count; ++q)
    {
        float* row = &augmented[q * inner];
        std::copy_n(queries + q * size, size, row);
        float norm = 0;
        for (std::size_t f = 0; f < sizes_.squared; ++f)
            norm += row[f] * row[f];
        row[size] = norm - (unavoidable.empty() ? 0 : unavoidable[q]);
        row[size + 1] = 1;
    }
    std::vector<float> least(groups * rows * columns, std::numeric_limits<float>::infinity());
    std::vector<std::int32_t> where(least.size(), 0);
    const std::size_t panel_values = inner * columns;
    const std::size_t panels_per_block = std::max<std::size_t>(1, block_bytes / (panel_values * sizeof(float)));
    for (std::size_t block = 0; block < panels_; block += panels_per_block)
        for (std::size_t group = 0; group < groups; ++group)
            for (std::size_t panel = block; panel < std::min(block + panels_per_block, panels_); ++panel)
                kernel_.compare(&augmented[group * rows * inner], &values_[panel * panel_values], inner,
                                static_cast<std::int32_t>(panel), &least[group * rows * columns], &where[group * rows * columns]);
    for (std::size_t q = 0; q < count; ++q)
    {
        Nearest best{std::numeric_limits<std::uint32_t>::max(), std::numeric_limits<float>::infinity()};
        for (std::size_t c = 0; c < columns; ++c)
        {
            const float score = least[q * columns + c];
            const auto key = static_cast<std::uint32_t>(static_cast<std::size_t>(where[q * columns + c]) * columns + c);
            if (score < best.score || (score == best.score && key < best.key))
                best = {key, score};
        }
        out[q] = best;
    }
}

namespace
{

constexpr double strokes_per_wave = 2.75;       // Over this length preferences change on the surface …
constexpr double picture_strokes_per_wave = 2;  // … and in the picture.
constexpr float deviation = 0.19F;              // Deviation of the product of two sums of Variety::fields fields.
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

Variety::Variety(const Patches& patches, const SurfaceGrid& grid, const StylePicture& picture, double stroke_px, double amount,
                 std::uint32_t seed, const Progress& progress)
    : of_patch_(patches.count() * fields), of_key_(picture.key_count() * fields)
{
    const auto waves = static_cast<float>(1 / (strokes_per_wave * stroke_px * grid.spacing_m()));
    const auto scale = static_cast<float>(amount) / deviation;
    const auto salt = [seed](std::size_t field) { return noise::hash(seed, static_cast<std::uint32_t>(field)); };
    parallel_items(patches.count(), 4096, progress,
                   [&](std::size_t i)
                   {
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

namespace
{

constexpr std::size_t keys_per_piece = 192;
constexpr double window_share = 0.01;  // Share of the picture's area.
constexpr double fair_use = 3;         // Times the mean.
constexpr double crowd_step = 0.5;     // Change of a factor in a round, as a power.

/// The weight of each key's distances: 1 / (α + the least distance of any of `queries`), so that parts of the picture that no
/// query resembles are used, too (completeness; Granot et al. 2022). `queries`: n x feature_count().
std::vector<float> completeness_weights(const StylePicture& picture, std::span<const float> queries, double alpha,
                                        const Progress& progress)
{
    const std::size_t size = picture.feature_count();
    const std::vector<float> alike(queries.size() / size, 1.0F);
    const NearestKeys nearest_queries(queries, {size, 0}, alike, 0, patch_kernel());
    const auto least = static_cast<float>(alpha * static_cast<double>(picture.values_per_patch()));
    std::vector<float> weights(picture.key_count());
    parallel_for(weights.size(), keys_per_piece, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     std::vector<Nearest> nearest(end - begin);
                     nearest_queries.find(&picture.key_features()[begin * size], end - begin, nearest.data());
                     for (std::size_t i = begin; i < end; ++i)
                         weights[i] = 1 / (least + std::max(nearest[i - begin].score, 0.0F));
                 });
    return weights;
}

}  // namespace

void update_crowding(const StylePicture& picture, std::span<const Match> matches, std::vector<float>& crowding)
{
    const int width = picture.lab().width;
    const int height = picture.lab().height;
    Raster<std::uint32_t> sums(width + 1, height + 1);  // Matches above and to the left.
    for (const Match& match : matches)
        ++sums.at(static_cast<int>(match.at.x) + 1, static_cast<int>(match.at.y) + 1);
    for (int y = 1; y <= height; ++y)
        for (int x = 1; x <= width; ++x)
            sums.at(x, y) += sums.at(x - 1, y) + sums.at(x, y - 1) - sums.at(x - 1, y - 1);
    const double area = picture.opaque_count(0, 0, width, height);
    const int half = std::max(1, static_cast<int>(std::lround(std::sqrt(window_share * area) / 2)));
    for (std::size_t key = 0; key < crowding.size(); ++key)
    {
        const Vec2f at = picture.key(key);
        const int x0 = std::max(0, static_cast<int>(at.x) - half);
        const int x1 = std::min(width, static_cast<int>(at.x) + half);
        const int y0 = std::max(0, static_cast<int>(at.y) - half);
        const int y1 = std::min(height, static_cast<int>(at.y) + half);
        const double count = sums.at(x1, y1) + sums.at(x0, y0) - sums.at(x0, y1) - sums.at(x1, y0);
        const double use = count / static_cast<double>(matches.size()) * area / picture.opaque_count(x0, y0, x1, y1);
        crowding[key] = std::max(1.0F, crowding[key] * static_cast<float>(std::pow(use / fair_use, crowd_step)));
    }
}

namespace
{

/// This share of the distance of the nearest of every eighth key does not count. With all of it, plain walls would get no
/// strokes.
constexpr float unavoidable_share = 0.5F;
constexpr std::size_t unavoidable_step = 8;  // One of as many keys, at random: they lie in rows.

constexpr std::size_t searched_together = 192;
constexpr std::size_t continued_together = 1024;  // Every piece counts the uses around its first patch from scratch.
constexpr std::size_t sampled_queries = 6000;     // Patches that are searched to see how well each key is served.
/// A place that continues a neighbor's may differ by this much more than the best one: (d + tolerance) * factor.
constexpr float coherence_factor = 2;
constexpr float coherence_tolerance = 15;  // L*a*b*² per value
/// A place so far beyond the picture's border does not continue a neighbor's: moved inside, it would only repeat it.
constexpr float beyond_border = 2;  // pixels
/// Each key belongs to a class, one of two strokes' square in the picture: the best keys of all classes are in different places.
constexpr std::size_t classes_count = 8;
constexpr double class_strokes = 2;
constexpr std::uint32_t turns = 3;
/// Cost of strokes that run across the wanted direction.
constexpr float misalignment_cost = 600;  // L*a*b*² per value

class Search
{
  public:
    Search(const Patches& patches, const SurfaceGrid& grid, std::span<const Vec3f> wanted, const StylePicture& picture,
           const NearbyUses& uses, const SearchOptions& options, std::span<const Match> before, const Progress& progress)
        : patches_(patches), grid_(grid), wanted_(wanted), picture_(picture), before_(before), progress_(progress),
          variety_(patches, grid, picture, options.stroke_px, options.variety, options.seed, progress), uses_(uses),
          options_(options), values_(picture.values_per_patch()), some_keys_(some_keys(picture))
    {
    }

    std::vector<Match> run(Round round, std::span<const float> crowding)
    {
        weights_ = completeness_weights(picture_, sampled_features(), options_.completeness, progress_);
        // An average key counts 1, so that preferences are worth what SearchOptions::variety says.
        const double mean = std::accumulate(weights_.begin(), weights_.end(), 0.0) / static_cast<double>(weights_.size());
        for (float& weight : weights_)
            weight = static_cast<float>(static_cast<double>(weight) / mean);
        std::transform(weights_.begin(), weights_.end(), crowding.begin(), weights_.begin(), std::multiplies<>());
        looks_ = std::make_unique_for_overwrite<std::int16_t[]>(patches_.count() * values_);
        means_.resize(patches_.count());
        unavoidable_.resize(patches_.count());
        // On a plain wall all patches find one place, and by continuing each other they would only repeat it side by side: so
        // leaders are continued first.
        const std::vector<char> all(patches_.count(), 1);
        return continued(continued(continued(round == Round::refines ? kept() : best_keys(), leaders()), all), all);
    }

  private:
    template <class Work>
    void in_pieces(std::size_t count, const Work& work, std::size_t together = searched_together) const
    {
        parallel_for(count, together, progress_,
                     [&](std::size_t begin, std::size_t end)
                     {
                         progress_.check_canceled();
                         work(begin, end);
                     });
    }

    /// The patches that are next to each other follow each other.
    std::span<const std::uint32_t> ordered(std::size_t begin, std::size_t end) const
    {
        return std::span(uses_.order()).subspan(begin, end - begin);
    }

    void sample(std::size_t patch, std::vector<Vec3f>& out, std::size_t place) const
    {
        patches_.sample(grid_, wanted_, patch, &out[place * (values_ / 3)]);
    }
    const float* values(const std::vector<Vec3f>& samples, std::size_t place) const { return &samples[place * (values_ / 3)].x; }

    /// A patch of the surface, as it is wanted.
    struct Look
    {
        const std::int16_t* values;  ///< In steps.
        Vec3f mean;
    };
    Look look(std::size_t patch) const { return {&looks_[patch * values_], means_[patch]}; }
    /// Keeps what patches look like, and which distance is unavoidable. Returns their features.
    std::vector<float> keep_looks(std::span<const std::uint32_t> patches)
    {
        const std::size_t size = picture_.feature_count();
        std::vector<Vec3f> samples(patches.size() * values_ / 3);
        for (std::size_t i = 0; i < patches.size(); ++i)
        {
            sample(patches[i], samples, i);
            const float* sampled = values(samples, i);
            std::transform(sampled, sampled + values_, &looks_[patches[i] * values_], in_steps);
            means_[patches[i]] = mean_color(sampled, values_);
        }
        std::vector<float> features(patches.size() * size);
        picture_.project(values(samples, 0), patches.size(), features.data());
        std::vector<Nearest> nearest(patches.size());
        some_keys_.find(features.data(), patches.size(), nearest.data());
        for (std::size_t i = 0; i < patches.size(); ++i)
            unavoidable_[patches[i]] = unavoidable_share * std::max(0.0F, nearest[i].score) / static_cast<float>(values_);
        return features;
    }
    /// One of every eight keys, all alike.
    static NearestKeys some_keys(const StylePicture& picture)
    {
        const std::size_t size = picture.feature_count();
        std::vector<float> features;
        for (std::size_t k = 0; k < picture.key_count(); ++k)
            if (k == 0 ||
                noise::hash(static_cast<std::uint32_t>(k / unavoidable_step)) % unavoidable_step == k % unavoidable_step)
                features.insert(features.end(), &picture.key_features()[k * size], &picture.key_features()[k * size] + size);
        return {features, {size, 0}, std::vector<float>(features.size() / size, 1.0F), 0, patch_kernel()};
    }

    /// Features of evenly spread patches.
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

    struct KeyClass
    {
        std::vector<std::size_t> keys;
        std::vector<float> weights;
        std::vector<float> features;
    };

    /// The matches of the last round. Keeps what every patch looks like.
    std::vector<Match> kept()
    {
        std::vector<Match> matches(before_.begin(), before_.end());
        in_pieces(matches.size(),
                  [&](std::size_t begin, std::size_t end)
                  {
                      keep_looks(ordered(begin, end));
                      for (const std::uint32_t patch : ordered(begin, end))
                          matches[patch].distance = distance(look(patch), matches[patch].at, matches[patch].turn);
                  });
        return matches;
    }

    /// A patch's best key of a class, and what it costs without the price of what is seen nearby.
    struct Candidate
    {
        std::uint32_t key = 0;
        float cost = std::numeric_limits<float>::infinity();
    };
    using Candidates = std::array<Candidate, classes_count>;

    /// Keeps what every patch looks like.
    std::vector<Candidates> candidates()
    {
        const FeatureSizes sizes{picture_.feature_count(), Variety::fields};
        // Preferences are means over a patch's values, distances are sums.
        const auto scale = static_cast<float>(values_);
        const auto joined = [&](const float* squared, const float* plain, float factor, float* out)
        {
            std::copy_n(squared, sizes.squared, out);
            std::transform(plain, plain + sizes.plain, out + sizes.squared, [factor](float v) { return factor * v; });
        };
        std::vector<KeyClass> classes(classes_count);
        for (std::size_t k = 0; k < picture_.key_count(); ++k)
        {
            const auto square = [&](float v)
            { return static_cast<std::uint32_t>(static_cast<double>(v) / (class_strokes * options_.stroke_px)); };
            KeyClass& of = classes[noise::hash(square(picture_.key(k).x), square(picture_.key(k).y)) % classes_count];
            of.keys.push_back(k);
            of.weights.push_back(weights_[k]);
            of.features.resize(of.features.size() + sizes.all());
            joined(&picture_.key_features()[k * sizes.squared], variety_.of_key(k), 1,
                   of.features.data() + of.features.size() - sizes.all());
        }
        std::erase_if(classes, [](const KeyClass& of) { return of.keys.empty(); });
        std::vector<NearestKeys> nearest_keys;
        nearest_keys.reserve(classes.size());
        for (KeyClass& of : classes)
            nearest_keys.emplace_back(std::exchange(of.features, {}), sizes, of.weights, options_.lift * scale, patch_kernel());

        std::vector<Candidates> result(patches_.count());
        in_pieces(result.size(),
                  [&](std::size_t begin, std::size_t end)
                  {
                      const std::size_t count = end - begin;
                      const auto patches = ordered(begin, end);
                      const std::vector<float> projected = keep_looks(patches);
                      std::vector<float> features(count * sizes.all());
                      std::vector<float> unavoidable(count);
                      for (std::size_t i = 0; i < count; ++i)
                      {
                          unavoidable[i] = unavoidable_[patches[i]] * scale;
                          joined(&projected[i * sizes.squared], variety_.of_patch(patches[i]), scale, &features[i * sizes.all()]);
                      }
                      std::vector<Nearest> nearest(count);
                      for (std::size_t c = 0; c < classes.size(); ++c)
                      {
                          nearest_keys[c].find(features.data(), count, nearest.data(), unavoidable);
                          for (std::size_t i = 0; i < count; ++i)
                          {
                              const std::size_t key = classes[c].keys[nearest[i].key];
                              const Vec2f at = picture_.key(key);
                              const Vec2f turn = turn_of(at);
                              const float away = counted(patches[i], distance(look(patches[i]), at, turn));
                              result[patches[i]][c] = {static_cast<std::uint32_t>(key), score(patches[i], away, at, turn)};
                          }
                      }
                  });
        return result;
    }

    /// Gives the patches whose turn it is the candidates that cost least where `matches` are what the surface shows. Without
    /// matches, nothing is shown, and it is everyone's turn.
    void choose(const std::vector<Candidates>& candidates, std::uint32_t turn, std::vector<Match>& matches) const
    {
        const std::vector<Match> seen = matches;
        matches.resize(candidates.size());
        const NearbyUses::Placed placed = uses_.placed(seen);
        in_pieces(matches.size(),
                  [&](std::size_t begin, std::size_t end)
                  {
                      NearbyUses::Map uses(uses_, placed);
                      for (const std::uint32_t patch : ordered(begin, end))
                      {
                          if (!seen.empty() && noise::hash(options_.seed + 1, patch) % turns != turn)
                              continue;
                          uses.move_to(patch);
                          Candidate best;
                          for (Candidate candidate : candidates[patch])
                          {
                              if (candidate.cost > best.cost)
                                  continue;
                              candidate.cost += repeating(uses, patch, candidate.key, picture_.key(candidate.key));
                              if (candidate.cost < best.cost || (candidate.cost == best.cost && candidate.key < best.key))
                                  best = candidate;
                          }
                          const Vec2f at = picture_.key(best.key);
                          matches[patch] = {.at = at, .turn = turn_of(at)};
                      }
                  });
    }

    /// Patches take turns, at random, and know what the others show: if all of a plain surface chose at once, all would leave
    /// what the others show for the same next place, and show that as bricks.
    std::vector<Match> best_keys()
    {
        const std::vector<Candidates> all = candidates();
        std::vector<Match> matches(before_.begin(), before_.end());
        if (matches.empty())
            choose(all, 0, matches);
        for (std::uint32_t turn = 0; turn < turns; ++turn)
            choose(all, turn, matches);
        in_pieces(matches.size(),
                  [&](std::size_t begin, std::size_t end)
                  {
                      for (const std::uint32_t patch : ordered(begin, end))
                          matches[patch] = refined(look(patch), matches[patch].at);
                  });
        return matches;
    }

    /// Cost of other copies of a place nearby: one is as bad as many, so that the fit still decides where
    /// there is no other place.
    float repeating(const NearbyUses::Map& uses, std::size_t patch, std::size_t key, Vec2f at) const
    {
        const NearbyUses::Copies copies = uses.copies(patch, at);
        const float motif = uses_.motif(key);
        return options_.repeat_cost * motif * std::min(copies.around, 1.0F) +
               options_.weave_cost * (1 - motif) * std::min(copies.beside, 1.0F);
    }

    /// Turn of a patch with its center at a key.
    Vec2f turn_of(Vec2f key) const { return picture_.is_directed() ? picture_.direction(key) : Vec2f{1, 0}; }

    /// Colors of the picture around a place.
    struct Copy
    {
        const std::int16_t* values;  ///< In steps; valid until the thread's next copy.
        std::size_t row;             ///< From one row of the patch to the next.
        Vec3f mean;
    };
    Copy copy(Vec2f at, Vec2f turn) const
    {
        if (!picture_.is_directed())
        {
            const int x = static_cast<int>(at.x + 0.5F);  // NOLINT(bugprone-incorrect-roundings): std::lround is slower.
            const int y = static_cast<int>(at.y + 0.5F);  // NOLINT(bugprone-incorrect-roundings)
            return {picture_.patch(x, y), 3 * static_cast<std::size_t>(picture_.lab().width), picture_.patch_mean(x, y)};
        }
        thread_local std::vector<float> found;
        thread_local std::vector<std::int16_t> steps;
        found.resize(values_);
        steps.resize(values_);
        picture_.turned_patch(at, turn, found.data());
        std::ranges::transform(found, steps.begin(), in_steps);
        return {steps.data(), 3 * static_cast<std::size_t>(picture_.side()), mean_color(found.data(), values_)};
    }

    /// Mean squared difference of a value, with the shift that the copy gets.
    float distance(const Look& patch, Vec2f at, Vec2f turn) const
    {
        const auto side = static_cast<std::size_t>(picture_.side());
        const Copy found = copy(at, turn);
        const float sum = patch_kernel().squared_distance(patch.values, found.values, found.row, side, 3 * side) /
                          (steps_per_lab * steps_per_lab);
        const Vec3f gap = patch.mean - found.mean;
        return std::max(0.0F, sum / static_cast<float>(values_) + (squared_gap(gap) - dot(gap, gap)) / 3);
    }

    /// Without what is unavoidable. Rounds often find better places than the keys that tell it.
    float counted(std::size_t patch, float distance) const { return std::max(0.0F, distance - unavoidable_[patch]); }

    /// The cost of a counted distance, without the price of what is seen nearby.
    float score(std::size_t patch, float distance, Vec2f at, Vec2f turn) const
    {
        const std::size_t key = picture_.key_near(at);
        const float cost = weights_[key] * (distance + options_.lift) + variety_.preference(patch, key);
        return picture_.is_directed() ? cost + misalignment_cost * picture_.misalignment(at, turn) : cost;
    }

    /// The best whole position between a key and the next ones.
    Match refined(const Look& patch, Vec2f key) const
    {
        const Vec2f turn = turn_of(key);
        Match best{.at = key, .distance = distance(patch, key, turn), .turn = turn};
        const int reach = picture_.key_reach();
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x)
            {
                const Vec2f at = picture_.inside(key + Vec2f{static_cast<float>(x), static_cast<float>(y)});
                if (!picture_.has_patch(at))
                    continue;
                if (const float away = distance(patch, at, turn); away < best.distance)
                    best = {.at = at, .distance = away, .turn = turn};
            }
        return best;
    }

    /// Patches that come first, in a random order, of those over their center.
    std::vector<char> leaders() const
    {
        const auto order = [this](std::uint32_t patch) { return std::pair(noise::hash(options_.seed, patch), patch); };
        std::vector<char> result(patches_.count(), 1);
        for (std::uint32_t i = 0; i < result.size(); ++i)
            for (const std::uint32_t other : patches_.covers(patches_[i].texel))
                if (order(other) < order(i))
                    result[i] = 0;
        return result;
    }

    /// Every patch tries the places that continue those of the `sources` over its center.
    std::vector<Match> continued(const std::vector<Match>& matches, const std::vector<char>& sources) const
    {
        std::vector<Match> result(matches.size());
        const NearbyUses::Placed placed = uses_.placed(matches);
        in_pieces(
            matches.size(),
            [&](std::size_t begin, std::size_t end)
            {
                NearbyUses::Map uses(uses_, placed);
                for (const std::uint32_t patch : ordered(begin, end))
                {
                    uses.move_to(patch);
                    const Look wanted = look(patch);
                    result[patch] = continued(wanted, patch, matches, sources, uses);
                    result[patch].shift = shift_for(wanted.mean - copy(result[patch].at, result[patch].turn).mean);
                }
            },
            continued_together);
        return result;
    }

    Match continued(const Look& wanted, std::size_t patch, const std::vector<Match>& matches, const std::vector<char>& sources,
                    const NearbyUses::Map& uses) const
    {
        Match best = matches[patch];
        float least =
            score(patch, (counted(patch, best.distance) + coherence_tolerance + options_.lift) * coherence_factor - options_.lift,
                  best.at, best.turn) +
            repeating(uses, patch, picture_.key_near(best.at), best.at);
        for (const std::uint32_t other : patches_.covers(patches_[patch].texel))
        {
            if (other == patch || sources[other] == 0)
                continue;
            const Match& source = matches[other];
            const Vec2f beyond = source.place(patches_.offset(other, patches_[patch].center));
            const Vec2f at = picture_.inside(beyond);
            if (length(at - beyond) >= beyond_border || !picture_.has_patch(at))
                continue;
            const Vec2f turn = picture_.is_directed() ? turned(axis_in(other, patch), source.turn) : source.turn;
            const float away = distance(wanted, at, turn);
            // Prices are at least 0, and mostly not needed.
            const float unpriced = score(patch, counted(patch, away), at, turn);
            if (unpriced >= least)
                continue;
            if (const float found = unpriced + repeating(uses, patch, picture_.key_near(at), at); found < least)
            {
                least = found;
                best = {.at = at, .distance = away, .turn = turn};
            }
        }
        return best;
    }

    /// Direction of a patch's x axis in the plane of another, unit length.
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
    const StylePicture& picture_;
    std::span<const Match> before_;
    const Progress& progress_;
    Variety variety_;
    const NearbyUses& uses_;
    const SearchOptions& options_;
    std::size_t values_;
    std::vector<float> weights_;
    std::unique_ptr<std::int16_t[]> looks_;
    std::vector<Vec3f> means_;
    NearestKeys some_keys_;
    std::vector<float> unavoidable_;  ///< Per patch, a part of all distances that does not count.
};

}  // namespace

std::vector<Match> search(const Patches& patches, const SurfaceGrid& grid, std::span<const Vec3f> wanted,
                          const StylePicture& picture, const NearbyUses& uses, const SearchOptions& options, Round round,
                          std::span<const Match> before, std::span<const float> crowding, const Progress& progress)
{
    return Search(patches, grid, wanted, picture, uses, options, before, progress).run(round, crowding);
}

}  // namespace fresco::synthesize
