#include "pipeline/pipeline_matrix.h"
#include "base/common.h"
#include "base/text.h"
#include <fresco/wording.h>

#include <algorithm>
#include <boost/algorithm/string/classification.hpp>
#include <boost/algorithm/string/trim.hpp>
#include <cctype>
#include <filesystem>
#include <fmt/ranges.h>
#include <map>
#include <set>
#include <span>

namespace fresco::host
{
namespace
{
constexpr std::size_t longest_label = 36;  // bytes; six of them and a stage's name are a file name

bool is_label_byte(char c)
{
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x80 || std::isalnum(byte) != 0 || std::string_view("_-.+=").find(c) != std::string_view::npos;
}

/// Replaces characters that folder names cannot have by dashes.
std::string label_of(const std::string& text)
{
    std::string label;
    for (const char c : text)
        if (is_label_byte(c))
            label += c;
        else if (!label.empty() && label.back() != '-')
            label += '-';
    std::size_t end = std::min(longest_label, label.size());
    while (end < label.size() && !begins_character(label[end]))
        --end;
    label.resize(end);
    return boost::trim_copy_if(label, boost::is_any_of("-."));
}

/// Names that the program itself writes below `--out`.
bool is_taken(const std::string& label)
{
    static const std::set<std::string> own{"preview", "progress", "report.html", "run.json", "sweep.html", "sweep.json"};
    return own.contains(lower_case(label));
}

/// The stem of a path; with `parts` > 0 its name, and with more of them the folders above it too.
std::string end_of_path(const std::string& text, std::size_t parts)
{
    fs::path path = fs::path(text).lexically_normal();
    if (!path.has_filename())
        path = path.parent_path();
    if (parts == 0)
        return path.stem().string();
    const std::vector<std::string> names(path.begin(), path.end());
    return fmt::format("{}", fmt::join(std::span(names).last(std::min(parts, names.size())), "-"));
}

bool is_text(const YamlNode& value)
{
    return value.is_scalar() && resolve_scalar(value).value.is_string();
}

std::vector<std::string> labels_by(const std::string& var, const std::vector<MatrixAxis::Choice>& choices, std::size_t parts)
{
    std::vector<std::string> labels;
    for (std::size_t i = 0; i < choices.size(); ++i)
    {
        const YamlNode& value = choices[i].value;
        const bool number = value.is_scalar() && !is_text(value);
        std::string label = is_text(value) ? label_of(end_of_path(value.text, parts)) : "";
        if (label.empty())
            label = label_of(var + "=" + (number ? value.text : std::to_string(i + 1)));
        labels.push_back(std::move(label));
    }
    return labels;
}

bool are_unique(const std::vector<std::string>& labels)
{
    std::set<std::string> seen;
    return std::ranges::all_of(labels, [&](const std::string& label) { return seen.insert(lower_case(label)).second; });
}

void label(MatrixAxis& axis)
{
    constexpr std::size_t most_parts = 4;
    std::vector<std::string> labels;
    for (std::size_t parts = 0; parts <= most_parts; ++parts)
        if (labels = labels_by(axis.var, axis.choices, parts); are_unique(labels))
            break;
    std::set<std::string> seen;
    std::map<std::string, std::size_t> next_number;
    for (std::size_t i = 0; i < labels.size(); ++i)
    {
        std::string unique = labels[i];
        std::size_t& number = next_number.try_emplace(lower_case(unique), 2).first->second;
        while (is_taken(unique) || !seen.insert(lower_case(unique)).second)
            unique = fmt::format("{}-{}", labels[i], number++);
        axis.choices[i].label = unique;
    }
}

/// Whether every value of the axis is one, no two are the same, and all names fit.
bool read_axis(MatrixAxis& axis, const YamlNode& values, ProblemList& problems)
{
    if (!values.is_valid())
        return false;
    const std::size_t before = problems.size();
    const auto report = [&](const YamlPlace& at, const std::string& text) { problems.add(at, "axis '" + axis.var + "'" + text); };
    std::set<std::string> names;
    for (const YamlNode::Entry& entry : values.entries)
    {
        if (label_of(entry.key) != entry.key || is_taken(entry.key))
            report(entry, fmt::format(": '{}' cannot name a folder of results: use letters, digits, '_', '-', '.', '+' and '=', "
                                      "at most {}, and none of fresco's own names",
                                      entry.key, longest_label));
        if (!names.insert(lower_case(entry.key)).second)
            report(entry, ": '" + entry.key + "' differs from another name only in case");
        axis.choices.push_back({entry.key, entry.value});
    }
    for (const YamlNode& value : values.items)
        axis.choices.push_back({"", value});
    if (!values.is_map() && !values.is_list())
        report(values, " must be a list of values or a map {name: value}, got " + values.summary());
    else if (axis.choices.empty())
        report(values, " has no values");
    bool good = true;
    std::map<std::string, const YamlNode*> seen;
    for (const auto& [name, value, chosen] : axis.choices)
    {
        good = good && value.is_valid();
        const auto [first, fresh] = seen.emplace(value.identity(), &value);
        if (value.is_null())
            report(value, ": empty value");
        else if (!fresh)
            report(value, fmt::format(": {} appears twice; the first is {}", value.summary(),
                                      first->second->line > 0 ? fmt::format("on line {}", first->second->line) : "before it"));
    }
    good = good && problems.size() == before;
    if (good && values.is_list())
        label(axis);
    return good;
}
}  // namespace

std::vector<MatrixAxis> read_matrix(PipelineDocument& document, ProblemList& problems)
{
    const std::vector<std::string> vars = document.vars.keys();
    std::vector<MatrixAxis> axes;
    for (const YamlNode::Entry& entry : document.matrix.entries)
    {
        YamlNode::Entry* var = document.vars.find(entry.key);
        if (!var && document.complete)
            problems.add(entry, "matrix: unknown var '" + entry.key + "'" + problems.hint(entry.key, vars));
        MatrixAxis axis{entry.key, {}};
        const bool good = read_axis(axis, entry.value, problems);
        if (var && good)
            axes.push_back(std::move(axis));
        else if (var)
            var->value.kind = YamlNode::Kind::invalid;
    }
    if (axes.size() > axis_limit)
    {
        problems.add(document.matrix.entries.front(),
                     fmt::format("a matrix of more than {} axes: put some into files of their own", axis_limit));
        axes.resize(axis_limit);
    }
    return axes;
}

void set_axis(MatrixAxis& axis, const YamlNode& value, ProblemList& problems)
{
    if (value.is_list())
    {
        MatrixAxis fresh{axis.var, {}};
        if (read_axis(fresh, value, problems))
            axis = std::move(fresh);
        return;
    }
    const std::vector<std::string> labels = each(axis.choices, &MatrixAxis::Choice::label);
    // One value may be called what another is.
    const bool is_label = std::ranges::find(labels, value.text) != labels.end();
    const auto fits = [&](const MatrixAxis::Choice& choice)
    {
        const bool same = is_label ? choice.label == value.text : choice.value.is_scalar() && choice.value.text == value.text;
        return value.is_scalar() && same;
    };
    if (std::ranges::none_of(axis.choices, fits))
    {
        const std::string what = value.is_scalar() ? "'" + value.text + "'" : value.summary();
        problems.add(value, "the axis '" + axis.var + "' of the matrix has no value " + what + suggestion(value.text, labels) +
                                "; for other values, set a list: --set '" + axis.var + "=[A, B]'");
        return;
    }
    for (MatrixAxis::Choice& choice : axis.choices)
        choice.chosen = fits(choice);
}

std::optional<std::vector<std::vector<std::size_t>>> combinations(const std::vector<MatrixAxis>& axes)
{
    std::vector<std::vector<std::size_t>> result{{}};
    for (const MatrixAxis& axis : axes)
    {
        std::vector<std::vector<std::size_t>> longer;
        for (const auto& combination : result)
            for (std::size_t i = 0; i < axis.choices.size(); ++i)
                if (axis.choices[i].chosen)
                {
                    longer.push_back(combination);
                    longer.back().push_back(i);
                    if (longer.size() > combination_limit)
                        return std::nullopt;
                }
        result = std::move(longer);
    }
    return result;
}

}  // namespace fresco::host
