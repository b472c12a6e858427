#include "page.h"

#include "page_parts.h"

#include <fresco/error.h>
#include <fresco/evaluation/posed_pictures.h>
#include <fresco/page/page.h>
#include <fresco/parallel.h>
#include <fresco/value.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

namespace study
{
namespace
{

namespace fs = std::filesystem;
using fresco::Error;
using fresco::Raster8;

std::map<std::string, fs::path> by_stem(const std::vector<fs::path>& files)
{
    return fresco::evaluation::by_stem(files, fresco::evaluation::picture_extensions, "share a name");
}

/// The data URIs of a group, by method.
std::map<std::string, std::string> encoded(const Group& group, const ShownAs& shown, const fresco::ImageIo& images)
{
    std::map<std::string, Raster8> pictures;
    for (const auto& [method, file] : group.files)
        pictures.emplace(method, images.read_rgb(file));
    const auto least = std::ranges::min_element(pictures, {}, [](const auto& entry) { return entry.second.height; });
    const double aspect = static_cast<double>(least->second.width) / least->second.height;
    for (const auto& [method, picture] : pictures)
        if (std::abs(static_cast<double>(picture.width) / picture.height / aspect - 1) > 0.01)
            throw Error(fmt::format("{} is {}x{} and {} is {}x{}: pictures that are compared must show the same view",
                                    group.files.at(method).string(), picture.width, picture.height,
                                    group.files.at(least->first).string(), least->second.width, least->second.height));
    const double scale = std::min(1.0, static_cast<double>(shown.max_px) / std::max(least->second.width, least->second.height));
    const int width = std::max(1, static_cast<int>(std::lround(least->second.width * scale)));
    const int height = std::max(1, static_cast<int>(std::lround(least->second.height * scale)));
    std::map<std::string, std::string> result;
    for (const auto& [method, picture] : pictures)
    {
        const Raster8 small = fresco::resized(picture, width, height);
        const auto bytes = shown.png ? images.encode_png(small) : images.encode_jpeg(small, shown.jpeg_quality);
        result.emplace(method, fresco::page::data_uri(shown.png ? "image/png" : "image/jpeg", bytes));
    }
    return result;
}

}  // namespace

MethodPictures pictures_of(const std::string& method, const fresco::Files& views)
{
    return {method, by_stem(fresco::evaluation::listed(views))};
}

std::vector<MethodPictures> pictures_below(const fs::path& folder, fresco::RunContext& run)
{
    run.reads_folder(folder);
    std::vector<fs::path> subfolders;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.is_directory() && !entry.path().filename().string().starts_with('.'))
            subfolders.push_back(entry.path());
    std::ranges::sort(subfolders);
    std::vector<MethodPictures> methods;
    for (const fs::path& subfolder : subfolders)
        methods.push_back({subfolder.filename().string(),
                           by_stem(fresco::evaluation::listed(subfolder, fresco::evaluation::picture_extensions, run))});
    return methods;
}

std::vector<std::string> encoded_pictures(const Study& study, const std::vector<Group>& groups, const ShownAs& shown,
                                          const fresco::ImageIo& images, fresco::Progress& progress)
{
    std::map<std::pair<std::string, std::string>, std::size_t> number_of;
    for (std::size_t i = 0; i < study.pictures.size(); ++i)
        number_of[{study.pictures[i].method, study.pictures[i].name}] = i;
    std::vector<std::string> pictures(study.pictures.size());
    fresco::parallel_for_each(groups.size(), "views", progress,
                              [&](std::size_t i)
                              {
                                  for (auto& [method, uri] : encoded(groups[i], shown, images))
                                      pictures[number_of.at({method, groups[i].name})] = std::move(uri);
                              });
    return pictures;
}

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
