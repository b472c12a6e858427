#include "run/estimate.h"
#include "base/glob.h"
#include "plugins/declaration.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string_view>

namespace fresco::host
{
namespace
{

struct SizeKind
{
    std::string_view name;  ///< Of the entry in `cost`.
    std::string_view rate;
    double assumed;                    ///< Where nothing says how many.
    std::string_view artifact;         ///< Whose wires carry this size and no other, …
    std::string_view last_artifact{};  ///< … and whose carry it where no other wire does.
};
constexpr std::array<SizeKind, 4> size_kinds{{{"frames", "per_frame", 300, "frames"},
                                              {"faces", "per_face", 1e6, "mesh"},
                                              {"texels", "per_texel", 2048 * 2048, "", "mesh"},
                                              {"pixels", "per_pixel", 640 * 480, ""}}};
using Sizes = std::array<std::optional<double>, size_kinds.size()>;

/// Each once, in their order.
class Notes
{
  public:
    void add(const std::string& note)
    {
        if (known_.insert(note).second)
            list.push_back(note);
    }

    std::vector<std::string> list;

  private:
    std::set<std::string> known_;
};

class StageEstimator
{
    /// Place in size_kinds.
    enum Kind
    {
        frames,
        faces,
        texels,
        pixels
    };

  public:
    StageEstimator(const PipelineStage& stage, const Sizes& incoming, int cores, Notes& notes)
        : stage_(stage), incoming_(incoming), cores_(cores), notes_(notes)
    {
    }

    CostFigures run(Sizes& made)
    {
        const Value* cost = stage_.type ? stage_.type->declaration.find("cost") : nullptr;
        if (cost == nullptr)
        {
            made = incoming_;
            return {};
        }
        for (std::size_t kind = 0; kind < size_kinds.size(); ++kind)
        {
            const Value& size = cost->at(size_kinds[kind].name);
            made[kind] = size.is_null() ? incoming_[kind] : counted(size, Kind(kind));
            if (kind == texels || kind == pixels || !incoming_[kind])
                incoming_[kind] = made[kind];
        }
        steps_ = cost->at("steps");
        const double share = cost->at("parallel_share").as_double();
        CostFigures figures;
        figures.seconds = total(cost->at("seconds"), incoming_, true) * (1 - share + share / cores_);
        figures.memory_mb = total(cost->at("memory_mb"), incoming_, false);
        figures.disk_mb = total(cost->at("disk_mb"), made, true);
        return figures;
    }

  private:
    double number(const Value& option) const { return stage_.options->at(option.as_string()).as_double(); }

    /// The size, or what is assumed, which is noted.
    double known(const Sizes& sizes, Kind kind)
    {
        if (sizes[kind])
            return *sizes[kind];
        const std::string note = stage_.own_name + ": " + number_text(size_kinds[kind].assumed) + " " +
                                 std::string(size_kinds[kind].name) + " assumed: no input says how many";
        notes_.add(note);
        return size_kinds[kind].assumed;
    }

    double squares(const Value& option) const
    {
        const auto square = [](const Value& value) { return value.as_double() * value.as_double(); };
        if (!option.is_list())
            return square(option);
        double sum = 0;
        for (const Value& entry : option.as_list())
            sum += square(entry);
        return sum;
    }

    double measured_files(const Value& size)
    {
        const std::string folder = stage_.options->at(size.at("files").as_string()).as_string();
        const GlobMeasure measure = measure_files(folder, size.at("pattern").as_string());
        if (measure.cut_short)
            notes_.add(stage_.name + ": '" + folder + "' holds more files than were counted");
        const double each = size.at("bytes_each").as_double();
        return each > 0 ? static_cast<double>(measure.bytes) / each : static_cast<double>(measure.files);
    }

    std::optional<double> base(const Value& size, Kind kind)
    {
        if (const double number = size.at("number").as_double(); number > 0)
            return number;
        if (!size.at("option").as_string().empty())
            return number(size.at("option"));
        if (!size.at("files").as_string().empty())
            return measured_files(size);
        if (const Value& option = size.at("squares_of"); !option.as_string().empty())
        {
            // 0, or an empty list, stands for what the inputs have.
            const double sum = squares(stage_.options->at(option.as_string()));
            return sum > 0 ? std::optional(kind == pixels ? sum * 4 / 3 : sum) : incoming_[kind];
        }
        return incoming_[kind] = known(incoming_, kind);
    }

    std::optional<double> counted(const Value& size, Kind kind)
    {
        std::optional<double> count = base(size, kind);
        if (!count)
            return count;
        for (const Value& option : size.at("times").as_list())
            *count *= number(option);
        for (const Value& option : size.at("divided_by").as_list())
            if (const double divisor = number(option); divisor > 0)
                *count /= divisor;
        if (const Value& option = size.at("at_most"); !option.as_string().empty() && number(option) > 0)
            *count = std::min(*count, number(option));
        return count;
    }

    double pictures(const Sizes& sizes) { return steps_.is_null() ? known(sizes, frames) : *counted(steps_, frames); }

    double total(const Value& rates, const Sizes& sizes, bool of_every_picture)
    {
        double sum = rates.at("fixed").as_double() + rates.at("per_core").as_double() * cores_;
        for (std::size_t kind = 0; kind < size_kinds.size(); ++kind)
            if (const double rate = rates.at(size_kinds[kind].rate).as_double(); rate > 0)
                sum += rate * known(sizes, Kind(kind)) * (kind == pixels && of_every_picture ? pictures(sizes) : 1);
        if (const double rate = rates.at("per_step").as_double(); rate > 0)
            sum += rate * pictures(sizes);
        return sum;
    }

    const PipelineStage& stage_;
    Sizes incoming_;
    int cores_;
    Notes& notes_;
    Value steps_;
};

/// A wire of the artifact that is all about a size goes before others.
Sizes carried(const PipelineStage& stage, const std::map<std::string, Sizes>& made)
{
    Sizes result, own, last;
    for (const Wire& wire : stage.wires)
        if (const auto source = made.find(wire.from_stage); source != made.end())
        {
            const auto about = std::ranges::find(size_kinds, std::string_view(wire.artifact), &SizeKind::artifact);
            for (std::size_t kind = 0; kind < size_kinds.size(); ++kind)
            {
                Sizes& into = about == size_kinds.end() ? result : own;
                if (!into[kind] && (about == size_kinds.end() || about == &size_kinds[kind]))
                    into[kind] = source->second[kind];
                if (!last[kind] && wire.artifact == size_kinds[kind].last_artifact)
                    last[kind] = source->second[kind];
            }
        }
    for (std::size_t kind = 0; kind < size_kinds.size(); ++kind)
        if (own[kind] || !result[kind])
            result[kind] = own[kind] ? own[kind] : last[kind];
    return result;
}

}  // namespace

PipelineEstimate estimate_pipeline(const Pipeline& pipeline, int cores)
{
    PipelineEstimate result;
    Notes notes;
    std::map<std::string, Sizes> made;
    for (const PipelineStage& stage : pipeline.stages)
        result.stages[stage.name] = StageEstimator(stage, carried(stage, made), std::max(cores, 1), notes).run(made[stage.name]);
    result.notes = std::move(notes.list);
    return result;
}

}  // namespace fresco::host
