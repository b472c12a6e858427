#include "pipeline/pipeline_sweep.h"
#include "base/machine.h"
#include "pipeline/pipeline_options.h"
#include "pipeline/pipeline_variables.h"
#include "pipeline/pipeline_wiring.h"

#include <algorithm>
#include <bitset>
#include <fmt/format.h>
#include <ranges>

namespace fresco::host
{
namespace
{
/// Axes by their numbers.
using AxisSet = std::bitset<axis_limit>;

/// For each axis the number of its value.
using Choices = std::vector<std::size_t>;

/// The choices of some axes, as a key: equal where those agree.
Choices chosen_of(const AxisSet& axes, const Choices& choices)
{
    Choices result;
    for (std::size_t axis = 0; axis < choices.size(); ++axis)
        if (axes[axis])
            result.push_back(choices[axis]);
    return result;
}

/// Label of choices: "kitchen,waves".
std::string label_of(const AxisSet& axes, const Choices& choices, const std::vector<MatrixAxis>& matrix)
{
    std::string text;
    for (std::size_t axis = 0; axis < choices.size(); ++axis)
        if (axes[axis])
            text += (text.empty() ? "" : ",") + matrix[axis].choices[choices[axis]].label;
    return text;
}

/// Vars, each with the names in its value; of an axis, in all of its values.
using VarNames = std::map<std::string, std::set<std::string>>;

/// The vars among `names`, and those that their values name, directly or not.
std::set<std::string> reached_from(const std::set<std::string>& names, const VarNames& vars)
{
    // Not by recursion: a file may hold a chain of vars that is longer than the machine's stack.
    std::set<std::string> reached;
    for (std::vector<std::string> open(names.begin(), names.end()); !open.empty();)
    {
        const auto var = vars.find(open.back());
        open.pop_back();
        if (var != vars.end() && reached.insert(var->first).second)
            open.insert(open.end(), var->second.begin(), var->second.end());
    }
    return reached;
}

/// A stage as all combinations have it that agree in the axes whose vars it names.
struct CheckedStage
{
    StageDraft draft;     ///< With name, type, `input`, position and the wires from files.
    PipelineStage stage;  ///< Without name and place; its wires are those from files.
};

/// Stages that were checked together.
struct Batch
{
    std::size_t first_stage = 0;  ///< The number of its first CheckedStage.
    std::vector<Problem> problems;
};

/// Parts of one combination.
struct CombinationDraft
{
    Choices choices;
    std::vector<std::size_t> stages{};  ///< Per stage of the file, the number of its CheckedStage.
    std::vector<std::size_t> order{};
    std::vector<std::vector<Wire>> wires{};  ///< Per stage; only from stages, by their names in the file.
};

/// Makes one pipeline of a matrix's combinations; without a matrix there is one, which has no values. A stage depends on the axes
/// whose vars it names, directly or through other vars, and on those of the stages it reads; it is there once for each
/// combination of their values, and is named and placed by these. It is checked once for each combination of the values that it
/// names, and wired once for each combination.
class SweepBuilder
{
  public:
    /// All of them must outlive it.
    SweepBuilder(const PipelineDocument& document, const std::vector<MatrixAxis>& matrix, const Settings& settings,
                 TypeTable& types)
        : document_(document), matrix_(matrix), settings_(settings), types_(types)
    {
        VarNames vars;
        for (const YamlNode::Entry& entry : document.vars.entries)
            vars[entry.key] = vars_named_in(entry.value);
        for (const MatrixAxis& axis : matrix)
        {
            vars[axis.var].clear();
            for (const MatrixAxis::Choice& choice : axis.choices)
                vars[axis.var].merge(vars_named_in(choice.value));
        }
        const auto names = std::views::keys(vars);
        std::set<std::string> unused(names.begin(), names.end());
        for (std::size_t i = 0; i < document.stages.entries.size(); ++i)
        {
            const YamlNode::Entry& entry = document.stages.entries[i];
            std::set<std::string> named = vars_named_in(entry.value);
            named.merge(settings.vars_in(entry.key));
            named.merge(vars_named_in(document.components));
            named.merge(settings.vars_in(std::string(pipeline_components)));
            const std::set<std::string> reached = reached_from(named, vars);
            AxisSet& axes = axes_.emplace_back();
            for (std::size_t axis = 0; axis < matrix.size(); ++axis)
                axes[axis] = reached.contains(matrix[axis].var);
            groups_[axes.to_ulong()].stages.push_back(i);
            for (const std::string& name : reached)
                unused.erase(name);
        }
        for (const std::string& name : unused)
        {
            const std::set<std::string> reached = reached_from({name}, vars);
            AxisSet axes;
            for (std::size_t axis = 0; axis < matrix.size(); ++axis)
                axes[axis] = reached.contains(matrix[axis].var);
            groups_[axes.to_ulong()].unused_vars.insert(name);
        }
    }

