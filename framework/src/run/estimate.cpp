#include "run/estimate.h"
#include "base/glob.h"
#include "pipeline/formula.h"
#include "plugins/declaration.h"
#include <fresco/error.h>

#include <algorithm>

namespace fresco::host
{
namespace
{
std::optional<double> as_number(const Value& value)
{
    if (value.is_bool())
        return value.as_bool() ? 1.0 : 0.0;
    return value.is_number() ? std::optional(value.as_double()) : std::nullopt;
}

/// Frames, faces and heights as the formulas of one stage see them; what no input tells is assumed when it is asked for.
struct Figures
{
    std::optional<double> frames;
    std::optional<double> faces;
    std::optional<double> height_squares;
    bool assumed_frames_used = false;
    bool assumed_faces_used = false;

    double ask_frames()
    {
        assumed_frames_used = assumed_frames_used || !frames;
        return frames.value_or(assumed_frames);
    }
    double ask_faces()
    {
        assumed_faces_used = assumed_faces_used || !faces;
        return faces.value_or(assumed_faces);
    }
};

class StageNames final : public FormulaNames
{
  public:
    StageNames(const PipelineStage& stage, Figures& figures, int cores, std::vector<std::string>& notes)
        : stage_(stage), figures_(figures), cores_(cores), notes_(notes)
    {
    }

    std::optional<double> value(std::string_view name) override
    {
        if (const Value* option = stage_.options.find(name); option && as_number(*option))
            return as_number(*option);
        if (name == "frames")
            return figures_.ask_frames();
        if (name == "faces")
            return figures_.ask_faces();
        if (name == "height_squares")
            return figures_.height_squares.value_or(0);
        if (name == "cores")
            return cores_;
        if (name.ends_with("_count"))
            return over_list(name.substr(0, name.size() - 6), [](double) { return 1.0; });
        if (name.ends_with("_squares"))
            return over_list(name.substr(0, name.size() - 8), [](double entry) { return entry * entry; });
        return std::nullopt;
    }

    std::optional<double> count(std::string_view option, std::string_view glob) override
    {
        const auto files = measure(option, glob);
        return files ? std::optional(static_cast<double>(files->files)) : std::nullopt;
    }

    std::optional<double> bytes(std::string_view option, std::string_view glob) override
    {
        const auto files = measure(option, glob);
        return files ? std::optional(static_cast<double>(files->bytes)) : std::nullopt;
    }

  private:
    template <class Function>
    std::optional<double> over_list(std::string_view option, Function function) const
    {
        const Value* list = stage_.options.find(option);
        if (!list || !list->is_list())
            return std::nullopt;
        double sum = 0;
        for (const Value& entry : list->as_list())
            sum += function(as_number(entry).value_or(0));
        return sum;
    }

    std::optional<GlobMeasure> measure(std::string_view option, std::string_view glob)
    {
        const Value* path = stage_.options.find(option);
        if (!path || !path->is_string())
            return std::nullopt;
        if (path->as_string().empty())
            return GlobMeasure{};
        const auto key = std::pair(std::string(option), std::string(glob));
        const auto known = measured_.find(key);
        if (known != measured_.end())
            return known->second;
        const GlobMeasure result = measure_files(path->as_string(), glob);
        if (result.cut_short)
            notes_.push_back("'" + path->as_string() + "' holds more files than were counted");
        measured_.emplace(key, result);
        return result;
    }

    const PipelineStage& stage_;
    Figures& figures_;
    int cores_;
    std::vector<std::string>& notes_;
    std::map<std::pair<std::string, std::string>, GlobMeasure> measured_;
};

enum class Figure
{
    frames,
    faces
};

/// The first wire of the artifact that is all about the figure goes before others; a wire of the other's artifact says nothing.
std::optional<double> carried(Figure figure, const PipelineStage& stage, const std::map<std::string, const StageEstimate*>& done)
{
    const std::string_view own = figure == Figure::frames ? "frames" : "mesh";
    const std::string_view other = figure == Figure::frames ? "mesh" : "frames";
    std::optional<double> result;
    for (const Wire& wire : stage.wires)
    {
        const auto source = done.find(wire.from_stage);
        if (source == done.end() || wire.artifact == other)
            continue;
        const std::optional<double> value = figure == Figure::frames ? source->second->frames : source->second->faces;
        if (value && wire.artifact == own)
            return value;
        if (!result)
            result = value;
    }
    return result;
}

/// The largest that a wire brings.
std::optional<double> carried_height_squares(const PipelineStage& stage, const std::map<std::string, const StageEstimate*>& done)
{
    std::optional<double> result;
    for (const Wire& wire : stage.wires)
        if (const auto source = done.find(wire.from_stage); source != done.end() && source->second->height_squares)
            result = std::max(result.value_or(0), *source->second->height_squares);
    return result;
}

class StageEstimator
{
  public:
    StageEstimator(const PipelineStage& stage, Figures inputs, int cores, StageEstimate& result)
        : stage_(stage), figures_(inputs), result_(result), names_(stage, figures_, cores, result.notes)
    {
    }

