#include "page.h"

#include "page_parts.h"

#include <fresco/html.h>
#include <fresco/value.h>

#include <algorithm>
#include <utility>

namespace study
{
namespace
{

using fresco::Value;

void replace(std::string& text, std::string_view mark, std::string_view by)
{
    text.replace(text.find(mark), mark.size(), by);
}

Value strata_value(const Study& study)
{
    Value::List strata;
    for (const Comparison& comparison : comparisons(study))
    {
        // By number, so that neither the order of the pairs nor that within a pair gives the methods away.
        Value::List pairs;
        std::vector<std::pair<std::size_t, std::size_t>> sorted;
        for (const auto& [first, second] : comparison.pairs)
            sorted.emplace_back(std::min(first, second), std::max(first, second));
        std::ranges::sort(sorted);
        for (const auto& [one, other] : sorted)
            pairs.emplace_back(Value::List{one, other});
        strata.emplace_back(std::move(pairs));
    }
    return strata;
}

/// By picture's number: [question or null, left, top, width, height].
Value hints_value(const Study& study)
{
    Value::List all;
    for (const Picture& picture : study.pictures)
    {
        Value::List own;
        for (const Hint& hint : study.design.hints)
            if (hint.name == picture.name)
                own.emplace_back(
                    Value::List{hint.question ? Value(*hint.question) : Value(), hint.left, hint.top, hint.width, hint.height});
        all.emplace_back(std::move(own));
    }
    return all;
}

}  // namespace

std::string page(const Study& study, const std::vector<std::string>& pictures)
{
    const Value data = Value::Map{{"study", study.id},
                                  {"questions", Value::List(study.questions.begin(), study.questions.end())},
                                  {"pairs_count", study.pairs_count},
                                  {"mixes_questions", study.design.mixes_questions},
                                  {"hints", hints_value(study)},
                                  {"strata", strata_value(study)},
                                  {"pictures", Value::List(pictures.begin(), pictures.end())}};
    std::string text(page_html);
    replace(text, "<!--STYLE-->", page_css);
    replace(text, "<!--SCRIPT-->", page_js);
    replace(text, "<!--DATA-->", fresco::script_json(data));
    return text;
}

}  // namespace study
