#include "synthesis.h"

#include "checkpoint.h"
#include "stroke_limits.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/images/stroke_width.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <string>

namespace fresco::synthesize
{
namespace
{

constexpr double stroke_texels = 8;   // In the finest level.
constexpr double finest_texel = 0.6;  // Levels with texels smaller than this share of the texture's are left out.
constexpr int coarse_stride = 3;
constexpr int fine_stride = 4;
constexpr int preview_px = 512;

class Synthesis
{
  public:
    Synthesis(const Task& task, const SynthesisOptions& options, const ImageIo* images, RunContext& run)
        : task_(task), options_(options), images_(images), run_(run), stroke_px_(stroke_width_px(task.picture, run)),
          texel_m_(mean_texel_m(task.surface.mesh, options.size_px)), file_(run.checkpoint_folder() / "round.bin")
    {
    }

    Painting make()
    {
        const int finest = finest_level();
        std::unique_ptr<Level> level;
        int number = options_.levels_count - 1;
        if (std::optional<Checkpoint> found = earlier(finest))
        {
            auto next = new_level(found->level);
            if (resume(*next, *found))
            {
                level = std::move(next);
                paint_rounds(*level, found->level, found->rounds, finest);
                number = found->level - 1;
            }
        }
        for (; number >= finest; --number)
        {
            auto next = new_level(number);
            next->begin(level.get(), run_);
            level = std::move(next);
            paint_rounds(*level, number, 0, finest);
        }
        report(*level, finest);
        if (!task_.lines.empty())
            run_.report("direction_error_deg", level->direction_error_deg(run_));
        return paint(task_, *level, options_.size_px, run_);
    }

  private:
    using Clock = std::chrono::steady_clock;

    double spacing_m(int level) const { return options_.stroke_m / stroke_texels * std::exp2(level); }
    double scale(int level) const { return stroke_texels / stroke_px_ / std::exp2(level); }

    int finest_level() const
    {
        int level = options_.levels_count - 1;
        while (level > 0 && spacing_m(level - 1) >= finest_texel * texel_m_)
            --level;
        return level;
    }

    LevelOptions level_options(int level) const
    {
        const double freedom = 2 * options_.painterly;
        return {.side = options_.patch_px,
                .stride = level > 0 ? coarse_stride : fine_stride,
                .faithfulness = 0.5 * std::pow(0.3, options_.painterly),
                .unrest = 10 * freedom,
                .search = {.completeness = options_.completeness,
                           .stroke_px = stroke_texels / std::exp2(level),
                           .variety = 5 * freedom,
                           .lift = 8 * freedom,
                           .seed = options_.seed}};
    }

    std::unique_ptr<Level> new_level(int number) const
    {
        return std::make_unique<Level>(task_, spacing_m(number), scale(number), level_options(number), run_);
    }

    std::optional<Checkpoint> earlier(int finest) const
    {
        try
        {
            auto found = read_checkpoint(file_);
            if (found && (found->level < finest || found->level >= options_.levels_count || found->rounds < 1 ||
                          found->rounds > options_.rounds_count))
                throw Error(file_.string() + ": belongs to another run");
            return found;
        }
        catch (const Error& error)
        {
            run_.warning(std::string("the checkpoint cannot be used: ") + error.what());
            return std::nullopt;
        }
    }

    bool resume(Level& level, Checkpoint& found) const
    {
        try
        {
            level.resume(std::move(found.colors), std::move(found.matches), std::move(found.crowding));
        }
        catch (const Error& error)
        {
            run_.warning("the checkpoint cannot be used: " + file_.string() + ": " + error.what());
            return false;
        }
        run_.message(fmt::format("going on after round {} of an interrupted run", found.rounds));
        return true;
    }

    void paint_rounds(Level& level, int number, int done, int finest)
    {
        const int rounds_in_all = (options_.levels_count - finest) * options_.rounds_count;
        for (int round = done; round < options_.rounds_count; ++round)
        {
            run_.progress((options_.levels_count - 1 - number) * options_.rounds_count + round, rounds_in_all, "rounds");
            level.paint_round(run_);
            double sum = 0;
            for (const Match& match : level.matches())
                sum += static_cast<double>(match.distance);
            run_.metric("distance", sum / static_cast<double>(level.matches().size()));
            const auto now = Clock::now();
            const auto since = [now](Clock::time_point then) { return std::chrono::duration<double>(now - then).count(); };
            if (options_.checkpoint_seconds > 0 && since(saved_) >= options_.checkpoint_seconds)
            {
                write_checkpoint(file_, {number, round + 1, level.colors(), level.matches(), level.crowding()});
                saved_ = Clock::now();
            }
            if (images_ != nullptr && since(shown_) >= options_.preview_seconds)
            {
                show(level);
                shown_ = Clock::now();
            }
        }
    }

    void show(const Level& level) const
    {
        const Painting small = paint(task_, level, std::min(preview_px, options_.size_px), run_);
        const RasterF& layer = small.texture.layers.front();
        Raster8 picture(layer.width, layer.height, 3);
        std::transform(layer.values.begin(), layer.values.end(), picture.values.begin(),
                       [](float v) { return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0F, 1.0F) * 255)); });
        write_file(run_.preview_folder() / "texture.png", images_->encode_png(picture));
    }

    void report(const Level& level, int finest) const
    {
        const double pixel_cm = 100 * options_.stroke_m / stroke_px_;
        run_.report("stroke_px", stroke_px_);
        run_.report("picture_width_cm", pixel_cm * task_.picture.width);
        run_.report("picture_height_cm", pixel_cm * task_.picture.height);
        run_.report("texel_mm", 1000 * texel_m_);
        run_.report("searched_texel_mm", 1000 * spacing_m(finest));
        run_.report("searched_texels", level.grid().texels().size());
        run_.report("patches", level.patches().count());
        run_.report("keys", level.picture().key_count());
    }

    const Task& task_;
    const SynthesisOptions& options_;
    const ImageIo* images_;
    RunContext& run_;
    double stroke_px_;
    double texel_m_;
    std::filesystem::path file_;
    Clock::time_point saved_ = Clock::now();
    Clock::time_point shown_ = Clock::now();
};

}  // namespace

Painting synthesize(const Task& task, const SynthesisOptions& options, const ImageIo* images, RunContext& run)
{
    return Synthesis(task, options, images, run).make();
}

}  // namespace fresco::synthesize
