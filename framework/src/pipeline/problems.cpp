#include "pipeline/problems.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <tuple>
#include <utility>

namespace fresco::host
{

void ProblemList::add(Position position, std::string text, ProblemKind kind)
{
    problems_.push_back({std::move(position), std::move(text), kind});
}

void ProblemList::announce_file(std::string file)
{
    files_.push_back(std::move(file));
}

std::vector<Problem> ProblemList::sorted() const
{
    const auto place = [this](const Problem& problem)
    {
        const auto file = std::ranges::find(files_, problem.position.file) - files_.begin();
        return std::tuple(file, problem.position.line, problem.position.column);
    };
    std::vector<Problem> result = problems_;
    std::ranges::stable_sort(result, [&](const Problem& a, const Problem& b) { return place(a) < place(b); });
    const auto same = [](const Problem& a, const Problem& b) { return a.text == b.text && a.position == b.position; };
    result.erase(std::unique(result.begin(), result.end(), same), result.end());
    return result;
}

std::vector<std::string> told(const std::vector<Problem>& problems)
{
    constexpr std::size_t most_alike = 10;
    std::map<std::pair<Position, ProblemKind>, std::size_t> counts;
    std::vector<std::string> lines;
    for (const Problem& problem : problems)
        if (++counts[{problem.position, problem.kind}] <= most_alike)
            lines.push_back(to_string(problem));
    for (const Problem& problem : problems)
        if (const std::size_t count = std::exchange(counts[{problem.position, problem.kind}], 0); count > most_alike)
            lines.push_back(fmt::format("… and {} more like this: {}", count - most_alike, to_string(problem)));
    return lines;
}

std::string to_string(const Problem& problem)
{
    const Position& at = problem.position;
    const std::string place = at.line > 0 ? fmt::format(":{}:{}", at.line, at.column) : "";
    return at.file + place + (problem.kind == ProblemKind::warning ? ": warning: " : ": error: ") + problem.text;
}

}  // namespace fresco::host
