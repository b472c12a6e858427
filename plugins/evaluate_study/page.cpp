#include "page.h"

#include "page_parts.h"

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

/// JSON that may stand in a script element: "<" could end it.
std::string script_json(const Value& value)
{
    std::string text = fresco::to_json(value);
    for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at))
        text.replace(at, 1, "\\u003c");
    return text;
}

Value strata_value(const Study& study)
{
    Value::List strata;
    for (const Comparison& comparison : comparisons(study))
    {
        // By number, so that neither the order of the pairs nor that within a pair tells the methods.
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

}  // namespace

std::string data_uri(std::string_view media_type, std::span<const std::byte> bytes)
{
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text = "data:" + std::string(media_type) + ";base64,";
    text.reserve(text.size() + (bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3)
    {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        unsigned bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8U | (k < count ? std::to_integer<unsigned>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k)
            text += k <= count ? digits[bits >> (18 - 6 * k) & 63U] : '=';
    }
    return text;
}

std::string page(const Study& study, const std::vector<std::string>& pictures)
{
    const Value data = Value::Map{{"study", study.id},
                                  {"questions", Value::List(study.questions.begin(), study.questions.end())},
                                  {"pairs_count", study.pairs_count},
                                  {"strata", strata_value(study)},
                                  {"pictures", Value::List(pictures.begin(), pictures.end())}};
    std::string text(page_html);
    replace(text, "<!--STYLE-->", page_css);
    replace(text, "<!--SCRIPT-->", page_js);
    replace(text, "<!--DATA-->", script_json(data));
    return text;
}

}  // namespace study