    void add(const Choices& choices)
    {
        CombinationDraft& cell = members_.emplace_back(CombinationDraft{choices});
        cell.stages.resize(axes_.size());
        for (auto& [axes, group] : groups_)
        {
            const auto [batch, fresh] = group.batches.try_emplace(chosen_of(AxisSet(axes), choices));
            if (fresh)
                batch->second = make_batch(group, choices);
            note(batch->second.problems);
            for (std::size_t i = 0; i < group.stages.size(); ++i)
                cell.stages[group.stages[i]] = batch->second.first_stage + i;
        }
        note(wire(cell));
        note(colliding_outputs(cell));
    }

    /// Leaves out the combinations that lack an input, where that is all that is wrong and others remain. Reports what they lack;
    /// whether there were some.
    bool leave_out_incomplete(ProblemList& missing)
    {
        std::set<std::size_t> incomplete;
        for (const auto& [problem, members] : problems_)
        {
            if (problem.kind != ProblemKind::missing_input)
                return false;
            incomplete.insert(members.begin(), members.end());
        }
        if (incomplete.empty() || incomplete.size() == members_.size())
            return false;
        report(missing);
        problems_.clear();
        std::vector<CombinationDraft> complete;
        for (std::size_t member = 0; member < members_.size(); ++member)
            if (!incomplete.contains(member))
                complete.push_back(std::move(members_[member]));
        members_ = std::move(complete);
        return true;
    }

    /// Every problem once; one that not all combinations have says which values they have in common.
    void report(ProblemList& problems) const
    {
        for (const auto& [problem, members] : problems_)
        {
            std::string common;
            for (std::size_t axis = 0; axis < matrix_.size() && members.size() < members_.size(); ++axis)
            {
                const std::size_t choice = members_[members.front()].choices[axis];
                const bool same =
                    std::ranges::all_of(members, [&](std::size_t member) { return members_[member].choices[axis] == choice; });
                if (same)
                    common += (common.empty() ? " (with " : ", ") + matrix_[axis].var + " '" +
                              matrix_[axis].choices[choice].label + "'";
            }
            problems.add(problem.position, problem.text + (common.empty() ? "" : common + ")"), problem.kind);
        }
    }

    /// Call once, and only where no combination has a problem.
    void build(Pipeline& pipeline)
    {
        for (std::size_t i = 0; i < document_.stages.entries.size(); ++i)
            numbers_[document_.stages.entries[i].key] = i;
        const std::vector<AxisSet> axes = spread_axes();
        const AxisSet all = AxisSet().set();
        for (std::size_t i = 0; i < document_.stages.entries.size() && !matrix_.empty(); ++i)
            for (std::size_t axis = 0; axis < matrix_.size(); ++axis)
                if (axes[i][axis])
                    pipeline.sweep.stage_axes[document_.stages.entries[i].key].push_back(matrix_[axis].var);
        std::vector<std::map<Choices, std::size_t>> places(axes.size());
        for (const CombinationDraft& member : members_)
        {
            Combination combination{label_of(all, member.choices, matrix_), {}, {}};
            for (std::size_t axis = 0; axis < matrix_.size(); ++axis)
                combination.values.push_back(matrix_[axis].choices[member.choices[axis]].label);
            for (const std::size_t stage : member.order)
            {
                const auto [place, fresh] =
                    places[stage].try_emplace(chosen_of(axes[stage], member.choices), pipeline.stages.size());
                combination.stages.push_back(place->second);
                if (fresh)
                    pipeline.stages.push_back(stage_of(member, stage, axes));
            }
            if (!matrix_.empty())
                pipeline.sweep.combinations.push_back(std::move(combination));
        }
    }

