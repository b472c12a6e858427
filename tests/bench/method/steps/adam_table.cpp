#include "components.h"
#include "forked_case.h"
#include "method_tables.h"
#include "scene.h"

#include <fresco/torch/optimizer_rule.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <algorithm>
#include <array>

namespace bench
{
namespace
{

constexpr int height_px = 256;
constexpr double rate = 0.01;

/// The textbook without leaving any texel out is what the others are compared with.
struct Mode
{
    const char* name;
    const char* mode;
    const char* untouched;
};
constexpr Mode every_texel{"every texel", "dense", "step"};
constexpr std::array modes{every_texel, Mode{"dense", "dense", "skip"}, Mode{"visible", "visible", "skip"}};

/// Values, both moments and step counts of a texture of four layers, megabytes.
double needed_mb(int size_px)
{
    return 4.0 / 3 * size_px * size_px * (3 * 3 * 4 + 4) / 1e6;
}

/// A texture, and the gradient that one view gives.
struct World
{
    Components components;
    std::shared_ptr<fresco::TextureRepresentation> texture;
    fresco::Evaluation evaluation;

    World(int size_px, int threads)
    {
        at::set_num_threads(threads);
        texture = components.make<fresco::TextureRepresentation>(fresco::Value::Map{{"type", "texture.laplacian"}});
        texture->allocate(size_px);
        const auto view = texture->make_view(generated_view(height_px));
        const auto picture = fresco::to_tensor(generated_style(height_px * 4 / 3, height_px)) - 0.5;
        evaluation.gradients = view->gradient(picture);
    }
    std::shared_ptr<fresco::OptimizerRule> rule(const Mode& mode)
    {
        return components.make<fresco::OptimizerRule>(
            fresco::Value::Map{{"type", "optimizer.adam"}, {"mode", mode.mode}, {"untouched", mode.untouched}, {"beta2", 0.99}});
    }
    std::int64_t touched() const
    {
        std::int64_t sum = 0;
        for (const auto& gradient : evaluation.gradients)
            sum += gradient.texels.numel();
        return sum;
    }
};

fresco::Value measured(int size_px, const Mode& mode, int threads, Measure& measure)
{
    World world(size_px, threads);
    const auto rule = world.rule(mode);
    auto& parameters = world.texture->parameters();
    const auto step = [&]
    {
        rule->step(
            parameters, [&] { return world.evaluation; }, rate, 0);
    };
    // Also the first touch of the moments' pages, which is what memory is asked of.
    measure.times(1,
                  [&]
                  {
                      rule->attach(parameters);
                      step();
                  });
    const auto times = measure.times(3, step);
    return fresco::Value::Map{
        {"ms_per_step", 1e3 * times.wall}, {"processor_ms_per_step", 1e3 * times.processor}, {"touched_texels", world.touched()}};
}

/// While one view is looked at, texels out of sight have neither gradient nor moments: all modes do the same.
fresco::Value compared(int size_px, const Mode& mode, int threads)
{
    World every(size_px, threads);
    World other(size_px, threads);
    for (auto* world : {&every, &other})
    {
        const auto rule = world->rule(world == &every ? every_texel : mode);
        auto& parameters = world->texture->parameters();
        rule->attach(parameters);
        for (int i = 0; i < 3; ++i)
            rule->step(
                parameters, [&] { return world->evaluation; }, rate, 0);
    }
    double largest = 0;
    double moved = 0;
    for (std::size_t i = 0; i < every.texture->parameters().size(); ++i)
    {
        const auto& values = every.texture->parameters()[i].values;
        largest = std::max(largest, (values - other.texture->parameters()[i].values).abs().max().item<double>());
        moved = std::max(moved, values.abs().max().item<double>());
    }
    if (!(moved > 0))
        throw fresco::Error("no texel was moved: the comparison says nothing");
    return fresco::Value::Map{{"largest_difference", largest}};
}

}  // namespace

Table adam_table(const MethodSettings& settings)
{
    Table table("adam",
                "optimizer.adam on all texels, on those that a view has moved, and on those that a view of 256 px sees; one "
                "step, four layers",
                {{"size_px", "size px"},
                 {"mode", "mode"},
                 {"touched_texels", "seen texels"},
                 {"ms_per_step", "ms/step"},
                 {"processor_ms_per_step", "cpu ms/step"},
                 {"times_faster", "x every texel (cpu)", 1},
                 {"peak_mb", "peak MB", 0},
                 {"largest_difference", "apart", 7}});
    for (const int size : settings.sizes_px)
    {
        if (1.5 * needed_mb(size) > available_memory_mb())
        {
            table.add(fresco::Value::Map{{"size_px", size}, {"note", "left out: it needs more memory than is free"}});
            continue;
        }
        fresco::Value every;
        for (const auto& mode : modes)
        {
            fresco::Value check;
            if (3 * needed_mb(size) < available_memory_mb())
                check = run_case([&](Measure&) { return compared(size, mode, settings.threads); });
            auto row = run_case([&](Measure& measure) { return measured(size, mode, settings.threads, measure); });
            row.set("size_px", size);
            row.set("mode", mode.name);
            if (every.is_null())
                every = entry(row, "processor_ms_per_step");
            row.set("times_faster", ratio(every, entry(row, "processor_ms_per_step")));
            row.set("largest_difference", entry(check, "largest_difference"));
            if (const auto note = entry(check, "note"); note.is_string())
                row.set("note", note);
            table.add(std::move(row));
        }
    }
    return table;
}

}  // namespace bench