    void run(const MeasuredCost* measured)
    {
        const std::optional<double> own_frames = made("frames", figures_.frames);
        const std::optional<double> own_faces = made("faces", figures_.faces);
        result_.height_squares = made("height_squares", figures_.height_squares);
        result_.frames = measured && measured->frames ? measured->frames : own_frames;
        result_.faces = measured && measured->faces ? measured->faces : own_faces;
        if (stage_.wires.empty())
        {
            figures_.frames = result_.frames;
            figures_.faces = result_.faces;
        }
        result_.measured = measured && measured->seconds;
        result_.seconds = result_.measured ? measured->seconds : cost("seconds");
        result_.memory_mb = measured && measured->memory_mb ? measured->memory_mb : cost("memory_mb");
        result_.disk_mb = measured && measured->disk_mb ? measured->disk_mb : cost("disk_mb");
        if (figures_.assumed_frames_used)
            result_.notes.push_back(number_text(assumed_frames) + " frames assumed: no input says how many");
        if (figures_.assumed_faces_used)
            result_.notes.push_back(number_text(assumed_faces) + " faces assumed: no input says how many");
    }

  private:
    std::string formula(std::string_view name) const
    {
        const Value* cost = stage_.type ? stage_.type->declaration.find("cost") : nullptr;
        const Value* text = cost ? cost->find(name) : nullptr;
        return text && text->is_string() ? text->as_string() : std::string();
    }

    std::optional<double> evaluate(std::string_view name, const std::string& text)
    {
        try
        {
            return std::max(0.0, evaluate_formula(text, names_));
        }
        catch (const Error& error)
        {
            result_.notes.push_back(std::string(name) + " cannot be estimated: " + error.what());
            return std::nullopt;
        }
    }

    std::optional<double> made(std::string_view name, std::optional<double> passed_on)
    {
        const std::string text = formula(name);
        return text.empty() ? passed_on : evaluate(name, text);
    }

    std::optional<double> cost(std::string_view name)
    {
        const std::string text = formula(name);
        return text.empty() ? std::optional(0.0) : evaluate(name, text);
    }

    const PipelineStage& stage_;
    Figures figures_;
    StageEstimate& result_;
    StageNames names_;
};
}  // namespace

PipelineEstimate estimate_pipeline(const Pipeline& pipeline, int cores, const std::map<std::string, MeasuredCost>& measured)
{
    PipelineEstimate result;
    result.stages.resize(pipeline.stages.size());
    std::map<std::string, const StageEstimate*> done;
    for (std::size_t i = 0; i < pipeline.stages.size(); ++i)
    {
        const PipelineStage& stage = pipeline.stages[i];
        StageEstimate& estimate = result.stages[i];
        estimate.stage = stage.name;
        const Figures inputs{carried(Figure::frames, stage, done), carried(Figure::faces, stage, done),
                             carried_height_squares(stage, done)};
        const auto known = measured.find(stage.name);
        StageEstimator(stage, inputs, std::max(cores, 1), estimate).run(known == measured.end() ? nullptr : &known->second);
        done.emplace(stage.name, &estimate);
        result.seconds += estimate.seconds.value_or(0);
        result.memory_mb = std::max(result.memory_mb, estimate.memory_mb.value_or(0));
        result.disk_mb += estimate.disk_mb.value_or(0);
        result.complete = result.complete && estimate.seconds && estimate.memory_mb && estimate.disk_mb;
    }
    return result;
}

}  // namespace fresco::host