  private:
    /// Stages that depend on the same axes, and unused vars: checked together, with one budget for what vars grow to.
    struct Group
    {
        std::vector<std::size_t> stages;
        std::set<std::string> unused_vars;
        std::map<Choices, Batch> batches;
    };

    Batch make_batch(const Group& group, const Choices& choices)
    {
        ProblemList problems;
        Variables variables(document_.vars, problems);
        for (std::size_t axis = 0; axis < matrix_.size(); ++axis)
            variables.choose(matrix_[axis].var, matrix_[axis].choices[choices[axis]].value);
        YamlNode written = document_.stages;
        written.entries.clear();
        for (const std::size_t stage : group.stages)
            written.entries.push_back(document_.stages.entries[stage]);
        YamlNode settled = variables.substitute(written);
        for (YamlNode::Entry& entry : settled.entries)
            settings_.set_options(entry.key, entry.value, variables, types_, problems);
        variables.check_unused(group.unused_vars);
        const std::size_t first = stages_.size();
        YamlNode components = variables.substitute(document_.components);
        settings_.set_components(components, variables, types_, problems);
        const auto chosen = std::make_shared<const YamlNode>(components);
        OptionChecker checker(types_, std::move(components), problems);
        for (std::size_t i = 0; i < group.stages.size(); ++i)
        {
            add_stage(group.stages[i], std::move(settled.entries[i].value), checker, problems);
            stages_.back().stage.chosen_components = chosen;
        }
        return {first, problems.sorted()};
    }

    void add_stage(std::size_t stage, YamlNode config, OptionChecker& checker, ProblemList& problems)
    {
        const YamlNode::Entry& entry = document_.stages.entries[stage];
        CheckedStage& checked = stages_.emplace_back();
        StageDraft& draft = checked.draft;
        draft.name = entry.key;
        draft.position = entry;
        draft.config = std::move(config);
        if (draft.config.is_map())
        {
            // Missing keys of the stage are reported at its name.
            draft.config.stand_at(entry);
            if (const auto type = type_named_by(draft.config, draft.title(), &problems))
                draft.type = types_.require(*type, "stage", draft.title(), draft.config.find("type")->value, problems);
            if (draft.type)
            {
                draft.options = checker.complete(draft.type, draft.config, {"type", "input"}, draft.title(), draft.uses);
                settle_device(*draft.type.description, draft.options, machine_has_gpu);
                settle_declared_ports(draft, types_, problems);
            }
            wire_files(draft, types_, checker, problems);
        }
        PipelineStage& beginning = checked.stage;
        beginning.own_name = draft.name;
        beginning.type = draft.type.description;
        beginning.own_type = draft.own_type;
        beginning.position = draft.position;
        beginning.options = std::make_shared<const Value>(std::move(draft.options));
        const std::set<std::filesystem::path> files(draft.uses.input_files.begin(), draft.uses.input_files.end());
        beginning.input_files.assign(files.begin(), files.end());
        beginning.components.assign(draft.uses.components.begin(), draft.uses.components.end());
        std::ranges::sort(beginning.components, {}, &TypeDescription::type);
        beginning.wires = draft.wires;
        beginning.outputs = std::move(draft.uses.outputs);
        draft.options = {};
        draft.uses = {};
        std::erase_if(draft.config.entries, [](const YamlNode::Entry& each) { return each.key != "input"; });
    }

    /// Wires the stages of a combination.
    std::vector<Problem> wire(CombinationDraft& cell) const
    {
        std::vector<StageDraft> stages = each(cell.stages, [&](std::size_t stage) { return stages_[stage].draft; });
        ProblemList problems;
        wire_stages(stages, document_.dropped, problems);
        cell.order = check_graph(stages, problems).order();
        for (StageDraft& stage : stages)
        {
            std::erase_if(stage.wires, [](const Wire& wire) { return wire.from_stage.empty(); });
            cell.wires.push_back(std::move(stage.wires));
        }
        return problems.sorted();
    }

