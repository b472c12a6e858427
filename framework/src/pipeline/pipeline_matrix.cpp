#include "pipeline/pipeline_matrix.h"
#include "base/common.h"
#include "base/text.h"
#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <set>

namespace fresco::host
{
namespace
{
constexpr std::size_t longest_label = 36;  // bytes; six of them and a stage's name are a file name

bool is_label_byte(char c)
{
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    return letter || static_cast<unsigned char>(c) >= 0x80 || std::string_view("_-.+=").find(c) != std::string_view::npos;
}

/// What is left of a text when all that has no place in the name of a folder is a dash.
std::string label_of(const std::string& text)
{
    std::string label;
    for (const char c : text)
        if (is_label_byte(c))
            label += c;
        else if (!label.empty() && label.back() != '-')
            label += '-';
    label.resize(utf8_prefix(label, longest_label).size());
    const std::size_t begin = std::min(label.find_first_not_of("-."), label.size());
    label.erase(0, begin);
    while (!label.empty() && (label.back() == '-' || label.back() == '.'))
        label.pop_back();
    return label;
}

/// What the program itself writes below `--out`.
bool is_taken(const std::string& label)
{
    static const std::set<std::string> own{"preview", "report.html", "run.json", "sweep.html", "sweep.json"};
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
    std::vector<std::string> names;
    for (const fs::path& part : path)
        names.push_back(part.string());
    std::string result;
    for (std::size_t i = names.size() - std::min(parts, names.size()); i < names.size(); ++i)
        result += (result.empty() ? "" : "-") + names[i];
    return result;
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

std::string place_text(const YamlNode& node)
{
    return node.line > 0 ? "on line " + std::to_string(node.line) : "before it";
}

/// Whether every value of the axis is one, and no two are the same.
bool check_values(const MatrixAxis& axis, ProblemList& problems)
{
    bool good = true;
    const auto report = [&](const YamlNode& value, const std::string& text)
    {
        problems.add(value.position(), "axis '" + axis.var + "': " + text);
        good = false;
    };
    std::map<std::string, const YamlNode*> seen;
    for (const MatrixAxis::Choice& choice : axis.choices)
    {
        const YamlNode& value = choice.value;
        if (value.is_null())
            report(value, "empty value");
        else if (const auto [first, fresh] = seen.emplace(value.identity(), &value); !fresh)
            report(value, value.summary() + " appears twice; the first is " + place_text(*first->second));
        good = good && value.is_valid();
    }
    return good;
}

bool read_named(MatrixAxis& axis, const YamlNode& map, ProblemList& problems)
{
    bool good = true;
    std::set<std::string> seen;
    for (const YamlNode::Entry& entry : map.entries)
    {
        const bool fits = label_of(entry.key) == entry.key && !is_taken(entry.key);
        if (!fits)
            problems.add(entry.position(), fmt::format("axis '{}': '{}' cannot name a folder of results: use letters, digits, "
                                                       "'_', '-', '.', '+' and '=', at most {}, and none of fresco's own names",
                                                       axis.var, entry.key, longest_label));
        const bool fresh = seen.insert(lower_case(entry.key)).second;
        if (!fresh)
            problems.add(entry.position(), "axis '" + axis.var + "': '" + entry.key + "' differs from another name only in case");
        good = good && fits && fresh;
        axis.choices.push_back({entry.key, entry.value});
    }
    return good;
}

bool read_axis(MatrixAxis& axis, const YamlNode& values, ProblemList& problems)
{
    if (!values.is_valid())
        return false;
    bool good = true;
    if (values.is_map())
        good = read_named(axis, values, problems);
    else if (values.is_list())
        for (const YamlNode& value : values.items)
            axis.choices.push_back({"", value});
    else
    {
        problems.add(values.position(),
                     "axis '" + axis.var + "' must be a list of values or a map {name: value}, got " + values.summary());
        return false;
    }
    if (axis.choices.empty())
    {
        problems.add(values.position(), "axis '" + axis.var + "' has no values");
        return false;
    }
    good = check_values(axis, problems) && good;
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
        {
            std::string hint = vars.empty() ? ": declare it under 'vars'" : "";
            if (problems.takes_hints())
                hint += suggestion(entry.key, vars);
            problems.add(entry.position(), "matrix: unknown var '" + entry.key + "'" + hint);
        }
        MatrixAxis axis{entry.key, {}};
        const bool good = read_axis(axis, entry.value, problems);
        if (var && good)
            axes.push_back(std::move(axis));
        else if (var)
            var->value.kind = YamlNode::Kind::invalid;
    }
    if (axes.size() > axis_limit)
    {
        problems.add(document.matrix.entries.front().position(),
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
    std::vector<std::string> labels;
    for (const MatrixAxis::Choice& choice : axis.choices)
        labels.push_back(choice.label);
    // One value may be called what another is.
    const bool is_label = std::find(labels.begin(), labels.end(), value.text) != labels.end();
    const auto fits = [&](const MatrixAxis::Choice& choice)
    {
        const bool same = is_label ? choice.label == value.text : choice.value.is_scalar() && choice.value.text == value.text;
        return value.is_scalar() && same;
    };
    if (std::none_of(axis.choices.begin(), axis.choices.end(), fits))
    {
        const std::string what = value.is_scalar() ? "'" + value.text + "'" : value.summary();
        problems.add(value.position(), "the axis '" + axis.var + "' of the matrix has no value " + what +
                                           suggestion(value.text, labels) + "; for other values, set a list: --set '" + axis.var +
                                           "=[A, B]'");
        return;
    }
    for (MatrixAxis::Choice& choice : axis.choices)
        choice.chosen = fits(choice);
}

std::vector<std::vector<std::size_t>> combinations(const std::vector<MatrixAxis>& axes)
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
                        throw Error(fmt::format("the matrix has more than {} combinations", combination_limit));
                }
        result = std::move(longer);
    }
    return result;
}

}  // namespace fresco::host