    std::vector<Problem> colliding_outputs(const CombinationDraft& cell) const
    {
        ProblemList problems;
        OutputOwners owners;
        for (std::size_t i = 0; i < cell.stages.size(); ++i)
            for (const PipelineStage::Output& output : stages_[cell.stages[i]].stage.outputs)
                if (const auto collision =
                        owners.claim(output.name, document_.stages.entries[i].key, output.is_file, output.option))
                    problems.add(output.position, *collision);
        return problems.sorted();
    }

    /// Notes the problems of the combination that was added last.
    void note(const std::vector<Problem>& problems)
    {
        const std::size_t member = members_.size() - 1;
        for (const Problem& problem : problems)
        {
            const auto [known, fresh] = known_problems_.emplace(to_string(problem), problems_.size());
            if (fresh)
                problems_.push_back({problem, {}});
            std::vector<std::size_t>& members = problems_[known->second].second;
            if (members.empty() || members.back() != member)
                members.push_back(member);
        }
    }

    /// Adds to every stage the axes that its inputs depend on.
    std::vector<AxisSet> spread_axes() const
    {
        std::vector<AxisSet> axes = axes_;
        for (bool again = true; again;)
        {
            again = false;
            for (const CombinationDraft& member : members_)
                for (const std::size_t stage : member.order)
                    for (const Wire& wire : member.wires[stage])
                    {
                        const AxisSet before = axes[stage];
                        axes[stage] |= axes[numbers_.at(wire.from_stage)];
                        again = again || axes[stage] != before;
                    }
        }
        return axes;
    }

    PipelineStage stage_of(const CombinationDraft& member, std::size_t number, const std::vector<AxisSet>& axes) const
    {
        const CheckedStage& checked = stages_[member.stages[number]];
        PipelineStage stage = checked.stage;
        stage.name = name_of(number, member.choices, axes);
        stage.place = label_of(axes[number], member.choices, matrix_);
        for (Wire wire : member.wires[number])
        {
            wire.from_stage = name_of(numbers_.at(wire.from_stage), member.choices, axes);
            stage.wires.push_back(std::move(wire));
        }
        const TypeDeclaration& type = *checked.draft.type.declaration;
        const auto place = [&](const Wire& wire) { return type.input(wire.port) - type.inputs.data(); };
        std::ranges::sort(stage.wires, [&](const Wire& a, const Wire& b) { return place(a) < place(b); });
        return stage;
    }

    std::string name_of(std::size_t stage, const Choices& choices, const std::vector<AxisSet>& axes) const
    {
        std::string name = document_.stages.entries[stage].key;
        if (axes[stage].any())
            name.append("@").append(label_of(axes[stage], choices, matrix_));
        return name;
    }

    const PipelineDocument& document_;
    const std::vector<MatrixAxis>& matrix_;
    const Settings& settings_;
    TypeTable& types_;
    std::vector<AxisSet> axes_;              ///< Per stage, those that it names.
    std::map<unsigned long, Group> groups_;  ///< By the axes.
    std::vector<CheckedStage> stages_;
    std::map<std::string, std::size_t> numbers_;  ///< Numbers of stages, by name.
    std::vector<CombinationDraft> members_;
    std::vector<std::pair<Problem, std::vector<std::size_t>>> problems_;  ///< With the members that have it.
    std::map<std::string, std::size_t> known_problems_;
};

}  // namespace

void load_stages(const PipelineDocument& document, const std::vector<MatrixAxis>& matrix, const Settings& settings,
                 TypeTable& types, Pipeline& pipeline, ProblemList& problems, ProblemList* missing)
{
    const auto cells = combinations(matrix);
    if (!cells)
        return problems.add(document.matrix.entries.front(),
                            fmt::format("the matrix has more than {} combinations", combination_limit));
    SweepBuilder builder(document, matrix, settings, types);
    for (const Choices& choices : *cells)
        builder.add(choices);
    const bool some_left_out = missing != nullptr && problems.empty() && builder.leave_out_incomplete(*missing);
    builder.report(problems);
    if (!problems.empty())
        return;
    builder.build(pipeline);
    for (const MatrixAxis& axis : matrix)
        pipeline.sweep.axes.push_back(axis.var);
    pipeline.sweep.narrowed =
        some_left_out || std::ranges::any_of(matrix, [](const MatrixAxis& axis)
                                             { return !std::ranges::all_of(axis.choices, &MatrixAxis::Choice::chosen); });
}

}  // namespace fresco::host
